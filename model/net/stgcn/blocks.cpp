#include "model/net/stgcn/blocks.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace styled::stgcn {
namespace {

using net::RowKernels;
using net::RowMajor;
using net::RowMixture;
using net::RowTerm;
using net::TensorReader;

// Frames of one graph convolution at a time: its products then stay in the second-level cache.
constexpr int kBlockFrames = 16;

TimeConv ReadTimeConv(TensorReader& tensors, const std::string& name, int channels, float scale) {
  const RowMajor weight = tensors.Tensor(name + ".weight", {channels, channels, 3});
  return {weight, tensors.Vector(name + ".bias", channels), scale};
}

AdaIn ReadAdaIn(TensorReader& tensors, const std::string& name, int channels) {
  AdaIn adain{tensors.Matrix(name + ".weight", 2 * channels, kCode),
              tensors.Vector(name + ".bias", 2 * channels)};
  adain.bias.head(channels).array() += 1;  // 1 + γ
  return adain;
}

// A row's scale and shift by channel: of a normalization, or nothing.
struct Affine {
  std::vector<float> scale, shift;
  const float* by() const { return scale.empty() ? nullptr : scale.data(); }
  const float* to() const { return scale.empty() ? nullptr : shift.data(); }
};

// x̂ = (x - mean) / sqrt(variance + ε) over all rows of x, as scale and shift. Row r counts
// `weights`[r mod period] times.
Affine NormalizingAffine(const RowKernels& kernels, const float* x, int frames, int nodes,
                         int channels, std::span<const float> weights) {
  const auto count = static_cast<std::size_t>(channels);
  double total = 0;
  for (const float weight : weights) total += weight;
  total *= static_cast<double>(frames) * nodes / static_cast<double>(weights.size());
  Affine affine{std::vector<float>(count), std::vector<float>(count)};
  std::vector<float> mean(count), part(count);
  std::vector<double> sum(count);
  for (const int power : {1, 2}) {
    std::fill(sum.begin(), sum.end(), 0);
    for (int frame = 0; frame < frames; frame += kBlockFrames) {
      const int rows = std::min(kBlockFrames, frames - frame) * nodes;
      kernels.sum(x + Size(frame, nodes, channels), rows, channels, weights.data(),
                  static_cast<int>(weights.size()), mean.data(), power, part.data());
      for (std::size_t c = 0; c < count; ++c) sum[c] += static_cast<double>(part[c]);
    }
    for (std::size_t c = 0; c < count; ++c) {
      const auto value = static_cast<float>(sum[c] / total);
      if (power == 1) {
        mean[c] = value;
      } else {
        affine.scale[c] = 1 / std::sqrt(value + kNormEpsilon);
        affine.shift[c] = -mean[c] * affine.scale[c];
      }
    }
  }
  return affine;
}
constexpr std::array<float, 1> kEqualWeights{1};

// The scale and shift of the normalization itself.
void Follow(std::span<const float> scale, std::span<const float> shift, Affine& affine) {
  for (std::size_t c = 0; c < scale.size(); ++c) {
    affine.scale[c] *= scale[c];
    affine.shift[c] = affine.shift[c] * scale[c] + shift[c];
  }
}

Affine InstanceNorm(const RowKernels& kernels, const Norm& norm, const float* x, int frames,
                    int nodes, int channels) {
  if (norm.scale.empty()) return {};
  Affine affine = NormalizingAffine(kernels, x, frames, nodes, channels, kEqualWeights);
  Follow(norm.scale, norm.shift, affine);
  return affine;
}

// (1 + γ) x̂ + β, with γ and β from the code.
Affine AdaptiveNorm(const RowKernels& kernels, const AdaIn& adain, const Code& code, const float* x,
                    int frames, int nodes, int channels, std::span<const float> weights) {
  Affine affine = NormalizingAffine(kernels, x, frames, nodes, channels, weights);
  const Eigen::VectorXf both = adain.weight * code + adain.bias;
  const auto count = static_cast<std::size_t>(channels);
  Follow({both.data(), count}, {both.data() + count, count}, affine);
  return affine;
}

// y = x W', row by row.
void Multiply(const RowKernels& kernels, const net::PackedColumns& weight, const float* x, int rows,
              float* y) {
  const RowTerm term{x, weight.depths()[0]};
  kernels.product({&weight, {&term, 1}, rows, nullptr, 1, nullptr, false, y, weight.columns()});
}

// LReLU(affine(x)), graph convolution and perhaps ReLU, a block of frames at a time. With `pairs`,
// the activations of each two frames are averaged in between.
void ConvolveGraph(const RowKernels& kernels, const GraphConv& graph, const Affine& affine,
                   const float* x, int frames, bool pairs, bool relu, float* y, Scratch& scratch) {
  const std::size_t in = Size(graph.in_nodes(), graph.in_channels());
  const std::size_t out = Size(graph.out_nodes(), graph.out_channels());
  float* const block = Sized(scratch.block, kBlockFrames * in);
  float* const memory = Sized(scratch.graph, graph.ScratchSize(kBlockFrames));
  for (int begin = 0; begin < frames; begin += kBlockFrames) {
    const int count = std::min(kBlockFrames, frames - begin);
    for (int i = 0; i < count; ++i) {
      const auto frame = static_cast<std::size_t>(begin + i);
      const float* const first = x + (pairs ? 2 : 1) * frame * in;
      kernels.activate(first, pairs ? first + in : nullptr, graph.in_nodes(), graph.in_channels(),
                       affine.by(), affine.to(), block + static_cast<std::size_t>(i) * in);
    }
    graph.Run(kernels, block, count, relu, y + static_cast<std::size_t>(begin) * out, memory);
  }
}

// Unpooling over time: [frames, row] to [2 frames, row], linear with both ends kept, or its relu.
void UnpoolTime(const RowKernels& kernels, const float* x, int frames, std::size_t row, bool relu,
                float* y) {
  const double step = static_cast<double>(frames - 1) / (2.0 * frames - 1);
  for (int i = 0; i < 2 * frames; ++i) {
    const double at = i * step;
    const int a = std::min(static_cast<int>(at), frames - 2);
    kernels.blend(x + static_cast<std::size_t>(a) * row, x + static_cast<std::size_t>(a + 1) * row,
                  static_cast<float>(at - a), row, relu, y + static_cast<std::size_t>(i) * row);
  }
}

}  // namespace

Dense ReadDense(TensorReader& tensors, const std::string& name, int rows, int columns) {
  return {tensors.Matrix(name + ".weight", rows, columns), tensors.Vector(name + ".bias", rows)};
}

EncoderBlock ReadEncoder(LayerReader& layers, const std::string& name, int level, int in, int out,
                         bool normalized) {
  EncoderBlock block{layers.ReadEncoder(name, level, in, out, 2), {}, {}, {}, {}};
  if (normalized) block.norm1 = layers.ReadNorm(name + ".norm1", in);
  block.time1 = ReadTimeConv(layers.tensors(), name + ".tconv1", in, 1);
  if (normalized) block.norm2 = layers.ReadNorm(name + ".norm2", in);
  block.time2 = ReadTimeConv(layers.tensors(), name + ".tconv2", out, kPathShare);
  return block;
}

DecoderBlock ReadDecoder(LayerReader& layers, const std::string& name, int level, int in, int out) {
  DecoderBlock block{layers.ReadDecoder(name, level, in, out), {}, {}, {}, {}};
  block.adain1 = ReadAdaIn(layers.tensors(), name + ".adain1", in);
  block.time1 = ReadTimeConv(layers.tensors(), name + ".tconv1", out, 1);
  block.adain2 = ReadAdaIn(layers.tensors(), name + ".adain2", out);
  block.time2 = ReadTimeConv(layers.tensors(), name + ".tconv2", out, kPathShare);
  return block;
}

const float* RunInput(const RowKernels& kernels, const Linear& in, const Standardization& standard,
                      std::span<const Features> clip, int frames, Scratch& s) {
  float* const x = Sized(s.frames, Size(frames, kFeatureCount));
  for (int frame = 0; frame < frames; ++frame) {
    const Features& from = clip[std::min(static_cast<std::size_t>(frame), clip.size() - 1)];
    float* const to = x + Size(frame, kFeatureCount);
    for (std::size_t i = 0; i < kFeatureCount; ++i)
      to[i] = (from[i] - standard.mean[i]) * standard.inverse_deviation[i];
  }
  const RowTerm term{x, kChannels};
  float* const y = Sized(s.out[1], Size(frames, kNodes[0], in.weight.columns()));
  kernels.product({&in.weight,
                   {&term, 1},
                   frames * kNodes[0],
                   in.bias.data(),
                   in.bias_rows,
                   nullptr,
                   false,
                   y,
                   in.weight.columns()});
  return y;
}

void RunEncoder(const RowKernels& kernels, const EncoderBlock& block, const float* x, int frames,
                float* y, Scratch& s) {
  const int half = frames / 2, wide = block.graph1.in_nodes(), nodes = block.graph1.out_nodes();
  const Affine norm1 = InstanceNorm(kernels, block.norm1, x, frames, wide, block.in);
  float* const time1 = block.time1.Prepare(s.time1, half, nodes);
  ConvolveGraph(kernels, block.graph1, norm1, x, half, true, true, time1, s);
  // The skip path: the mean of two frames and of each cluster.
  const auto frame = static_cast<std::ptrdiff_t>(Size(wide, block.in));
  const std::array<RowMixture::Input, 2> pair{{{x, 2 * frame}, {x + frame, 2 * frame}}};
  float* const skip = Sized(s.skip, Size(half, nodes, block.in));
  kernels.mix({block.pool_begins, block.pool_parts, pair, half, block.in, nullptr, false, skip});

  float* const between = Sized(s.between, Size(half, nodes, block.in));
  block.time1.Run(kernels, time1, half, nodes, {}, between, s.time);
  const Affine norm2 = InstanceNorm(kernels, block.norm2, between, half, nodes, block.in);
  float* const time2 = block.time2.Prepare(s.time2, half, nodes);
  ConvolveGraph(kernels, block.graph2, norm2, between, half, false, true, time2, s);
  Multiply(kernels, block.skip, skip, half * nodes, y);
  block.time2.Run(kernels, time2, half, nodes, {y, nodes}, y, s.time);
}

void RunDecoder(const RowKernels& kernels, const DecoderBlock& block, const Code& code,
                const float* x, int frames, float* y, Scratch& s) {
  const int twice = 2 * frames, nodes = block.graph1.in_nodes(), wide = block.graph2.out_nodes();
  const std::size_t row = Size(nodes, block.out);
  const Affine norm1 =
      AdaptiveNorm(kernels, block.adain1, code, x, frames, nodes, block.in, kEqualWeights);
  float* const pooled = Sized(s.pooled, Size(frames, nodes, block.out));
  ConvolveGraph(kernels, block.graph1, norm1, x, frames, false, false, pooled, s);
  // Unpooling over space copies nodes. Until they mix, one copy is enough.
  float* const time1 = block.time1.Prepare(s.time1, twice, nodes);
  UnpoolTime(kernels, pooled, frames, row, true, time1);
  float* const between = Sized(s.between, static_cast<std::size_t>(twice) * row);
  block.time1.Run(kernels, time1, twice, nodes, {}, between, s.time);
  const Affine norm2 = AdaptiveNorm(kernels, block.adain2, code, between, twice, nodes, block.out,
                                    block.cluster_sizes);
  float* const time2 = block.time2.Prepare(s.time2, twice, wide);
  ConvolveGraph(kernels, block.graph2, norm2, between, twice, false, true, time2, s);

  // The skip path: its product commutes with both unpoolings, of which the copies are not made.
  Multiply(kernels, block.skip, x, frames * nodes, pooled);
  float* const skip = Sized(s.skip, static_cast<std::size_t>(twice) * row);
  UnpoolTime(kernels, pooled, frames, row, false, skip);
  block.time2.Run(kernels, time2, twice, wide, {skip, nodes, block.clusters.data()}, y, s.time);
}

}  // namespace styled::stgcn
