#include "model/train/erd/weights.h"

#include <cstdio>
#include <cstring>
#include <nlohmann/json.hpp>
#include <sstream>
#include <stdexcept>

#include "model/body/humanoid.h"
#include "model/net/erd/features.h"
#include "model/net/weights_file.h"
#include "model/train/checkpoint.h"
#include "model/train/dataset.h"
#include "model/train/safetensors_write.h"

namespace styled::train::style_erd {
namespace {

using torch::Tensor;
using Json = nlohmann::ordered_json;

// The generator's parameters under the names of the format; views, not copies.
NamedTensors FormatTensors(const Generator& generator) {
  NamedTensors tensors;
  const auto add_stack = [&tensors](const Stack& stack, int64_t first_style) {
    for (int64_t group = 0; group < stack.groups; ++group) {
      for (std::size_t layer = 0; layer < stack.input.size(); ++layer) {
        const std::string prefix =
            "recurrent." + std::to_string(first_style + group) + "." + std::to_string(layer) + ".";
        tensors.emplace_back(prefix + "input", stack.input[layer][group]);
        tensors.emplace_back(prefix + "hidden", stack.hidden[layer][group]);
        tensors.emplace_back(prefix + "bias", stack.bias[layer][group]);
        const bool several = stack.h0[layer].size(0) > stack.groups;  // [starts, Z]
        tensors.emplace_back(prefix + "h0", several ? stack.h0[layer] : stack.h0[layer][group]);
        tensors.emplace_back(prefix + "c0", several ? stack.c0[layer] : stack.c0[layer][group]);
      }
    }
  };
  add_stack(generator.neutral, 0);
  add_stack(generator.branches, 1);
  constexpr std::string_view kRecognizer = "recognizer.lstm.";  // of one layer and one group
  for (const auto& [name, tensor] : generator.parameters.named()) {
    if (name.starts_with("neutral.") || name.starts_with("branches.")) continue;
    if (name.starts_with(kRecognizer)) {
      tensors.emplace_back(std::string(kRecognizer) + name.substr(name.rfind('.') + 1), tensor[0]);
    } else {
      tensors.emplace_back(name, tensor);
    }
  }
  return tensors;
}

// The named tensor of a weights file; throws where it is missing or has another shape.
Tensor TensorOf(const net::SafetensorsView& view, const std::string& name,
                torch::IntArrayRef shape) {
  const auto found = view.tensors.find(name);
  if (found == view.tensors.end()) throw std::runtime_error("no tensor " + name);
  const net::TensorView& tensor = found->second;
  if (tensor.dtype != "F32" || !shape.equals(tensor.shape)) {
    std::ostringstream text;
    text << "tensor " << name << ": found " << tensor.dtype << " "
         << torch::IntArrayRef(tensor.shape) << ", expected F32 " << shape;
    throw std::runtime_error(text.str());
  }
  Tensor out = torch::empty(shape);
  std::memcpy(out.data_ptr(), tensor.bytes.data(), tensor.bytes.size());
  return out;
}

}  // namespace

std::string WeightsMetadata::ToJson(const GeneratorShape& shape) const {
  char hash[17];
  std::snprintf(hash, sizeof hash, "%016llx",
                static_cast<unsigned long long>(body::HumanoidHash()));
  Json json;
  json["version"] = 2;
  json["family"] = net::kStyleErd;
  json["humanoid_hash"] = hash;
  for (const auto& [name, aliases] : styles) {
    json["styles"].push_back(Json{{"name", name}, {"aliases", aliases}});
  }
  json["contents"] = contents;
  if (!contents.empty()) json["content_rise_s"] = content_rise_s;
  json["rate_hz"] = rate_hz;
  json["heading_tau_s"] = heading_tau_s;
  json["latent"] = shape.latent;
  json["encoder"] = shape.encoder;
  json["decoder"] = shape.decoder;
  json["neutral_layers"] = shape.neutral_layers;
  json["style_layers"] = shape.style_layers;
  json["gates"] = "ifgo";
  json["training"] = Json::parse(training);
  json["licence"] = licence;
  return json.dump();
}

Result<GeneratorShape> ShapeFromJson(const std::string& text) {
  try {
    const Json json = Json::parse(text);
    GeneratorShape shape;
    shape.styles = static_cast<int64_t>(json.at("styles").size());
    shape.contents = static_cast<int64_t>(json.at("contents").size());
    shape.latent = json.at("latent");
    shape.encoder = json.at("encoder").get<std::vector<int64_t>>();
    shape.decoder = json.at("decoder").get<std::vector<int64_t>>();
    shape.neutral_layers = json.at("neutral_layers");
    shape.style_layers = json.at("style_layers");
    return shape;
  } catch (const std::exception& error) {
    return Status::Error(std::string("weights metadata: ") + Reason(error));
  }
}

Status WriteWeights(const Generator& generator, const Tensor& mean, const Tensor& deviation,
                    const std::string& metadata, const std::filesystem::path& file) {
  NamedTensors tensors{{"feature.mean", mean}, {"feature.deviation", deviation}};
  for (const auto& named : FormatTensors(generator)) tensors.push_back(named);
  return WriteSafetensors(tensors, metadata, file);
}

Result<LoadedWeights> ReadWeights(const std::filesystem::path& file) {
  const Result<std::vector<std::byte>> bytes = net::ReadFile(file);
  if (!bytes.ok()) return bytes.status();
  const Result<net::WeightsFile> weights = net::ParseWeights(bytes.value(), file.string());
  if (!weights.ok()) return weights.status();
  const std::string& family = weights.value().model.family;
  if (family != net::kStyleErd) {
    return Status::Error(file.string() + ": key 'family': expected \"" + net::kStyleErd +
                         "\", found \"" + family + "\"");
  }
  const net::SafetensorsView& view = weights.value().view;
  try {
    const torch::NoGradGuard no_grad;
    LoadedWeights out;
    const std::string& text = view.metadata.at("styled");
    const Result<GeneratorShape> shape = ShapeFromJson(text);
    if (!shape.ok()) return Status::Error(file.string() + ": " + shape.status().message());
    const Json json = Json::parse(text);
    out.metadata = text;
    for (const Json& style : json.at("styles")) out.styles.push_back(style.at("name"));
    out.mean = TensorOf(view, "feature.mean", {erd::kFeatureCount});
    out.deviation = TensorOf(view, "feature.deviation", {erd::kFeatureCount});
    out.generator = std::make_unique<Generator>(shape.value(), out.mean, out.deviation);
    for (const auto& [name, tensor] : FormatTensors(*out.generator)) {
      tensor.copy_(TensorOf(view, name, tensor.sizes()));
    }
    out.features.rate_hz = json.at("rate_hz");
    out.features.heading_tau_s = json.at("heading_tau_s");
    erd::Features mean;
    std::copy_n(out.mean.data_ptr<float>(), mean.size(), mean.begin());
    SetHemisphere(mean, out.features);
    return out;
  } catch (const std::exception& error) {
    return Status::Error(file.string() + ": " + Reason(error));
  }
}

}  // namespace styled::train::style_erd
