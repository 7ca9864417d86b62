#include "model/train/stgcn/read_generator.h"

#include <cstring>
#include <string>
#include <utility>

#include "model/net/stgcn/code_space.h"
#include "model/net/stgcn/network.h"
#include "model/net/weights_file.h"
#include "model/train/checkpoint.h"
#include "model/train/stgcn/weights.h"

namespace styled::train::st_gcn {

using torch::Tensor;

void CopyFloats(const net::SafetensorsView& view, const std::string& name, const Tensor& to) {
  const net::TensorView& tensor = view.tensors.at(name);
  const Tensor floats = torch::empty(tensor.shape);
  TORCH_CHECK(tensor.bytes.size() == floats.nbytes(), "tensor '", name, "' is not float32");
  std::memcpy(floats.data_ptr(), tensor.bytes.data(), tensor.bytes.size());
  to.copy_(floats);
}

void CopyStatistics(const net::SafetensorsView& view, Statistics& statistics) {
  for (const auto& [name, to] : {std::pair{"features.mean", &statistics.mean},
                                 std::pair{"features.deviation", &statistics.deviation}}) {
    CopyFloats(view, name, torch::from_blob(to->data(), {body::kJointCount, stgcn::kChannels}));
  }
}

Result<LoadedGenerator> ReadGenerator(const std::filesystem::path& file) {
  const Result<std::vector<std::byte>> bytes = net::ReadFile(file);
  if (!bytes.ok()) return bytes.status();
  const auto opened = net::ParseWeights(bytes.value(), file.string());
  if (!opened.ok()) return opened.status();
  const std::string& family = opened.value().model.family;
  if (family != kFamily) {
    return Status::Error(file.string() + ": key 'family': expected \"" + kFamily + "\", found \"" +
                         family + "\"");
  }
  // Its tensors go on into a network for streams, whose file format has one normalization.
  const auto normalization = opened.value().header.find("normalization");
  if (normalization != opened.value().header.end() && *normalization != "neighbours") {
    return Status::Error(file.string() + ": key 'normalization': expected \"neighbours\", found " +
                         net::Shown(*normalization));
  }
  const auto network = stgcn::Network::Parse(bytes.value(), file.string());
  if (!network.ok()) return network.status();
  try {
    const torch::NoGradGuard no_grad;
    const net::SafetensorsView& view = opened.value().view;
    Shape shape;
    shape.domains = network.value()->space().domain_count();
    shape.width = network.value()->width();
    LoadedGenerator loaded;
    loaded.generator = std::make_unique<Generator>(shape, torch::kCPU);
    loaded.generator->parameters.RequireGradient(false);
    for (const auto& [name, tensor] : loaded.generator->parameters.named()) {
      CopyFloats(view, name, tensor);
    }
    loaded.model = network.value()->model();
    loaded.parameters = network.value()->features();
    CopyStatistics(view, loaded.statistics);
    loaded.codes = torch::empty({shape.domains, shape.code});
    CopyFloats(view, "codes.mean", loaded.codes);
    for (const auto& [name, tensor] : view.tensors) {
      if (!name.starts_with("e.") && !name.starts_with("f.")) continue;
      CopyFloats(view, name, loaded.space.emplace_back(name, torch::empty(tensor.shape)).second);
    }
    return loaded;
  } catch (const std::exception& failure) {
    return Status::Error(file.string() + ": " + Reason(failure));
  }
}

}  // namespace styled::train::st_gcn
