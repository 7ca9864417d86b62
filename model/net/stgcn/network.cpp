#include "model/net/stgcn/network.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "model/net/stgcn/weights.h"

namespace styled::stgcn {
namespace {

using net::RowKernels;
using net::RowMixture;
using net::RowTerm;

constexpr float kLeak = 0.2F;  // of the leaky ReLU, also in net::RowKernels::activate
// Frames of one graph convolution at a time: its products then stay in the second-level cache.
constexpr int kBlockFrames = 16;
// Windows of a reference that share one reading of the style encoder's largest matrix (21 MB).
constexpr int kWindowsTogether = 8;

std::size_t Size(int a, int b, int c = 1) {
  return static_cast<std::size_t>(a) * static_cast<std::size_t>(b) * static_cast<std::size_t>(c);
}

// A row's scale and shift by channel: of a normalization, or nothing.
struct Affine {
  std::vector<float> scale, shift;
  const float* by() const { return scale.empty() ? nullptr : scale.data(); }
  const float* to() const { return scale.empty() ? nullptr : shift.data(); }
};

// x̂ = (x - mean) / sqrt(variance + ε) over all rows of x, as scale and shift. Row r counts
// `weights`[r mod period] times.
Affine Normalization(const RowKernels& kernels, const float* x, int frames, int nodes, int channels,
                     std::span<const float> weights) {
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

// After the normalization a scale and a shift of its own.
void Follow(std::span<const float> scale, std::span<const float> shift, Affine& affine) {
  for (std::size_t c = 0; c < scale.size(); ++c) {
    affine.scale[c] *= scale[c];
    affine.shift[c] = affine.shift[c] * scale[c] + shift[c];
  }
}

Affine InstanceNorm(const RowKernels& kernels, const Norm& norm, const float* x, int frames,
                    int nodes, int channels) {
  if (norm.scale.empty()) return {};
  Affine affine = Normalization(kernels, x, frames, nodes, channels, kEqualWeights);
  Follow(norm.scale, norm.shift, affine);
  return affine;
}

// (1 + γ) x̂ + β, with γ and β from the code.
Affine AdaptiveNorm(const RowKernels& kernels, const AdaIn& adain, const Code& code, const float* x,
                    int frames, int nodes, int channels, std::span<const float> weights) {
  Affine affine = Normalization(kernels, x, frames, nodes, channels, weights);
  const Eigen::VectorXf both = adain.weight * code + adain.bias;
  const auto count = static_cast<std::size_t>(channels);
  Follow({both.data(), count}, {both.data() + count, count}, affine);
  return affine;
}

float* Sized(net::AlignedFloats& buffer, std::size_t size) {
  buffer.Grow(size);
  return buffer.data();
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

// x: [frames, V, in]; y: [frames / 2, V', out].
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

// x: [frames, V', in]; y: [2 frames, V, out].
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

// The standardized features of `clip`, filled up with its last frame to `frames`, through the input
// layer. Returns [frames, 21, width].
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

Eigen::VectorXf Apply(const Dense& dense, const Eigen::VectorXf& x) {
  return dense.weight * x + dense.bias;
}

// A reference shorter than a window: both ends repeated, the clip in the middle. Empty if the clip
// is long enough.
std::vector<Features> FilledReference(std::span<const Features> clip) {
  std::vector<Features> filled;
  if (clip.size() >= kReference) return filled;
  const std::size_t before = (kReference - clip.size()) / 2;
  filled.assign(kReference, clip.back());
  std::fill_n(filled.begin(), before, clip.front());
  std::copy(clip.begin(), clip.end(), filled.begin() + static_cast<std::ptrdiff_t>(before));
  return filled;
}

// The windows of a reference: their first frames. One window of a short clip.
std::vector<int> WindowBegins(std::size_t frames) {
  std::vector<int> begins{0};
  for (std::size_t begin = kReferenceHop; begin + kReference <= frames; begin += kReferenceHop) {
    begins.push_back(static_cast<int>(begin));
  }
  return begins;
}

}  // namespace

Network::~Network() = default;

int Network::width() const { return weights_->width; }

const Code& Network::mean_code(int domain) const {
  return weights_->mean_codes[static_cast<std::size_t>(domain)];
}

void Network::Encode(std::span<const Features> clip, Content& content, Scratch& scratch) const {
  assert(clip.size() >= kLeastFrames);
  const Weights& w = *weights_;
  const int frames = (static_cast<int>(clip.size()) + 3) / 4 * 4;
  const float* const in = RunInput(*w.kernels, w.generator.in, w.standard, clip, frames, scratch);
  const auto& [first, second] = w.generator.encoder;
  float* const middle = Sized(scratch.out[0], Size(frames / 2, kNodes[1], first.out));
  RunEncoder(*w.kernels, first, in, frames, middle, scratch);
  content.frames = static_cast<int>(clip.size());
  content.values.Grow(Size(frames / 4, kNodes[2], second.out));
  RunEncoder(*w.kernels, second, middle, frames / 2, content.values.data(), scratch);
}

void Network::Decode(const Content& content, const Code& code, std::span<Features> out,
                     Scratch& scratch) const {
  assert(out.size() == static_cast<std::size_t>(content.frames));
  const Weights& w = *weights_;
  const int frames = (content.frames + 3) / 4 * 4;
  const auto& [first, second] = w.generator.decoder;
  float* const middle = Sized(scratch.out[0], Size(frames / 2, kNodes[1], first.out));
  RunDecoder(*w.kernels, first, code, content.values.data(), frames / 4, middle, scratch);
  float* const last = Sized(scratch.out[1], Size(frames, kNodes[0], second.out));
  RunDecoder(*w.kernels, second, code, middle, frames / 2, last, scratch);

  const Linear& head = w.generator.out;
  const int columns = head.weight.columns();
  float* const y = Sized(scratch.frames, Size(frames, kNodes[0], columns));
  const RowTerm term{last, second.out};
  w.kernels->product({&head.weight,
                      {&term, 1},
                      frames * kNodes[0],
                      head.bias.data(),
                      1,
                      nullptr,
                      false,
                      y,
                      columns});
  for (std::size_t frame = 0; frame < out.size(); ++frame) {
    for (std::size_t i = 0; i < kFeatureCount; ++i) {
      const std::size_t row = frame * kNodes[0] + i / kChannels;
      const float value = y[row * static_cast<std::size_t>(columns) + i % kChannels];
      out[frame][i] = value * w.standard.deviation[i] + w.standard.mean[i];
    }
    // Constant in every pose; the network's output there is noise.
    out[frame][kChannels * body::kHips] = out[frame][kChannels * body::kHips + 2] = 0;
  }
}

Code Network::EncodeStyle(std::span<const Features> clip, int domain, Scratch& scratch) const {
  assert(!clip.empty() && domain >= kFreeHead && domain < domain_count());
  const StyleEncoderWeights& e = weights_->encoder;
  const std::vector<Features> filled = FilledReference(clip);
  if (!filled.empty()) clip = filled;
  const std::vector<int> begins = WindowBegins(clip.size());
  const int deep = e.conv.weight.depths()[0], out = e.conv.weight.columns();
  net::AlignedFloats trunk(Size(kWindowsTogether, deep)), hidden(Size(kWindowsTogether, out));
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(out);
  for (std::size_t done = 0; done < begins.size(); done += kWindowsTogether) {
    const int count = std::min<int>(kWindowsTogether, static_cast<int>(begins.size() - done));
    for (int i = 0; i < count; ++i) {
      const auto begin = static_cast<std::size_t>(begins[done + static_cast<std::size_t>(i)]);
      EncodeWindow(clip.subspan(begin, kReference), trunk.data() + Size(i, deep), scratch);
    }
    const RowTerm term{trunk.data(), deep};
    weights_->kernels->product({&e.conv.weight,
                                {&term, 1},
                                count,
                                e.conv.bias.data(),
                                1,
                                nullptr,
                                false,
                                hidden.data(),
                                out});
    const Eigen::Map<const net::RowMajor> rows(hidden.data(), count, out);
    sum += rows.cwiseMax(kLeak * rows).colwise().sum().transpose().cast<double>();
  }
  // Heads are linear: the code of the mean is the mean of the codes.
  const Eigen::VectorXf mean = (sum / static_cast<double>(begins.size())).cast<float>();
  const auto head = domain == kFreeHead ? e.heads.size() - 1 : static_cast<std::size_t>(domain);
  return Apply(e.heads[head], mean);
}

// The style encoder's blocks on one window: [16, 5, 4 width], activated.
void Network::EncodeWindow(std::span<const Features> window, float* y, Scratch& scratch) const {
  const StyleEncoderWeights& e = weights_->encoder;
  const RowKernels& kernels = *weights_->kernels;
  const auto& [first, second] = e.blocks;
  const float* const in = RunInput(kernels, e.in, weights_->standard, window, kReference, scratch);
  float* const middle = Sized(scratch.out[0], Size(kReference / 2, kNodes[1], first.out));
  RunEncoder(kernels, first, in, kReference, middle, scratch);
  RunEncoder(kernels, second, middle, kReference / 2, y, scratch);
  kernels.activate(y, nullptr, kReference / 4 * kNodes[2], second.out, nullptr, nullptr, y);
}

Code Network::MapNoise(const Noise& noise, int domain) const {
  assert(domain >= 0 && domain < domain_count());
  const MappingWeights& f = weights_->mapping;
  const auto relu = [](const Eigen::VectorXf& x) -> Eigen::VectorXf { return x.cwiseMax(0.0F); };
  Eigen::VectorXf both(f.noise.bias.size() + f.label.bias.size());
  both << relu(Apply(f.noise, noise)), relu(f.label.weight.col(domain) + f.label.bias);
  const Eigen::VectorXf hidden = relu(Apply(f.second, relu(Apply(f.first, both))));
  return Apply(f.out, hidden).array().tanh();
}

}  // namespace styled::stgcn
