#include "tests/unit/net/stgcn_causal/reference.h"

#include <algorithm>
#include <cmath>

namespace styled::stgcn_causal {
namespace {

using stgcn::kChannels;
using stgcn::kCode;
using stgcn::Leaky;
using stgcn::PoolSpace;
using stgcn::Relu;
using stgcn::Sum;
using stgcn::UnpoolSpace;

Doubles VectorOf(const WeightsFile& file, const std::string& tensor) {
  const std::vector<float>& values = file.tensor(tensor).values;
  return {values.begin(), values.end()};
}

}  // namespace

Reference::Reference(const WeightsFile& file)
    : file_(file),
      layers_(file),
      memory_(file.metadata["memory"]),
      start_frames_(file.metadata["start_frames"]) {
  for (std::size_t i = 0; i < spacing_.size(); ++i) spacing_[i] = file.metadata["spacing"][i];
}

double Reference::Value(const std::string& tensor, std::size_t i) const {
  return static_cast<double>(file_.tensor(tensor).values[i]);
}

// bias + W_0 v_(t-2d) + W_1 v_(t-d) + W_2 v_t, v_i = v_0 for i < 0.
stgcn::Clip Reference::TimeConvolution(const Clip& x, const std::string& name, int spacing,
                                       Past& past) const {
  std::vector<Clip>& inputs = past.inputs[name];
  inputs.push_back(x);
  const int now = static_cast<int>(inputs.size()) - 1;
  const std::vector<float>& weight = file_.tensor(name + ".weight").values;
  const std::size_t channels = x[0][0].size();
  Clip y = x;
  for (std::size_t node = 0; node < x[0].size(); ++node) {
    for (std::size_t out = 0; out < channels; ++out) {
      double sum = Value(name + ".bias", out);
      for (int tap = 0; tap < 3; ++tap) {
        const int at = std::max(0, now - (2 - tap) * spacing);
        const Doubles& v = inputs[static_cast<std::size_t>(at)][0][node];
        for (std::size_t in = 0; in < channels; ++in) {
          const std::size_t element = (out * channels + in) * 3 + static_cast<std::size_t>(tap);
          sum += static_cast<double>(weight[element]) * v[in];
        }
      }
      y[0][node][out] = sum;
    }
  }
  return y;
}

stgcn::Clip Reference::Normalized(const Clip& x, const std::string& name, const Doubles& scale,
                                  const Doubles& shift, Past& past) const {
  const std::size_t channels = x[0][0].size();
  if (!past.sums.contains(name)) {
    Sums start{static_cast<double>(start_frames_), VectorOf(file_, name + ".start_mean"),
               VectorOf(file_, name + ".start_square")};
    for (std::size_t c = 0; c < channels; ++c) {
      start.of_x[c] *= start_frames_;
      start.square[c] *= start_frames_;
    }
    past.sums[name] = start;
  }
  Sums& sums = past.sums.at(name);
  const double keep = 1 - 1.0 / memory_;
  sums.count = keep * sums.count + 1;
  Clip y = x;
  for (std::size_t c = 0; c < channels; ++c) {
    double mean = 0, square = 0;
    for (const Doubles& node : x[0]) {
      mean += node[c] / static_cast<double>(x[0].size());
      square += node[c] * node[c] / static_cast<double>(x[0].size());
    }
    sums.of_x[c] = keep * sums.of_x[c] + mean;
    sums.square[c] = keep * sums.square[c] + square;
    const double m = sums.of_x[c] / sums.count;
    const double variance = std::max(sums.square[c] / sums.count - m * m, 0.0);
    for (Doubles& node : y[0]) {
      node[c] = scale[c] * (node[c] - m) / std::sqrt(variance + 1e-5) + shift[c];
    }
  }
  return y;
}

stgcn::Clip Reference::InstanceNorm(const Clip& x, const std::string& name, Past& past) const {
  return Normalized(x, name, VectorOf(file_, name + ".scale"), VectorOf(file_, name + ".shift"),
                    past);
}

stgcn::Clip Reference::AdaIn(const Clip& x, const std::string& name, const Doubles& code,
                             Past& past) const {
  const Doubles both = layers_.Dense(code, name);
  const auto half = static_cast<std::ptrdiff_t>(both.size() / 2);
  Doubles scale(both.begin(), both.begin() + half);
  for (double& value : scale) value += 1;
  return Normalized(x, name, scale, Doubles(both.begin() + half, both.end()), past);
}

stgcn::Clip Reference::Encoder(const Clip& x, const std::string& name, int level, int spacing,
                               Past& past) const {
  Clip y = layers_.GraphConvolution(Leaky(InstanceNorm(x, name + ".norm1", past)), name + ".gconv1",
                                    level);
  y = TimeConvolution(Relu(PoolSpace(y, level)), name + ".tconv1", spacing, past);
  y = layers_.GraphConvolution(Leaky(InstanceNorm(y, name + ".norm2", past)), name + ".gconv2",
                               level + 1);
  y = TimeConvolution(Relu(y), name + ".tconv2", spacing, past);
  return Sum(y, layers_.Linear(PoolSpace(x, level), name + ".skip"));
}

// From the coarser level to `level`.
stgcn::Clip Reference::Decoder(const Clip& x, const std::string& name, int level, int spacing,
                               const Doubles& code, Past& past) const {
  Clip y = layers_.GraphConvolution(Leaky(AdaIn(x, name + ".adain1", code, past)), name + ".gconv1",
                                    level + 1);
  y = TimeConvolution(Relu(UnpoolSpace(y, level)), name + ".tconv1", spacing, past);
  y = layers_.GraphConvolution(Leaky(AdaIn(y, name + ".adain2", code, past)), name + ".gconv2",
                               level);
  y = TimeConvolution(Relu(y), name + ".tconv2", spacing, past);
  return Sum(y, layers_.Linear(UnpoolSpace(x, level), name + ".skip"));
}

Doubles Reference::Decode(const Clip& content, const Doubles& code, Past& past) const {
  const Clip first = Decoder(content, "g.dec1", 1, spacing_[2], code, past);
  const Clip last = Decoder(first, "g.dec2", 0, spacing_[3], code, past);
  const Clip y = layers_.WithBias(last, "g.out");
  Doubles out;
  for (const Doubles& joint : y[0]) {
    for (const double value : joint) {
      const std::size_t i = out.size();
      out.push_back(value * Value("features.deviation", i) + Value("features.mean", i));
    }
  }
  out[0] = out[2] = 0;  // the hips' x and z
  return out;
}

Doubles Reference::Code(int domain) const {
  const Doubles all = VectorOf(file_, "codes.mean");
  const auto begin = all.begin() + std::ptrdiff_t{domain} * kCode;
  return {begin, begin + kCode};
}

Reference::Output Reference::Step(const Features& features, int input_style,
                                  const std::map<int, double>& active) {
  Clip u = layers_.Standardized({features});
  for (Doubles& joint : u[0]) {
    for (double& value : joint) {
      value = std::isnan(value) ? 0 : std::clamp(value, -4.0, 4.0);
    }
  }
  Clip h = layers_.WithBias(u, "g.in");
  h = Encoder(h, "g.enc1", 0, spacing_[0], encoder_);
  h = Encoder(h, "g.enc2", 1, spacing_[1], encoder_);

  double sum = 0;
  for (const auto& [style, alpha] : active) sum += alpha;
  const double scale = sum > 1.5 ? 1.5 / sum : 1;
  const Doubles neutral = Code(0);
  Doubles code = neutral;
  for (const auto& [style, alpha] : active) {
    const Doubles of_style = Code(style);
    for (std::size_t k = 0; k < kCode; ++k) code[k] += scale * alpha * (of_style[k] - neutral[k]);
  }

  const bool differs = sum > 0 || input_style != 0;
  if (alone_ == 0) styled_ = own_;
  if (differs) alone_ = 8 * memory_;
  Output out;
  out.reconstruction = Decode(h, Code(input_style), own_);
  out.styled = alone_ > 0 ? Decode(h, code, styled_) : out.reconstruction;
  if (!differs && alone_ > 0) --alone_;
  return out;
}

}  // namespace styled::stgcn_causal
