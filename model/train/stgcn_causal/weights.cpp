#include "model/train/stgcn_causal/weights.h"

#include <nlohmann/json.hpp>

#include "model/train/checkpoint.h"
#include "model/train/safetensors_write.h"
#include "model/train/stgcn_causal/student.h"

namespace styled::train::st_gcn_causal {

Status ExportWeights(const Checkpoint& checkpoint, const std::filesystem::path& file) {
  try {
    const torch::NoGradGuard no_grad;
    const auto& t = checkpoint.tensors;
    const std::string& metadata = checkpoint.strings.at("metadata");
    const nlohmann::json header = nlohmann::json::parse(metadata);
    st_gcn::Shape shape;
    shape.domains = static_cast<int64_t>(header.at("styles").size());
    shape.width = header.at("width");
    shape.code = header.at("code");
    const Student student(shape, torch::kCPU);
    const torch::Tensor& flat = t.at("average");
    TORCH_CHECK(flat.sizes() == student.parameters.flat().sizes(), "is of another width");
    student.parameters.flat().copy_(flat);
    NamedTensors tensors{{"features.mean", t.at("mean")},
                         {"features.deviation", t.at("deviation")},
                         {"codes.mean", t.at("codes.mean")}};
    for (const auto& named : student.parameters.named()) tensors.push_back(named);
    for (const auto& [name, tensor] : t) {
      if (name.starts_with(kTeachers)) tensors.emplace_back(name.substr(kTeachers.size()), tensor);
    }
    return WriteSafetensors(tensors, metadata, file);
  } catch (const std::exception& failure) {
    return Status::Error(Reason(failure));
  }
}

}  // namespace styled::train::st_gcn_causal
