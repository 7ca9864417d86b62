#include "tests/unit/net/erd/random_weights.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <random>
#include <span>

#include "model/body/humanoid.h"
#include "model/net/load.h"

namespace styled::erd {
namespace {

using nlohmann::json;

class Maker {
 public:
  Maker(unsigned seed, std::vector<NamedTensor>& tensors) : random_(seed), tensors_(tensors) {}

  void Uniform(const std::string& name, std::vector<std::int64_t> shape, float low, float high) {
    std::int64_t count = 1;
    for (const std::int64_t size : shape) count *= size;
    NamedTensor tensor{name, std::move(shape), {}};
    // Computed by hand, because the standard's distributions differ between libraries.
    for (std::int64_t i = 0; i < count; ++i) {
      const float share = static_cast<float>(random_() >> 8) / static_cast<float>(1 << 24);
      tensor.values.push_back(low + (high - low) * share);
    }
    tensors_.push_back(std::move(tensor));
  }
  // Adds `count` numbers behind each `row` numbers of a tensor.
  void Widen(NamedTensor& tensor, std::size_t row, std::size_t count, float bound) {
    std::vector<float> wider;
    for (std::size_t at = 0; at < tensor.values.size(); at += row) {
      const auto begin = tensor.values.begin() + static_cast<std::ptrdiff_t>(at);
      wider.insert(wider.end(), begin, begin + static_cast<std::ptrdiff_t>(row));
      for (std::size_t i = 0; i < count; ++i) wider.push_back(bound * Signed());
    }
    tensor.values = std::move(wider);
  }
  float Signed() { return static_cast<float>(random_() >> 8) / static_cast<float>(1 << 23) - 1; }
  void Linear(const std::string& name, int rows, int columns) {
    const float bound = 1.7F / std::sqrt(static_cast<float>(columns));
    Uniform(name + ".weight", {rows, columns}, -bound, bound);
    Uniform(name + ".bias", {rows}, -0.3F, 0.3F);
  }

 private:
  std::mt19937 random_;
  std::vector<NamedTensor>& tensors_;
};

template <typename T>
T Expect(Result<T> result) {
  if (!result.ok()) {
    std::fprintf(stderr, "%s\n", result.status().message().c_str());
    std::abort();
  }
  return std::move(result.value());
}

}  // namespace

NamedTensor& WeightsFile::tensor(const std::string& name) {
  for (NamedTensor& tensor : tensors) {
    if (tensor.name == name) return tensor;
  }
  std::fprintf(stderr, "no tensor %s\n", name.c_str());
  std::abort();
}

std::vector<std::byte> WeightsFile::Bytes() const {
  return net::SerializeSafetensors(tensors, {{"styled", metadata.dump()}});
}

WeightsFile ReadParts(const std::filesystem::path& file) {
  const std::vector<std::byte> bytes = Expect(net::ReadFile(file));
  const net::SafetensorsView view = Expect(net::ParseSafetensors(bytes, file.string()));
  WeightsFile parts;
  parts.metadata = json::parse(view.metadata.at("styled"));
  for (const auto& [name, tensor] : view.tensors) {
    NamedTensor& part = parts.tensors.emplace_back(NamedTensor{name, tensor.shape, {}});
    part.values.resize(tensor.bytes.size() / sizeof(float));
    std::memcpy(part.values.data(), tensor.bytes.data(), tensor.bytes.size());
  }
  return parts;
}

WeightsFile RandomWeights(int style_count, unsigned seed, const Shape& shape) {
  const int latent = shape.latent;
  const auto [d0, d1, d2] = shape.decoder;
  WeightsFile file;
  char hash[17];
  std::snprintf(hash, sizeof(hash), "%016llx",
                static_cast<unsigned long long>(body::HumanoidHash()));
  json styles = json::array({{{"name", "neutral"}, {"aliases", json::array({"normal"})}}});
  for (int s = 1; s < style_count; ++s) {
    const std::string number = std::to_string(s);
    styles.push_back({{"name", "style" + number}, {"aliases", json::array({"s" + number})}});
  }
  file.metadata = {{"version", 2},
                   {"family", "style-erd"},
                   {"humanoid_hash", hash},
                   {"styles", styles},
                   {"contents", json::array()},
                   {"rate_hz", 30.0},
                   {"heading_tau_s", 0.25},
                   {"latent", latent},
                   {"encoder", {shape.encoder}},
                   {"decoder", shape.decoder},
                   {"neutral_layers", 6},
                   {"style_layers", 4},
                   {"gates", "ifgo"},
                   {"training", {{"command", "random"}, {"seed", seed}}},
                   {"licence", "CC0-1.0"}};

  Maker make(seed, file.tensors);
  make.Uniform("feature.mean", {211}, -0.2F, 0.2F);
  for (int joint = 0; joint < 21; ++joint) file.tensors[0].values[4 * joint + 3] += 1.0F;
  make.Uniform("feature.deviation", {211}, 0.05F, 0.5F);
  make.Linear("encoder.0", shape.encoder, 211 + style_count);
  make.Linear("encoder.1", latent, shape.encoder);
  // As far as with 32 units, whatever the width.
  const float bound = 0.4F * std::sqrt(32.0F / static_cast<float>(latent));
  for (int s = 0; s < style_count; ++s) {
    for (int layer = 0; layer < (s == 0 ? 6 : 4); ++layer) {
      const std::string name = "recurrent." + std::to_string(s) + "." + std::to_string(layer);
      make.Uniform(name + ".input", {4 * latent, latent}, -bound, bound);
      make.Uniform(name + ".hidden", {4 * latent, latent}, -bound, bound);
      make.Uniform(name + ".bias", {4 * latent}, -0.3F, 0.3F);
      make.Uniform(name + ".h0", {latent}, -0.5F, 0.5F);
      make.Uniform(name + ".c0", {latent}, -0.8F, 0.8F);
    }
  }
  make.Linear("decoder.0", d0, latent + style_count);
  make.Linear("decoder.1", d1, d0);
  make.Linear("decoder.2", d2, d1);
  make.Linear("head.rotation", 84, d2);
  make.Linear("head.velocity", 63, d2);
  make.Linear("head.height", 1, d2);
  return file;
}

void AddContents(WeightsFile& file, int count, unsigned seed, bool idle) {
  const auto contents = static_cast<std::size_t>(count);
  for (int c = 1; c <= count; ++c) {
    file.metadata["contents"].push_back("content" + std::to_string(c));
  }
  file.metadata["content_rise_s"] = 0.3;
  std::vector<NamedTensor> added;
  Maker make(seed, added);
  NamedTensor& encoder = file.tensor("encoder.0.weight");
  make.Widen(encoder, static_cast<std::size_t>(encoder.shape[1]), contents, idle ? 0.0F : 1.0F);
  encoder.shape[1] += count;
  const std::int64_t hidden = encoder.shape[0], latent = file.metadata["latent"];
  for (int layer = 0; layer < 6; ++layer) {
    for (const char* const state : {".h0", ".c0"}) {
      NamedTensor& start = file.tensor("recurrent.0." + std::to_string(layer) + state);
      const std::vector<float> known = start.values;
      start.shape = {count + 1, latent};
      for (std::size_t c = 0; c < contents; ++c) {
        for (const float value : known) {
          start.values.push_back(idle ? value : 0.7F * make.Signed());
        }
      }
    }
  }
  make.Linear("recognizer.0", static_cast<int>(hidden), 211);
  make.Linear("recognizer.1", static_cast<int>(latent), static_cast<int>(hidden));
  const float bound = 0.4F * std::sqrt(32.0F / static_cast<float>(latent));
  make.Uniform("recognizer.lstm.input", {4 * latent, latent}, -bound, bound);
  make.Uniform("recognizer.lstm.hidden", {4 * latent, latent}, -bound, bound);
  make.Uniform("recognizer.lstm.bias", {4 * latent}, -0.3F, 0.3F);
  make.Uniform("recognizer.lstm.h0", {latent}, -0.5F, 0.5F);
  make.Uniform("recognizer.lstm.c0", {latent}, -0.8F, 0.8F);
  // Large, so that shares are uneven.
  make.Uniform("recognizer.head.weight", {count, latent}, -2, 2);
  make.Uniform("recognizer.head.bias", {count}, -0.5F, 0.5F);
  for (NamedTensor& tensor : added) file.tensors.push_back(std::move(tensor));
}

WeightsFile RandomWeightsWithContents(int style_count, int content_count, unsigned seed,
                                      const Shape& shape) {
  WeightsFile file = RandomWeights(style_count, seed, shape);
  AddContents(file, content_count, seed + 1);
  return file;
}

// Unit 0 is passed from layer to layer and tells in every frame whether the hips are high; the
// decoder turns that into 1e30.
WeightsFile SleepingWeights(int style_count, unsigned seed) {
  constexpr std::size_t kUnits = 32;
  constexpr float kShut = -40, kOpen = 40, kFirm = 5;
  WeightsFile file = RandomWeights(style_count, seed);
  const auto row = [&file](const std::string& name, std::size_t index) {
    NamedTensor& tensor = file.tensor(name);
    const std::size_t width = tensor.shape.size() > 1 ? tensor.shape[1] : 1;
    return std::span(tensor.values).subspan(index * width, width);
  };
  const auto clear = [](std::span<float> values) { std::fill(values.begin(), values.end(), 0.0F); };
  // u = (height - 1 m) / 0.1 m
  file.tensor("feature.mean").values[210] = 1.0F;
  file.tensor("feature.deviation").values[210] = 0.1F;
  const std::span<float> encoder0 = row("encoder.0.weight", 0);
  clear(encoder0);
  encoder0[210] = 100;
  row("encoder.0.bias", 0)[0] = -100 * (kAwake_m - 1.0F) / 0.1F;
  const std::span<float> encoder1 = row("encoder.1.weight", 0);
  clear(encoder1);
  encoder1[0] = 1;
  row("encoder.1.bias", 0)[0] = -1;
  const auto gate = [&](const std::string& layer, std::size_t of, float bias) {
    clear(row(layer + ".input", of * kUnits));
    clear(row(layer + ".hidden", of * kUnits));
    row(layer + ".bias", of * kUnits)[0] = bias;
  };
  for (int l = 0; l < 6; ++l) {
    const std::string layer = "recurrent.0." + std::to_string(l);
    gate(layer, 0, kOpen);
    gate(layer, 1, kShut);
    gate(layer, 2, 0);
    gate(layer, 3, kOpen);
    row(layer + ".input", 2 * kUnits)[0] = kFirm;
  }
  for (int s = 1; s < style_count; ++s) gate("recurrent." + std::to_string(s) + ".3", 3, kShut);
  const std::span<float> decoder0 = row("decoder.0.weight", 0);
  clear(decoder0);
  decoder0[0] = 1e30F;
  row("decoder.0.bias", 0)[0] = 0;
  return file;
}

std::shared_ptr<const Network> RandomNetwork(int style_count, unsigned seed) {
  return NetworkOf(RandomWeights(style_count, seed));
}

std::shared_ptr<const WideNetwork> RandomWideNetwork(int style_count, unsigned seed) {
  return Expect(WideNetwork::Parse(RandomWeights(style_count, seed, kWide).Bytes(), "random"));
}

std::shared_ptr<const Network> NetworkOf(const WeightsFile& file) {
  return Expect(Network::Parse(file.Bytes(), "random"));
}

std::shared_ptr<const net::Stylizer> RandomStylizer(int style_count, unsigned seed,
                                                    const Shape& shape) {
  return StylizerOf(RandomWeights(style_count, seed, shape));
}

std::shared_ptr<const net::Stylizer> StylizerOf(const WeightsFile& file) {
  return Expect(net::Parse(file.Bytes(), "random"));
}

}  // namespace styled::erd
