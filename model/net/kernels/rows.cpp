#include "model/net/kernels/rows.h"

#include <cassert>
#include <type_traits>

// Targets with scalable vectors are disabled: such vectors cannot be stored in arrays.
#define HWY_DISABLED_TARGETS (HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_RVV)
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "model/net/kernels/rows.cpp"
#include <hwy/foreach_target.h>  // must precede highway.h, which compiles for that target
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace styled::net {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;
using D = hn::CappedTag<float, 16>;
using V = hn::Vec<D>;
constexpr D d;
constexpr int kLanes = hn::MaxLanes(d);
constexpr int kVectors = kRowPanel / kLanes;  // per panel
// The tile whose sums fill the registers without spilling: with 32 (AVX-512) 8 x 2 vectors leave
// room for loads ahead and were faster than 12 x 2 where the rows do not divide by 12 (240 against
// 190 GFLOP/s at 80 rows, equal at 1,344); with 16, 6 x 2 or 2 x 4.
constexpr int kTilePanels = kLanes == 16 ? 2 : 1;
constexpr int kTileRows = kLanes == 16 ? 8 : kLanes == 8 ? 6 : 2;

int Columns(const RowProduct& product) {
  return product.columns > 0 ? product.columns : product.weights->columns();
}

// The larger of two. A y that is NaN stays NaN, so that a check of the output finds it: x86 takes
// the second then; on ARM Highway's Max would take the one that is a number.
HWY_INLINE V AtLeast(V least, V y) {
#if HWY_ARCH_ARM_A64 && HWY_TARGET < HWY_EMU128
  return V{vmaxq_f32(least.raw, y.raw)};
#else
  return hn::Max(least, y);
#endif
}

// One tile: `Rows` rows from `row` on, `Panels` panels from `panel` on.
template <int Rows, int Panels, bool Ahead>
HWY_INLINE void Tile(const RowProduct& product, int panel, int row) {
  constexpr int kSome = Panels * kVectors;
  V sum[Rows][kSome];
  HWY_UNROLL(16)
  for (int r = 0; r < Rows; ++r) {
    HWY_UNROLL(8)
    for (int v = 0; v < kSome; ++v) sum[r][v] = hn::Zero(d);
  }
  const std::span<const int> depths = product.weights->depths();
  std::ptrdiff_t depth = 0;
  for (const int one : depths) depth += one;
  const std::ptrdiff_t panel_stride = depth * kRowPanel;
  const int first = product.first_column / kRowPanel;
  const float* HWY_RESTRICT weights = product.weights->data() + (first + panel) * panel_stride;
  for (std::size_t t = 0; t < depths.size(); ++t) {
    const std::ptrdiff_t stride = product.terms[t].stride;
    const float* HWY_RESTRICT x = product.terms[t].x + row * stride;
    const auto one = [&](int channel) HWY_ATTR {
      V weight[kSome];
      HWY_UNROLL(8)
      for (int v = 0; v < kSome; ++v) {
        weight[v] = hn::Load(d, weights + v / kVectors * panel_stride + v % kVectors * kLanes);
      }
      HWY_UNROLL(16)
      for (int r = 0; r < Rows; ++r) {
        const V factor = hn::Set(d, x[r * stride + channel]);
        HWY_UNROLL(8)
        for (int v = 0; v < kSome; ++v) sum[r][v] = hn::MulAdd(factor, weight[v], sum[r][v]);
      }
      if (Ahead) {
        HWY_UNROLL(4)
        for (int p = 0; p < Panels; ++p) {
          __builtin_prefetch(weights + (Panels + p) * panel_stride, 0, 2);
        }
      }
      weights += kRowPanel;
    };
    int channel = 0;
    for (; channel + 4 <= depths[t]; channel += 4) {
      one(channel);
      one(channel + 1);
      one(channel + 2);
      one(channel + 3);
    }
    for (; channel < depths[t]; ++channel) one(channel);
  }
  const V least = hn::Set(d, product.relu ? 0.0F : hwy::LowestValue<float>());
  const int column = panel * kRowPanel;
  HWY_UNROLL(16)
  for (int r = 0; r < Rows; ++r) {
    const std::ptrdiff_t at = (row + r) * product.stride + column;
    const float* bias = nullptr;
    if (product.bias != nullptr) {
      bias =
          product.bias + std::ptrdiff_t{(row + r) % product.bias_rows} * Columns(product) + column;
    }
    HWY_UNROLL(8)
    for (int v = 0; v < kSome; ++v) {
      V y = sum[r][v];
      if (bias != nullptr) y = hn::Add(y, hn::LoadU(d, bias + v * kLanes));
      if (product.add != nullptr) y = hn::Add(y, hn::LoadU(d, product.add + at + v * kLanes));
      hn::StoreU(AtLeast(least, y), d, product.y + at + v * kLanes);
    }
  }
}

// All rows of a panel, in tiles of `Rows`, then the rest in halves.
template <int Rows, int Panels>
HWY_INLINE void Column(const RowProduct& product, int panel, int row) {
  if (row == 0 && Rows <= product.rows) {
    Tile<Rows, Panels, true>(product, panel, row);
    row += Rows;
  }
  for (; row + Rows <= product.rows; row += Rows) Tile<Rows, Panels, false>(product, panel, row);
  constexpr int kFewer = Rows == 3 ? 1 : (Rows + 1) / 2;  // 8 4 2 1, 6 3 1
  if constexpr (Rows > 1) {
    if (row < product.rows) Column<kFewer, Panels>(product, panel, row);
  }
}

// Panels outermost: a panel's weights stay in the first-level cache while the rows pass.
void Product(const RowProduct& product) noexcept {
  const int panels = Columns(product) / kRowPanel;
  int panel = 0;
  for (; panel + kTilePanels <= panels; panel += kTilePanels) {
    Column<kTileRows, kTilePanels>(product, panel, 0);
  }
  if constexpr (kTilePanels > 1) {
    for (; panel < panels; ++panel) Column<kTileRows, 1>(product, panel, 0);
  }
}

constexpr int kAtATime = 4;  // vectors that pass together: independent chains of additions

// Calls some(first channel, count of vectors as a constant) for all channels.
template <typename Some>
HWY_INLINE void ForChannels(int channels, Some some) {
  constexpr int kWide = kAtATime * kLanes;
  int channel = 0;
  for (; channel + kWide <= channels; channel += kWide) {
    some(channel, std::integral_constant<int, kAtATime>());
  }
  for (; channel < channels; channel += kLanes) some(channel, std::integral_constant<int, 1>());
}

void Mix(const RowMixture& mixture) noexcept {
  const auto rows = static_cast<std::ptrdiff_t>(mixture.begins.size()) - 1;
  const std::ptrdiff_t channels = mixture.channels;
  const V least = hn::Set(d, mixture.relu ? 0.0F : hwy::LowestValue<float>());
  for (std::ptrdiff_t frame = 0; frame < mixture.frames; ++frame) {
    for (std::ptrdiff_t row = 0; row < rows; ++row) {
      const int begin = mixture.begins[static_cast<std::size_t>(row)];
      const int end = mixture.begins[static_cast<std::size_t>(row) + 1];
      float* const y = mixture.y + (frame * rows + row) * channels;
      ForChannels(mixture.channels, [&](int channel, auto vectors) HWY_ATTR {
        V sum[vectors];
        for (int v = 0; v < vectors; ++v) {
          sum[v] = mixture.constant == nullptr
                       ? hn::Zero(d)
                       : hn::LoadU(d, mixture.constant + row * channels + channel + v * kLanes);
        }
        for (int i = begin; i < end; ++i) {
          const RowMixture::Part& part = mixture.parts[static_cast<std::size_t>(i)];
          const RowMixture::Input& input = mixture.inputs[static_cast<std::size_t>(part.input)];
          const float* const x = input.x + frame * input.frame + part.row * channels + channel;
          const V share = hn::Set(d, part.share);
          for (int v = 0; v < vectors; ++v) {
            sum[v] = hn::MulAdd(share, hn::LoadU(d, x + v * kLanes), sum[v]);
          }
        }
        for (int v = 0; v < vectors; ++v) {
          hn::StoreU(AtLeast(least, sum[v]), d, y + channel + v * kLanes);
        }
      });
    }
  }
}

HWY_INLINE V Leaky(V x) { return hn::Max(hn::Mul(hn::Set(d, 0.2F), x), x); }

void Activate(const float* x, const float* other, int rows, int channels, const float* scale,
              const float* shift, float* y) noexcept {
  const V half = hn::Set(d, 0.5F);
  for (int channel = 0; channel < channels; channel += kLanes) {
    const V by = scale == nullptr ? hn::Set(d, 1.0F) : hn::LoadU(d, scale + channel);
    const V to = scale == nullptr ? hn::Zero(d) : hn::LoadU(d, shift + channel);
    for (int row = 0; row < rows; ++row) {
      const std::ptrdiff_t at = std::ptrdiff_t{row} * channels + channel;
      V value = Leaky(hn::MulAdd(hn::LoadU(d, x + at), by, to));
      if (other != nullptr) {
        const V second = Leaky(hn::MulAdd(hn::LoadU(d, other + at), by, to));
        value = hn::Mul(half, hn::Add(value, second));
      }
      hn::StoreU(value, d, y + at);
    }
  }
}

void Sum(const float* x, int rows, int channels, const float* weights, int period,
         const float* centre, int power, float* sum) noexcept {
  ForChannels(channels, [&](int channel, auto vectors) HWY_ATTR {
    V total[vectors], middle[vectors];
    for (int v = 0; v < vectors; ++v) {
      total[v] = hn::Zero(d);
      middle[v] = hn::LoadU(d, centre + channel + v * kLanes);
    }
    for (int row = 0, phase = 0; row < rows; ++row, phase = phase + 1 < period ? phase + 1 : 0) {
      const V weight = hn::Set(d, weights[phase]);
      const float* const from = x + std::ptrdiff_t{row} * channels + channel;
      for (int v = 0; v < vectors; ++v) {
        const V off = hn::Sub(hn::LoadU(d, from + v * kLanes), middle[v]);
        const V term = power == 2 ? hn::Mul(off, off) : off;
        total[v] = hn::MulAdd(weight, term, total[v]);
      }
    }
    for (int v = 0; v < vectors; ++v) hn::StoreU(total[v], d, sum + channel + v * kLanes);
  });
}

void Blend(const float* a, const float* b, float share, std::size_t count, bool relu,
           float* y) noexcept {
  const V of_a = hn::Set(d, 1 - share), of_b = hn::Set(d, share);
  const V least = hn::Set(d, relu ? 0.0F : hwy::LowestValue<float>());
  for (std::size_t i = 0; i < count; i += kLanes) {
    const V mean = hn::MulAdd(of_a, hn::LoadU(d, a + i), hn::Mul(of_b, hn::LoadU(d, b + i)));
    hn::StoreU(AtLeast(least, mean), d, y + i);
  }
}

// The matrix B of F(4, 3): rows (4 0 -5 0 1 0), (0 -4 -4 1 1 0), (0 4 -4 -1 1 0), (0 -2 -1 2 1 0),
// (0 2 -1 -2 1 0), (0 4 0 -5 0 1).
void Turn(const float* x, int frame, float* y, std::ptrdiff_t plane) noexcept {
  const V two = hn::Set(d, 2.0F), four = hn::Set(d, 4.0F), five = hn::Set(d, 5.0F);
  for (int i = 0; i < frame; i += kLanes) {
    V in[kTile + 2];
    for (int t = 0; t < kTile + 2; ++t) in[t] = hn::LoadU(d, x + std::ptrdiff_t{t} * frame + i);
    const V even = hn::NegMulAdd(four, in[2], in[4]), odd = hn::NegMulAdd(four, in[1], in[3]);
    const V far = hn::Sub(in[4], in[2]), wide = hn::Mul(two, hn::Sub(in[3], in[1]));
    const V out[kTurned] = {hn::MulAdd(four, in[0], hn::NegMulAdd(five, in[2], in[4])),
                            hn::Add(even, odd),
                            hn::Sub(even, odd),
                            hn::Add(far, wide),
                            hn::Sub(far, wide),
                            hn::MulAdd(four, in[1], hn::NegMulAdd(five, in[3], in[5]))};
    for (int p = 0; p < kTurned; ++p) hn::StoreU(out[p], d, y + p * plane + i);
  }
}

// The matrix A of F(4, 3): rows (1 1 1 1 1 0), (0 1 -1 2 -2 0), (0 1 1 4 4 0), (0 1 -1 8 -8 1).
void TurnBack(const TurnedTile& tile) noexcept {
  const V two = hn::Set(d, 2.0F), four = hn::Set(d, 4.0F), eight = hn::Set(d, 8.0F);
  const std::ptrdiff_t frame = std::ptrdiff_t{tile.nodes} * tile.channels;
  const std::ptrdiff_t add_frame = std::ptrdiff_t{tile.add_rows} * tile.channels;
  for (std::ptrdiff_t node = 0; node < tile.nodes; ++node) {
    const std::ptrdiff_t row = tile.add_row != nullptr ? tile.add_row[node] : node;
    for (int channel = 0; channel < tile.channels; channel += kLanes) {
      const std::ptrdiff_t at = node * tile.channels + channel;
      V in[kTurned];
      for (int p = 0; p < kTurned; ++p) in[p] = hn::LoadU(d, tile.x + p * tile.plane + at);
      const V sum1 = hn::Add(in[1], in[2]), sum2 = hn::Add(in[3], in[4]);
      const V less1 = hn::Sub(in[1], in[2]), less2 = hn::Sub(in[3], in[4]);
      const V of = hn::LoadU(d, tile.bias + channel);
      const V out[kTile] = {hn::Add(of, hn::Add(in[0], hn::Add(sum1, sum2))),
                            hn::Add(of, hn::MulAdd(two, less2, less1)),
                            hn::Add(of, hn::MulAdd(four, sum2, sum1)),
                            hn::Add(of, hn::Add(in[5], hn::MulAdd(eight, less2, less1)))};
      for (int t = 0; t < tile.frames; ++t) {
        V y = out[t];
        if (tile.add != nullptr) {
          y = hn::Add(y, hn::LoadU(d, tile.add + t * add_frame + row * tile.channels + channel));
        }
        hn::StoreU(y, d, tile.y + t * frame + at);
      }
    }
  }
}

}  // namespace

const RowKernels& TargetRowKernels() {
  static const RowKernels kernels{
      hwy::TargetName(HWY_TARGET), Product, Mix, Activate, Sum, Blend, Turn, TurnBack};
  return kernels;
}

}  // namespace HWY_NAMESPACE
}  // namespace styled::net
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace styled::net {

HWY_EXPORT(TargetRowKernels);
const RowKernels& BestRowKernels() { return HWY_DYNAMIC_DISPATCH(TargetRowKernels)(); }

PackedColumns::PackedColumns(std::span<const int> depths, int columns)
    : depths_(depths.begin(), depths.end()), columns_(PaddedColumns(columns)) {
  for (const int depth : depths_) {
    begins_.push_back(depth_);
    depth_ += depth;
  }
  values_.Grow(static_cast<std::size_t>(depth_) * static_cast<std::size_t>(columns_));
}

float& PackedColumns::At(std::size_t term, int column, int channel) {
  assert(column >= 0 && column < columns_ && channel >= 0 && channel < depths_[term]);
  const std::size_t panel = static_cast<std::size_t>(column / kRowPanel);
  const std::size_t deep =
      static_cast<std::size_t>(begins_[term]) + static_cast<std::size_t>(channel);
  return values_.data()[(panel * static_cast<std::size_t>(depth_) + deep) * kRowPanel +
                        static_cast<std::size_t>(column % kRowPanel)];
}

}  // namespace styled::net
#endif
