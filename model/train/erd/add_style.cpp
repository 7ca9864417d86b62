#include "model/train/erd/add_style.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "model/net/styles.h"

namespace styled::train::style_erd {

using torch::Tensor;
using Json = nlohmann::ordered_json;

namespace {

// The manifest must have the neutral style and those of the flag.
Status CheckStyles(const Config& config, const std::filesystem::path& file,
                   const clip::Manifest& manifest) {
  bool same = manifest.styles.size() == config.add_styles.size() + 1;
  for (std::size_t i = 1; same && i < manifest.styles.size(); ++i) {
    same = std::count(config.add_styles.begin(), config.add_styles.end(),
                      manifest.styles[i].name) == 1;
  }
  if (same) return Status::Ok();
  std::string found;
  std::string expected;
  for (const clip::ManifestStyle& style : manifest.styles) found += " \"" + style.name + "\"";
  for (const std::string& name : config.add_styles) expected += " and \"" + name + "\"";
  return Status::Error(file.string() + ": styles: found" + found + ", expected the neutral style" +
                       expected);
}

}  // namespace

Result<std::vector<int64_t>> PlacesOfAdded(const Config& config,
                                           const std::filesystem::path& manifest_file,
                                           const clip::Manifest& manifest,
                                           const LoadedWeights& init) {
  const Status styles = CheckStyles(config, manifest_file, manifest);
  if (!styles.ok()) return styles;
  std::vector<int64_t> places;
  auto behind = static_cast<int64_t>(init.styles.size());
  for (std::size_t i = 1; i < manifest.styles.size(); ++i) {
    const std::string& name = manifest.styles[i].name;
    const auto present = std::find(init.styles.begin(), init.styles.end(), name);
    if (present != init.styles.end() && !config.replace) {
      return Status::Error("add-style: " + config.init.string() + " already has a style \"" + name +
                           "\"; --replace trains it again");
    }
    places.push_back(present != init.styles.end() ? present - init.styles.begin() : behind++);
  }
  if (behind > static_cast<int64_t>(net::kMaxStyles)) {
    return Status::Error("add-style: " + config.init.string() + " has " +
                         std::to_string(init.styles.size()) + " styles and would have " +
                         std::to_string(behind) + ", more than the limit of " +
                         std::to_string(net::kMaxStyles));
  }
  return places;
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
      const int64_t after = name == "encoder.0.weight" ? base.shape.contents : 0;
      const int64_t plain = own.size(1) - base.shape.styles - after;
      set(tensor, 1, plain, own.narrow(1, 0, own.size(1) - after), of_few, plain);
      tensor.narrow(1, tensor.size(1) - after, after)
          .copy_(own.narrow(1, own.size(1) - after, after));
    } else {
      tensor.copy_(own);
    }
  }
  return out;
}

std::string WithStyles(const std::string& base, const std::vector<clip::ManifestStyle>& styles,
                       const std::vector<int64_t>& places, const std::string& training,
                       const std::string& licence) {
  Json json = Json::parse(base);
  json["licence"] = licence;
  for (std::size_t i = 0; i < places.size(); ++i) {
    json["styles"][static_cast<std::size_t>(places[i])] =
        Json{{"name", styles[i].name}, {"aliases", styles[i].aliases}};
  }
  Json& how = json["training"];
  if (!how.is_object()) how = Json::object();
  how["added"].push_back(Json::parse(training));
  return json.dump();
}

}  // namespace styled::train::style_erd
