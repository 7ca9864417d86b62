#include "tests/unit/net/stgcn/random_weights.h"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <random>

#include "model/synthetic/performer.h"

namespace styled::stgcn {
namespace {

using nlohmann::json;

class Maker {
 public:
  Maker(unsigned seed, std::vector<net::NamedTensor>& tensors) : random_(seed), tensors_(tensors) {}

  std::vector<float>& Uniform(const std::string& name, std::vector<std::int64_t> shape, float low,
                              float high) {
    std::int64_t count = 1;
    for (const std::int64_t size : shape) count *= size;
    net::NamedTensor tensor{name, std::move(shape), {}};
    // Computed by hand, because the standard's distributions differ between libraries.
    for (std::int64_t i = 0; i < count; ++i) {
      const float share = static_cast<float>(random_() >> 8) / static_cast<float>(1 << 24);
      tensor.values.push_back(low + (high - low) * share);
    }
    tensors_.push_back(std::move(tensor));
    return tensors_.back().values;
  }
  // A weight whose sums over `inputs` numbers keep their size.
  void Weight(const std::string& name, std::vector<std::int64_t> shape, int inputs) {
    const float bound = 1.7F / std::sqrt(static_cast<float>(inputs));
    Uniform(name + ".weight", std::move(shape), -bound, bound);
  }
  void Bias(const std::string& name, std::vector<std::int64_t> shape) {
    Uniform(name, std::move(shape), -0.3F, 0.3F);
  }
  void Linear(const std::string& name, int rows, int columns) {
    Weight(name, {rows, columns}, columns);
    Bias(name + ".bias", {rows});
  }
  void In(const std::string& name, int width) {
    Linear(name, width, kChannels);
    Bias(name + ".node_bias", {kNodes[0], width});
  }
  void Graph(const std::string& name, int level, int in, int out) {
    Linear(name, 3 * out, in);
    Bias(name + ".node_bias", {kNodes[static_cast<std::size_t>(level)], out});
  }
  void Time(const std::string& name, int channels) {
    Weight(name, {channels, channels, 3}, 3 * channels);
    Bias(name + ".bias", {channels});
  }
  void Norm(const std::string& name, int channels) {
    Uniform(name + ".scale", {channels}, 0.5F, 1.5F);
    Bias(name + ".shift", {channels});
  }
  void Encoder(const std::string& name, int level, int in, int out, bool norms) {
    if (norms) Norm(name + ".norm1", in);
    Graph(name + ".gconv1", level, in, in);
    Time(name + ".tconv1", in);
    if (norms) Norm(name + ".norm2", in);
    Graph(name + ".gconv2", level + 1, in, out);
    Time(name + ".tconv2", out);
    Weight(name + ".skip", {out, in}, in);
  }
  void Decoder(const std::string& name, int level, int in, int out) {
    Linear(name + ".adain1", 2 * in, kCode);
    Graph(name + ".gconv1", level, in, out);
    Time(name + ".tconv1", out);
    Linear(name + ".adain2", 2 * out, kCode);
    Graph(name + ".gconv2", level - 1, out, out);
    Time(name + ".tconv2", out);
    Weight(name + ".skip", {out, in}, in);
  }

 private:
  std::mt19937 random_;
  std::vector<net::NamedTensor>& tensors_;
};

json Header(int domains, int width, unsigned seed) {
  char hash[17];
  std::snprintf(hash, sizeof(hash), "%016llx",
                static_cast<unsigned long long>(body::HumanoidHash()));
  json styles = json::array({{{"name", "neutral"}, {"aliases", json::array({"normal"})}}});
  for (int s = 1; s < domains; ++s) {
    const std::string number = std::to_string(s);
    styles.push_back({{"name", "style" + number}, {"aliases", json::array({"s" + number})}});
  }
  return {{"version", 2},
          {"family", "st-gcn"},
          {"humanoid_hash", hash},
          {"styles", styles},
          {"rate_hz", 30.0},
          {"heading_tau_s", 0.25},
          {"width", width},
          {"code", kCode},
          {"noise", kNoise},
          {"window", kReference},
          {"contents", json::array({"walk"})},
          {"training", {{"command", "random"}, {"seed", seed}}},
          {"licence", "CC0-1.0"}};
}

// The mean and deviation of the synthetic performer's features, so that the network sees numbers
// of about 1 and decodes poses.
void AddFeatures(std::vector<net::NamedTensor>& tensors) {
  const std::vector<Features> walk = WalkFeatures(300, {});
  net::NamedTensor mean{"features.mean", {body::kJointCount, kChannels}, {}};
  net::NamedTensor deviation{"features.deviation", {body::kJointCount, kChannels}, {}};
  for (std::size_t i = 0; i < kFeatureCount; ++i) {
    double sum = 0, squares = 0;
    for (const Features& frame : walk) sum += frame[i];
    sum /= static_cast<double>(walk.size());
    for (const Features& frame : walk) squares += std::pow(frame[i] - sum, 2);
    const double spread = std::sqrt(squares / static_cast<double>(walk.size()));
    mean.values.push_back(static_cast<float>(sum));
    deviation.values.push_back(static_cast<float>(std::max(spread, 0.02)));
  }
  tensors.push_back(std::move(mean));
  tensors.push_back(std::move(deviation));
}

}  // namespace

net::NamedTensor& WeightsFile::tensor(const std::string& name) {
  for (net::NamedTensor& tensor : tensors) {
    if (tensor.name == name) return tensor;
  }
  std::fprintf(stderr, "no tensor %s\n", name.c_str());
  std::abort();
}

const net::NamedTensor& WeightsFile::tensor(const std::string& name) const {
  return const_cast<WeightsFile*>(this)->tensor(name);
}

std::vector<std::byte> WeightsFile::Bytes() const {
  return net::SerializeSafetensors(tensors, {{"styled", metadata.dump()}});
}

WeightsFile RandomWeights(int domains, int width, unsigned seed) {
  WeightsFile file;
  file.metadata = Header(domains, width, seed);
  AddFeatures(file.tensors);
  Maker make(seed, file.tensors);
  const int w = width, trunk = 4 * width;
  make.In("g.in", w);
  make.Encoder("g.enc1", 0, w, 2 * w, true);
  make.Encoder("g.enc2", 1, 2 * w, trunk, true);
  make.Decoder("g.dec1", 2, trunk, 2 * w);
  make.Decoder("g.dec2", 1, 2 * w, w);
  make.Linear("g.out", kChannels, w);
  make.In("e.in", w);
  make.Encoder("e.res1", 0, w, 2 * w, false);
  make.Encoder("e.res2", 1, 2 * w, trunk, false);
  make.Weight("e.conv", {trunk, trunk, 16, 5}, trunk * 80);
  make.Bias("e.conv.bias", {trunk});
  make.Weight("e.heads", {domains, kCode, trunk}, trunk);
  make.Bias("e.heads.bias", {domains, kCode});
  make.Linear("e.free", kCode, trunk);
  make.Linear("f.noise", 256, kNoise);
  make.Linear("f.label", 256, domains);
  make.Linear("f.fc1", 512, 512);
  make.Linear("f.fc2", 1024, 512);
  make.Linear("f.out", kCode, 1024);
  make.Uniform("codes.mean", {domains, kCode}, -1, 1);
  return file;
}

std::shared_ptr<const Network> NetworkOf(const WeightsFile& file) {
  const auto network = Network::Parse(file.Bytes(), "random");
  if (network.ok()) return network.value();
  std::fprintf(stderr, "%s\n", network.status().message().c_str());
  std::abort();
}

std::vector<Features> WalkFeatures(int frames, const FeatureParameters& parameters) {
  synthetic::Options options;
  options.script = {{synthetic::Motion::kWalk, 2.0},
                    {synthetic::Motion::kRun, 1.0},
                    {synthetic::Motion::kTurnLeft, 1.0},
                    {synthetic::Motion::kRaiseBoth, 1.0}};
  synthetic::Performer performer(std::move(options));
  std::vector<Features> walk(static_cast<std::size_t>(frames));
  HeadingState heading;
  body::Pose pose;
  for (int frame = 0; frame < frames; ++frame) {
    performer.Pose(frame / 30.0, pose);
    ComputeFeatures(pose, parameters, heading, walk[static_cast<std::size_t>(frame)]);
  }
  return walk;
}

}  // namespace styled::stgcn
