#include "model/net/stgcn_causal/network.h"

#include <algorithm>
#include <cassert>

#include "model/net/stgcn/codes.h"
#include "model/net/stgcn/size.h"
#include "model/net/stgcn_causal/weights.h"

namespace styled::stgcn_causal {
namespace {

using net::RowKernels;
using net::RowTerm;
using net::StyleWeight;
using net::VariationWeight;
using stgcn::kChannels;
using stgcn::kFeatureCount;
using stgcn::kNodes;
using stgcn::Size;

// The data that the layers of one step share.
struct Frame {
  const RowKernels& kernels;
  float* memory;  // of the stream
  std::uint64_t number;
  Forgetting past;
  const Scratch& scratch;

  float* At(std::size_t place) const noexcept { return memory + place; }
};

// y = x W' + bias, `rows` rows one after the other.
void Apply(const Frame& frame, const stgcn::Linear& linear, const float* x, int rows,
           float* y) noexcept {
  const RowTerm term{x, linear.weight.depths()[0]};
  frame.kernels.product({&linear.weight,
                         {&term, 1},
                         rows,
                         linear.bias.data(),
                         linear.bias_rows,
                         nullptr,
                         false,
                         y,
                         linear.weight.columns()});
}

// The same without a bias.
void Multiply(const Frame& frame, const net::PackedColumns& weight, const float* x, int rows,
              float* y) noexcept {
  const RowTerm term{x, weight.depths()[0]};
  frame.kernels.product(
      {&weight, {&term, 1}, rows, nullptr, 1, nullptr, false, y, weight.columns()});
}

// LReLU(scale' x̂ + shift'), with the statistics that x is accumulated into. y: [nodes, channels].
void Normalize(const Frame& frame, const PastNorm& norm, const float* by, const float* to,
               const float* x, int copy, int nodes, int channels, float* y) noexcept {
  float* const scale = frame.At(frame.scratch.affine);
  float* const shift = scale + channels;
  norm.Advance(frame.kernels, x, copy, frame.past, frame.memory, scale, shift,
               frame.At(frame.scratch.sums));
  for (int c = 0; c < channels; ++c) {
    scale[c] *= by[c];
    shift[c] = shift[c] * by[c] + to[c];
  }
  frame.kernels.activate(x, nullptr, nodes, channels, scale, shift, y);
}

// x: [V, in]; y: [V', out].
void RunEncoder(const Frame& frame, const EncoderBlock& block, const float* x, float* y) noexcept {
  const RowKernels& kernels = frame.kernels;
  const int wide = block.graph1.in_nodes(), nodes = block.graph1.out_nodes();
  float* const activated = frame.At(frame.scratch.activated);
  float* const graph = frame.At(frame.scratch.graph);
  Normalize(frame, block.norm1, block.affine1.scale.data(), block.affine1.shift.data(), x, 0, wide,
            block.in, activated);
  block.graph1.Run(kernels, activated, 1, true, block.time1.Input(frame.memory, frame.number),
                   graph);
  float* const between = frame.At(frame.scratch.between);
  block.time1.Run(kernels, frame.memory, frame.number, 1, nullptr, between);
  Normalize(frame, block.norm2, block.affine2.scale.data(), block.affine2.shift.data(), between, 0,
            nodes, block.in, activated);
  block.graph2.Run(kernels, activated, 1, true, block.time2.Input(frame.memory, frame.number),
                   graph);
  // The skip path: the mean of each cluster.
  float* const skip = frame.At(frame.scratch.skip);
  const net::RowMixture::Input input{x, 0};
  kernels.mix(
      {block.pool_begins, block.pool_parts, {&input, 1}, 1, block.in, nullptr, false, skip});
  Multiply(frame, block.skip, skip, nodes, y);
  block.time2.Run(kernels, frame.memory, frame.number, 1, y, y);
}

// For the first `count` decodings, x: [count, V', in], or one for all of them; points: [count,
// size]; y: [count, V, out].
void RunDecoder(const Frame& frame, const DecoderBlock& block, const float* x, bool one_for_all,
                const float* points, std::size_t size, int count, float* y) noexcept {
  const RowKernels& kernels = frame.kernels;
  const int nodes = block.graph1.in_nodes(), wide = block.graph2.out_nodes();
  const std::size_t from = one_for_all ? 0 : Size(nodes, block.in), to = Size(nodes, block.out);
  float* const activated = frame.At(frame.scratch.activated);
  float* const graph = frame.At(frame.scratch.graph);
  for (int i = 0; i < count; ++i) {
    const auto at = static_cast<std::size_t>(i);
    const float* const by = points + at * size + block.adain1;
    Normalize(frame, block.norm1, by, by + block.in, x + at * from, i, nodes, block.in,
              activated + at * Size(nodes, block.in));
  }
  // Unpooling copies nodes. Until they mix, one copy is enough.
  block.graph1.Run(kernels, activated, count, true, block.time1.Input(frame.memory, frame.number),
                   graph);
  float* const between = frame.At(frame.scratch.between);
  block.time1.Run(kernels, frame.memory, frame.number, count, nullptr, between);
  for (int i = 0; i < count; ++i) {
    const auto at = static_cast<std::size_t>(i);
    const float* const by = points + at * size + block.adain2;
    Normalize(frame, block.norm2, by, by + block.out, between + at * to, i, nodes, block.out,
              activated + at * to);
  }
  block.graph2.Run(kernels, activated, count, true, block.time2.Input(frame.memory, frame.number),
                   graph);
  // The skip path: its product commutes with the unpooling.
  float* const skip = frame.At(frame.scratch.skip);
  Multiply(frame, block.skip, x, one_for_all ? nodes : count * nodes, skip);
  float* row = y;
  for (int i = 0; i < count; ++i) {
    const float* const rows = skip + (one_for_all ? 0 : static_cast<std::size_t>(i) * to);
    for (const int cluster : block.clusters) {
      row = std::copy_n(rows + Size(cluster, block.out), block.out, row);
    }
  }
  assert(row == y + static_cast<std::size_t>(count) * Size(wide, block.out));
  block.time2.Run(kernels, frame.memory, frame.number, count, y, y);
}

// The requested styles, each once.
class Requested {
 public:
  Requested(std::span<const StyleWeight> active, int style_count) noexcept {
    for (const StyleWeight& style : active) {
      if (style.style > 0 && style.style < style_count) Add(style);
    }
    float sum = 0;
    for (int i = 0; i < count_; ++i) sum += entries_[static_cast<std::size_t>(i)].weight;
    any_ = sum > 0;
    scale_ = sum > net::kMaxStrength ? net::kMaxStrength / sum : 1.0F;
  }

  // Whether any weight is above 0.
  bool any() const noexcept { return any_; }
  // p_0 + Σ α_s (p_s - p_0)
  void WritePoint(const std::vector<std::shared_ptr<const Point>>& points,
                  float* point) const noexcept {
    const Point& neutral = *points[0];
    std::copy(neutral.begin(), neutral.end(), point);
    for (int i = 0; i < count_; ++i) {
      const StyleWeight& entry = entries_[static_cast<std::size_t>(i)];
      const float* const style = points[static_cast<std::size_t>(entry.style)]->data();
      const float weight = scale_ * entry.weight;
      for (std::size_t k = 0; k < neutral.size(); ++k) {
        point[k] += weight * (style[k] - neutral[k]);
      }
    }
  }

  // += Σ_s α_s Σ_k β_k (variation k of s - s)
  void Vary(const std::vector<int>& domains, const Variations& variations,
            std::span<const VariationWeight> weights, float* point) const noexcept {
    weights = weights.first(std::min<std::size_t>(weights.size(), net::kVariations));
    float sum = 0;
    for (const VariationWeight& weight : weights) sum += Share(weight);
    const float scale = sum > net::kMaxStrength ? net::kMaxStrength / sum : 1.0F;
    for (int i = 0; i < count_; ++i) {
      const StyleWeight& entry = entries_[static_cast<std::size_t>(i)];
      const int domain = domains[static_cast<std::size_t>(entry.style)];
      for (const VariationWeight& weight : weights) {
        const float share = scale_ * entry.weight * scale * Share(weight);
        if (share == 0) continue;
        const float* const way = variations.Of(domain, weight.variation);
        for (std::size_t k = 0; k < variations.size(); ++k) point[k] += share * way[k];
      }
    }
  }

 private:
  // 0 also for NaN.
  static float Clamped(float weight) noexcept {
    return weight > 0 ? std::min(weight, net::kMaxStrength) : 0.0F;
  }
  static float Share(const VariationWeight& weight) noexcept {
    const bool known = weight.variation >= 1 && weight.variation <= net::kVariations;
    return known ? Clamped(weight.weight) : 0.0F;
  }
  void Add(const StyleWeight& style) noexcept {
    const float clamped = Clamped(style.weight);
    for (int i = 0; i < count_; ++i) {
      StyleWeight& known = entries_[static_cast<std::size_t>(i)];
      if (known.style != style.style) continue;
      known.weight = std::min(known.weight + clamped, net::kMaxStrength);
      return;
    }
    if (count_ == net::kMaxActive) return;
    entries_[static_cast<std::size_t>(count_++)] = {style.style, clamped};
  }

  std::array<StyleWeight, net::kMaxActive> entries_;
  int count_ = 0;
  bool any_ = false;
  float scale_ = 1;
};

// From rows of `columns` floats, and a bias, to features' units.
void ToFeatures(const float* rows, int columns, const float* bias, const float* mean,
                const float* deviation, stgcn::Features& out) noexcept {
  for (std::size_t i = 0; i < kFeatureCount; ++i) {
    const float* const row = rows + i / kChannels * static_cast<std::size_t>(columns);
    out[i] = (row[i % kChannels] + bias[i]) * deviation[i] + mean[i];
  }
  // Constant in every pose; the network's output there is noise.
  out[kChannels * body::kHips] = out[kChannels * body::kHips + 2] = 0;
}

}  // namespace

Network::~Network() = default;

int Network::width() const { return weights_->width; }

std::span<const float> Network::inverse_deviation() const {
  return {weights_->inverse_deviation.data(), kFeatureCount};
}

const stgcn::CodeSpace& Network::space() const { return *weights_->space; }

const PointSpace& Network::points() const { return *weights_->points; }

std::shared_ptr<const Network> Network::With(int number, net::StyleInfo style,
                                             const net::StyleCode& code) const {
  assert(number >= space().domain_count() && number <= style_count());
  const auto at = static_cast<std::size_t>(number);
  const std::shared_ptr<Network> with(new Network(*this));
  with->points_.resize(std::max(points_.size(), at + 1));
  with->points_[at] = points().PointOf(code);
  with->domains_.resize(with->points_.size());
  with->domains_[at] = stgcn::Nearest(space(), Eigen::Map<const stgcn::Code>(code.data())).style;
  style.varies = true;
  with->model_.styles.resize(with->points_.size());
  with->model_.styles[at] = std::move(style);
  return with;
}

std::shared_ptr<const Network> Network::Retired(int number) const {
  assert(number >= space().domain_count() && number < style_count());
  const std::shared_ptr<Network> without(new Network(*this));
  without->model_.styles[static_cast<std::size_t>(number)].retired = true;
  return without;
}

State Network::MakeState() const {
  State state;
  state.memory.Grow(weights_->state_size);
  Start(state);
  return state;
}

void Network::Start(State& state) const noexcept {
  const Weights& w = *weights_;
  assert(state.memory.size() >= w.state_size);
  float* const memory = state.memory.data();
  const auto start_frames = static_cast<float>(w.start_frames);
  for (const EncoderBlock& block : w.encoder) {
    block.norm1.Start(start_frames, memory);
    block.norm2.Start(start_frames, memory);
  }
  for (const DecoderBlock& block : w.decoder) {
    block.norm1.Start(start_frames, memory);
    block.norm2.Start(start_frames, memory);
  }
  state.frame = 0;
  state.count = w.start_frames;
  state.alone = 0;
}

// Excludes the scratch, which a step writes before it reads: it is at the memory's end.
void Network::Carry(State& state, Checkpoint& c) const noexcept {
  const Weights& w = *weights_;
  std::span<float> kept(state.memory.data(), w.scratch.standardized);
  c(kept, state.frame, state.count);
  c.Within(state.alone, 0, kMemoriesAlone * w.memory);
}

void Network::Step(const stgcn::Features& features, int input_style,
                   std::span<const StyleWeight> active, State& state, Output& out,
                   std::span<const VariationWeight> variations) const noexcept {
  const Weights& w = *weights_;
  assert(state.memory.size() >= w.state_size);
  const double keep = 1 - 1.0 / w.memory;
  state.count = keep * state.count + 1;
  const Frame frame{*w.kernels,
                    state.memory.data(),
                    state.frame,
                    {static_cast<float>(keep), static_cast<float>(state.count)},
                    w.scratch};
  const Scratch& s = w.scratch;

  // 1. h = enc2(enc1(in(u)))
  w.vectors->standardize(features.data(), w.mean.data(), w.inverse_deviation.data(), kFeatureCount,
                         kMaxStandardized, frame.At(s.standardized));
  Apply(frame, w.in, frame.At(s.standardized), kNodes[0], frame.At(s.in));
  RunEncoder(frame, w.encoder[0], frame.At(s.in), frame.At(s.encoded[0]));
  RunEncoder(frame, w.encoder[1], frame.At(s.encoded[0]), frame.At(s.encoded[1]));

  // 2. The points, and whether the second decoder continues alone.
  const int own = input_style > 0 && input_style < style_count() ? input_style : 0;
  const Requested requested(active, style_count());
  const std::size_t size = w.points->size();
  float* const points = frame.At(s.points);
  std::copy_n(points_[static_cast<std::size_t>(own)]->data(), size, points);
  requested.WritePoint(points_, points + size);
  requested.Vary(domains_, *w.variations, variations, points + size);
  const bool differs = own != 0 || requested.any();
  if (differs) {
    if (state.alone == 0) w.ForDecoder([&](const auto& layer) { layer.Follow(frame.memory); });
    state.alone = kMemoriesAlone * w.memory;
  }
  const int count = state.alone > 0 ? kDecodings : 1;
  if (!differs && state.alone > 0) --state.alone;

  // 3. y = out(dec2(dec1(h, point), point)), for both points at once.
  RunDecoder(frame, w.decoder[0], frame.At(s.encoded[1]), true, points, size, count,
             frame.At(s.decoded[0]));
  RunDecoder(frame, w.decoder[1], frame.At(s.decoded[0]), false, points, size, count,
             frame.At(s.decoded[1]));
  float* const rows = frame.At(s.out);
  const int columns = w.out.weight.columns();
  Apply(frame, w.out, frame.At(s.decoded[1]), count * kNodes[0], rows);
  const float* const bias = points + w.points->bias();
  ToFeatures(rows, columns, bias, w.mean.data(), w.deviation.data(), out.reconstruction);
  if (count == 1) {
    out.styled = out.reconstruction;
  } else {
    ToFeatures(rows + Size(kNodes[0], columns), columns, bias + size, w.mean.data(),
               w.deviation.data(), out.styled);
  }
  ++state.frame;
}

}  // namespace styled::stgcn_causal
