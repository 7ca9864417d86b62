#include "model/train/safetensors_write.h"

#include "model/net/safetensors.h"

namespace styled::train {

Status WriteSafetensors(const NamedTensors& tensors, const std::string& metadata,
                        const std::filesystem::path& file) {
  std::vector<net::NamedTensor> plain;
  for (const auto& [name, tensor] : tensors) {
    const torch::Tensor values = tensor.detach().cpu().to(torch::kFloat32).contiguous();
    const float* const begin = values.data_ptr<float>();
    plain.push_back({name, values.sizes().vec(), {begin, begin + values.numel()}});
  }
  return net::WriteSafetensors(file, plain, {{"styled", metadata}});
}

}  // namespace styled::train
