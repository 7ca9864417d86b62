#include "model/train/checkpoint.h"

#include <cstdio>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <stdexcept>

#include "model/body/humanoid.h"
#include "model/net/erd/features.h"
#include "model/net/weights_file.h"
#include "model/train/dataset.h"

namespace styled::train {
namespace {

using torch::Tensor;
using Json = nlohmann::ordered_json;

Tensor FromString(const std::string& text) {
  Tensor bytes = torch::empty({static_cast<int64_t>(text.size())}, torch::kUInt8);
  std::memcpy(bytes.data_ptr(), text.data(), text.size());
  return bytes;
}

std::filesystem::path Partial(std::filesystem::path file) { return file += ".partial"; }

Status Rename(const std::filesystem::path& file) {
  std::error_code error;
  std::filesystem::rename(Partial(file), file, error);
  return error ? Status::Error(file.string() + ": " + error.message()) : Status::Ok();
}

// The generator's parameters under the names of the format; views, not copies.
std::vector<std::pair<std::string, Tensor>> FormatTensors(const Generator& generator) {
  std::vector<std::pair<std::string, Tensor>> tensors;
  const auto add_stack = [&tensors](const Stack& stack, int64_t first_style) {
    for (int64_t group = 0; group < stack.groups; ++group) {
      for (std::size_t layer = 0; layer < stack.input.size(); ++layer) {
        const std::string prefix =
            "recurrent." + std::to_string(first_style + group) + "." + std::to_string(layer) + ".";
        tensors.emplace_back(prefix + "input", stack.input[layer][group]);
        tensors.emplace_back(prefix + "hidden", stack.hidden[layer][group]);
        tensors.emplace_back(prefix + "bias", stack.bias[layer][group]);
        tensors.emplace_back(prefix + "h0", stack.h0[layer][group]);
        tensors.emplace_back(prefix + "c0", stack.c0[layer][group]);
      }
    }
  };
  add_stack(generator.neutral, 0);
  add_stack(generator.branches, 1);
  for (const auto& [name, tensor] : generator.parameters.named()) {
    if (!name.starts_with("neutral.") && !name.starts_with("branches.")) {
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

std::string Reason(const std::exception& error) {
  const auto* torch_error = dynamic_cast<const c10::Error*>(&error);
  const std::string text =
      torch_error != nullptr ? torch_error->what_without_backtrace() : error.what();
  return text.substr(0, text.find('\n'));
}

Status WriteCheckpoint(const Checkpoint& checkpoint, const std::filesystem::path& file) {
  try {
    torch::serialize::OutputArchive archive;
    std::string names;
    for (const auto& [name, tensor] : checkpoint.tensors) {
      archive.write("t." + name, tensor.detach().cpu());
      names += "t." + name + "\n";
    }
    for (const auto& [name, text] : checkpoint.strings) {
      archive.write("s." + name, FromString(text));
      names += "s." + name + "\n";
    }
    archive.write("names", FromString(names));
    archive.save_to(Partial(file).string());
  } catch (const std::exception& error) {
    return Status::Error(file.string() + ": " + Reason(error));
  }
  return Rename(file);
}

Status ReadCheckpoint(const std::filesystem::path& file, Checkpoint& checkpoint) {
  try {
    torch::serialize::InputArchive archive;
    archive.load_from(file.string(), torch::kCPU);
    const auto text = [&archive](const std::string& key) {
      Tensor bytes;
      archive.read(key, bytes);
      return std::string(static_cast<const char*>(bytes.data_ptr()), bytes.numel());
    };
    std::istringstream names(text("names"));
    for (std::string name; std::getline(names, name);) {
      if (name.starts_with("t.")) {
        archive.read(name, checkpoint.tensors[name.substr(2)]);
      } else {
        checkpoint.strings[name.substr(2)] = text(name);
      }
    }
  } catch (const std::exception& error) {
    return Status::Error(file.string() + ": not a checkpoint of styletrain: " + Reason(error));
  }
  return Status::Ok();
}

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
  json["contents"] = Json::array();
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
                    const std::string& json, const std::filesystem::path& file) {
  // 1. Tensors under the names of the format.
  std::vector<std::pair<std::string, Tensor>> tensors;
  const auto add = [&tensors](const std::string& name, const Tensor& tensor) {
    tensors.emplace_back(name, tensor.detach().cpu().to(torch::kFloat32).contiguous());
  };
  add("feature.mean", mean);
  add("feature.deviation", deviation);
  for (const auto& [name, tensor] : FormatTensors(generator)) add(name, tensor);

  // 2. The header.
  Json header;
  header["__metadata__"] = {{"styled", json}};
  int64_t offset = 0;
  for (const auto& [name, tensor] : tensors) {
    const int64_t bytes = tensor.numel() * 4;
    header[name] = {{"dtype", "F32"},
                    {"shape", tensor.sizes().vec()},
                    {"data_offsets", {offset, offset + bytes}}};
    offset += bytes;
  }
  std::string text = header.dump();
  text.append((8 - text.size() % 8) % 8, ' ');

  // 3. Length, header, data.
  std::ofstream out(Partial(file), std::ios::binary);
  uint64_t length = text.size();
  char length_bytes[8];
  for (char& byte : length_bytes) {
    byte = static_cast<char>(length & 0xFFU);
    length >>= 8;
  }
  out.write(length_bytes, 8);
  out.write(text.data(), static_cast<std::streamsize>(text.size()));
  for (const auto& [name, tensor] : tensors) {
    out.write(static_cast<const char*>(tensor.data_ptr()), tensor.numel() * 4);
  }
  out.close();
  if (!out) return Status::Error(file.string() + ": cannot be written");
  return Rename(file);
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

std::unique_ptr<Generator> WithStyles(const Generator& base, const Generator& few,
                                      const std::vector<int64_t>& places, const Tensor& mean,
                                      const Tensor& deviation) {
  const torch::NoGradGuard no_grad;
  GeneratorShape shape = base.shape;
  for (const int64_t place : places) shape.styles = std::max(shape.styles, place + 1);
  auto out = std::make_unique<Generator>(shape, mean, deviation);
  // Rows of branches, or columns of style inputs (neutral has one): base's, then few's over them.
  const auto set = [&](const Tensor& tensor, int dimension, int64_t first, const Tensor& own,
                       const Tensor& of_few, int64_t first_of_few) {
    tensor.narrow(dimension, 0, own.size(dimension)).copy_(own);
    for (std::size_t i = 0; i < places.size(); ++i) {
      tensor.select(dimension, first + places[i])
          .copy_(of_few.select(dimension, first_of_few + 1 + static_cast<int64_t>(i)));
    }
  };
  for (const auto& [name, tensor] : out->parameters.named()) {
    const Tensor own = base.parameters.Find(name).detach();
    const Tensor of_few = few.parameters.Find(name).detach();
    if (name.starts_with("branches.")) {
      set(tensor, 0, -1, own, of_few, -1);
    } else if (name == "encoder.0.weight" || name == "decoder.0.weight") {
      const int64_t plain = own.size(1) - base.shape.styles;
      set(tensor, 1, plain, own, of_few, plain);
    } else {
      tensor.copy_(own);
    }
  }
  return out;
}

std::string WithStyles(const std::string& base, const std::vector<clip::ManifestStyle>& styles,
                       const std::vector<int64_t>& places, const std::string& training) {
  Json json = Json::parse(base);
  for (std::size_t i = 0; i < places.size(); ++i) {
    json["styles"][static_cast<std::size_t>(places[i])] =
        Json{{"name", styles[i].name}, {"aliases", styles[i].aliases}};
  }
  Json& how = json["training"];
  if (!how.is_object()) how = Json::object();
  how["added"].push_back(Json::parse(training));
  return json.dump();
}

}  // namespace styled::train
