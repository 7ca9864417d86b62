#include "model/train/stgcn/weights.h"

#include <nlohmann/json.hpp>

#include "model/train/checkpoint.h"
#include "model/train/safetensors_write.h"
#include "model/train/stgcn/learner.h"

namespace styled::train::st_gcn {

namespace {

using torch::Tensor;

// Of the networks that a checkpoint's metadata describe.
Result<Shape> ShapeFromJson(const std::string& text) {
  try {
    const nlohmann::json json = nlohmann::json::parse(text);
    Shape shape;
    shape.domains = static_cast<int64_t>(json.at("styles").size());
    shape.width = json.at("width");
    shape.code = json.at("code");
    shape.noise = json.at("noise");
    return shape;
  } catch (const std::exception& error) {
    return Status::Error(std::string("weights metadata: ") + Reason(error));
  }
}

}  // namespace

Status ExportWeights(const Checkpoint& checkpoint, const std::filesystem::path& file) {
  try {
    const torch::NoGradGuard no_grad;
    const auto& t = checkpoint.tensors;
    const std::string& metadata = checkpoint.strings.at("metadata");
    Result<Shape> shape = ShapeFromJson(metadata);
    if (!shape.ok()) return shape.status();
    // Networks without node biases have fewer numbers; the file has zeros for them.
    Networks whole(shape.value(), torch::kCPU, false);
    Shape smaller = shape.value();
    smaller.node_bias = false;
    Networks bare(smaller, torch::kCPU, false);
    NamedTensors tensors{{"features.mean", t.at("mean")},
                         {"features.deviation", t.at("deviation")}};
    const auto whole_parts = whole.parts();
    const auto bare_parts = bare.parts();
    for (std::size_t i = 0; i < whole_parts.size(); ++i) {
      const auto& [name, all] = whole_parts[i];
      const Tensor& flat = t.at(std::string("average.") + name);
      const bool biased = flat.numel() == all->flat().numel();
      (biased ? all : bare_parts[i].second)->flat().copy_(flat);
      for (const auto& [tensor_name, tensor] : all->named()) {
        const bool zero = !biased && tensor_name.ends_with(".node_bias");
        const Tensor source = biased || zero ? tensor : bare_parts[i].second->Find(tensor_name);
        const bool last = tensor_name.ends_with(".conv.weight");  // input channels, in training
        tensors.emplace_back(tensor_name, zero   ? torch::zeros_like(source)
                                          : last ? source.permute({0, 3, 1, 2})
                                                 : source);
      }
    }
    tensors.emplace_back("codes.mean", t.at("codes.mean"));
    return WriteSafetensors(tensors, metadata, file);
  } catch (const std::exception& failure) {
    return Status::Error(Reason(failure));
  }
}

}  // namespace styled::train::st_gcn
