#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

// Targets with scalable vectors are disabled: such vectors cannot be stored in arrays.
#define HWY_DISABLED_TARGETS (HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_RVV)
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "model/net/kernels/int8.cpp"
#include <hwy/foreach_target.h>  // must precede the next
#include <hwy/highway.h>

#include "model/net/kernels/int8-inl.h"
#include "model/net/kernels/lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace styled::net {
namespace HWY_NAMESPACE {
namespace {

// Weights of int8. A panel holds, two columns at a time, the weights of its rows one after another:
// 64 bytes, in the order of WeightIndex; and after its last columns, for each group of columns that
// share a number, the numbers of its rows. A sum of products of whole numbers is below 2^31: 64
// columns of 127 * 32767.
using DI = hn::RebindToSigned<D>;
using VI = hn::Vec<DI>;
constexpr DI di;
using DH = hn::Repartition<std::int16_t, D>;
constexpr DH dh;
constexpr float kMostWeight = 127, kMostInput = 32767;
constexpr float kLeastScale = 1e-30F;  // smaller weights are 0: none divides by 0 or is subnormal
static_assert(kScaleColumns * 127LL * 32767 < 1LL << 31);

constexpr int Pairs(int columns) { return (columns + 1) / 2; }
constexpr int Groups(int columns, int together) { return (columns + together - 1) / together; }
constexpr std::size_t kPairBytes = std::size_t{2} * kPanelRows;
constexpr std::size_t kScaleBytes = sizeof(float) * kPanelRows;
constexpr std::size_t PanelBytes(int columns, int together) {
  return Pairs(columns) * kPairBytes + Groups(columns, together) * kScaleBytes;
}

// NEON multiplies and adds without a sum of neighbours, so each of its vectors has the rows of one
// column, then those of the other.
#define STYLED_NEON (HWY_ARCH_ARM_A64 && HWY_TARGET < HWY_EMU128)
constexpr int WeightIndex(int row, int column) {
  const int pair = column / 2 * kPanelRows * 2;
  return STYLED_NEON ? pair + (row / kLanes * 2 + column % 2) * kLanes + row % kLanes
                     : pair + row * 2 + column % 2;
}

// Inputs of a product as whole numbers, up to kMostStates of them.
struct WholeInputs {
  alignas(64) std::int16_t x[kMostStates][kMostColumns];
  float scale[kMostStates][kMostColumns / 32];  // of each group
};

// Up to `together` columns as multiples of the largest of them. A value that is not finite makes
// the scale not finite, and thus the product.
HWY_INLINE float Whole(const float* x, int columns, std::int16_t* whole) {
  V largest = hn::Zero(d), not_finite = hn::Zero(d);
  int i = 0;
  for (; i + kLanes <= columns; i += kLanes) {
    const V value = hn::LoadU(d, x + i);
    largest = hn::Max(largest, hn::Abs(value));
    not_finite = hn::MulAdd(value, hn::Zero(d), not_finite);
  }
  float most = hn::GetLane(hn::MaxOfLanes(d, largest));
  float odd = hn::GetLane(hn::SumOfLanes(d, not_finite));
  for (int rest = i; rest < columns; ++rest) {
    most = HWY_MAX(most, std::abs(x[rest]));
    odd += x[rest] * 0.0F;
  }
  const float factor = most > 0 ? kMostInput / most : 0.0F;
  const hn::Rebind<std::int16_t, D> narrow;
  const V factors = hn::Set(d, factor);
  for (i = 0; i + kLanes <= columns; i += kLanes) {
    const VI rounded = hn::NearestInt(hn::Mul(hn::LoadU(d, x + i), factors));
    hn::StoreU(hn::DemoteTo(narrow, rounded), narrow, whole + i);
  }
  for (; i < columns; ++i) {
    whole[i] = static_cast<std::int16_t>(
        std::lrint(HWY_MIN(HWY_MAX(x[i] * factor, -kMostInput), kMostInput)));
  }
  return most / kMostInput + odd;
}

// sum + w0 x0 + w1 x1, of the weights of as many rows as a vector has lanes, two columns at a time
// in the order of WeightIndex, and of the two inputs in each lane of `factor`.
HWY_INLINE VI AddPairs(VI sum, hn::Vec<DH> weight, hn::Vec<DH> factor) {
#if HWY_TARGET == HWY_AVX2
  return hn::Add(sum, VI{_mm256_madd_epi16(weight.raw, factor.raw)});
#elif HWY_ARCH_X86 && HWY_TARGET <= HWY_AVX3
  return hn::Add(sum, VI{_mm512_madd_epi16(weight.raw, factor.raw)});
#elif HWY_ARCH_X86 && HWY_TARGET < HWY_EMU128
  return hn::Add(sum, VI{_mm_madd_epi16(weight.raw, factor.raw)});
#elif STYLED_NEON
  const int16x4_t two = vget_low_s16(factor.raw);
  const int32x4_t first = vmlal_lane_s16(sum.raw, vget_low_s16(weight.raw), two, 0);
  return VI{vmlal_high_lane_s16(first, weight.raw, two, 1)};
#else
  const VI w = hn::BitCast(di, weight), x = hn::BitCast(di, factor);
  const auto lower = [](VI pair) { return hn::ShiftRight<16>(hn::ShiftLeft<16>(pair)); };
  return hn::Add(sum, hn::Add(hn::Mul(lower(w), lower(x)),
                              hn::Mul(hn::ShiftRight<16>(w), hn::ShiftRight<16>(x))));
#endif
}

// sum[i] += W x[i] for `Vectors` vectors of rows from vector First on, of one group of columns.
// `weights` and `scales` are those of the first panel.
template <int Inputs, int Vectors>
HWY_INLINE void AccumulateWhole(const std::int8_t* HWY_RESTRICT weights, const float* scales,
                                std::size_t panel_bytes, int first, int pairs,
                                const std::array<const std::int16_t*, Inputs>& x,
                                const std::array<float, Inputs>& x_scale,
                                V (&sum)[Inputs][Vectors]) {
  const hn::Rebind<std::int8_t, DH> narrow;
  VI whole[Inputs][Vectors];
  HWY_UNROLL(4)
  for (int i = 0; i < Inputs; ++i) {
    HWY_UNROLL(16)
    for (int v = 0; v < Vectors; ++v) whole[i][v] = hn::Zero(di);
  }
  for (int pair = 0; pair < pairs; ++pair, weights += kPairBytes) {
    hn::Vec<DH> factor[Inputs];
    HWY_UNROLL(4)
    for (int i = 0; i < Inputs; ++i) {
      std::int32_t two;
      hwy::CopyBytes<sizeof two>(x[i] + 2 * pair, &two);
      factor[i] = hn::BitCast(dh, hn::Set(di, two));
    }
    HWY_UNROLL(16)
    for (int k = 0; k < Vectors; ++k) {
      const int v = first + k;
      const hn::Vec<DH> weight = hn::PromoteTo(
          dh, hn::Load(narrow, weights + v / kVectors * panel_bytes + v % kVectors * 2 * kLanes));
      HWY_UNROLL(4)
      for (int i = 0; i < Inputs; ++i) {
        whole[i][k] = AddPairs(whole[i][k], weight, factor[i]);
      }
    }
  }
  HWY_UNROLL(16)
  for (int k = 0; k < Vectors; ++k) {
    const int v = first + k;
    const auto* const panel_scales = reinterpret_cast<const float*>(
        reinterpret_cast<const std::int8_t*>(scales) + v / kVectors * panel_bytes);
    const V scale = hn::Load(d, panel_scales + v % kVectors * kLanes);
    HWY_UNROLL(4)
    for (int i = 0; i < Inputs; ++i) {
      sum[i][k] = hn::MulAdd(hn::ConvertTo(d, whole[i][k]), hn::Mul(scale, hn::Set(d, x_scale[i])),
                             sum[i][k]);
    }
  }
}

// The vectors of rows whose sums fit into the registers, for so many inputs: of whole panels, but
// half a panel for four inputs in sixteen registers.
template <int Inputs>
constexpr int kWholeVectors = kManyRegisters || STYLED_NEON ? (Inputs == 1   ? 8
                                                               : Inputs == 2 ? 8
                                                                             : 4)
                                                            : (Inputs == 1   ? 8
                                                               : Inputs == 2 ? 4
                                                                             : 2);

template <int Inputs, int Vectors>
HWY_INLINE void AffineWholeVectors(const std::int8_t* weights, int first, int columns,
                                   const WholeInputs& whole, std::size_t from,
                                   const Operands* inputs, V least) {
  const std::size_t panel_bytes = PanelBytes(columns, kScaleColumns);
  const auto* scales = reinterpret_cast<const float*>(weights + Pairs(columns) * kPairBytes);
  V sum[Inputs][Vectors];
  HWY_UNROLL(4)
  for (int i = 0; i < Inputs; ++i) {
    HWY_UNROLL(16)
    for (int v = 0; v < Vectors; ++v) sum[i][v] = hn::Zero(d);
  }
  for (int column = 0, group = 0; column < columns; column += kScaleColumns, ++group) {
    std::array<const std::int16_t*, Inputs> x;
    std::array<float, Inputs> x_scale;
    for (int i = 0; i < Inputs; ++i) {
      x[i] = whole.x[from + i] + column;
      x_scale[i] = whole.scale[from + i][group];
    }
    AccumulateWhole<Inputs, Vectors>(
        weights + column / 2 * kPairBytes, scales + group * kPanelRows, panel_bytes, first,
        Pairs(HWY_MIN(kScaleColumns, columns - column)), x, x_scale, sum);
  }
  HWY_UNROLL(4)
  for (int i = 0; i < Inputs; ++i) {
    HWY_UNROLL(16)
    for (int v = 0; v < Vectors; ++v) {
      const int at = (first + v) * kLanes;
      const V y = hn::Add(sum[i][v], hn::Load(d, inputs[i].bias + at));
      hn::Store(hn::Max(y, least), d, inputs[i].y + at);
    }
  }
}

// `vectors` vectors of rows from `first` on, for all inputs, while their weights are in a near
// cache.
template <int Inputs>
HWY_INLINE void AffineWholeRows(const std::int8_t* weights, int first, int vectors, int columns,
                                const WholeInputs& whole, std::size_t from, const Operands* inputs,
                                V least) {
  constexpr int kMost = kWholeVectors<Inputs>;
  const int end = first + vectors;
  for (; first + kMost <= end; first += kMost) {
    AffineWholeVectors<Inputs, kMost>(weights, first, columns, whole, from, inputs, least);
  }
  if constexpr (kMost > kVectors) {
    for (; first < end; first += kVectors) {
      AffineWholeVectors<Inputs, kVectors>(weights, first, columns, whole, from, inputs, least);
    }
  }
}

// The gate sums of 16 units, `Vectors` vectors from First on, as SomeGates.
template <int Units, int Inputs, int First = 0>
HWY_INLINE void WholeGates(const std::int8_t* weights, const float* bias, const WholeInputs& whole,
                           std::size_t from, V (&gates)[Inputs][kGateVectors]) {
  constexpr int kSome = HWY_MIN(kWholeVectors<Inputs>, kGateVectors);
  constexpr std::size_t kPanelBytes = PanelBytes(2 * Units, Units);
  const auto* const scales =
      reinterpret_cast<const float*>(weights + Pairs(2 * Units) * kPairBytes);
  V sum[Inputs][kSome];
  HWY_UNROLL(4)
  for (int i = 0; i < Inputs; ++i) {
    HWY_UNROLL(16)
    for (int v = 0; v < kSome; ++v) sum[i][v] = hn::Load(d, bias + (First + v) * kLanes);
  }
  for (int half = 0; half < 2; ++half) {
    std::array<const std::int16_t*, Inputs> x;
    std::array<float, Inputs> x_scale;
    for (int i = 0; i < Inputs; ++i) {
      x[i] = whole.x[from + i] + half * Units;
      x_scale[i] = whole.scale[from + i][half];
    }
    AccumulateWhole<Inputs, kSome>(weights + half * Pairs(Units) * kPairBytes,
                                   scales + half * kPanelRows, kPanelBytes, First, Pairs(Units), x,
                                   x_scale, sum);
  }
  HWY_UNROLL(4)
  for (int i = 0; i < Inputs; ++i) {
    HWY_UNROLL(16)
    for (int v = 0; v < kSome; ++v) gates[i][First + v] = sum[i][v];
  }
  if constexpr (First + kSome < kGateVectors) {
    WholeGates<Units, Inputs, First + kSome>(weights, bias, whole, from, gates);
  }
}

template <int Units, int Inputs>
HWY_INLINE void LstmWholeSome(const std::int8_t* weights, const float* bias, int first,
                              const WholeInputs& whole, std::size_t from,
                              const LstmOperands* states) {
  V gates[Inputs][kGateVectors];
  WholeGates<Units, Inputs>(weights, bias, whole, from, gates);
  Activate<Inputs>(gates, first, states);
}

// All units read the old h, which is in `whole` before h is overwritten.
template <int Units>
HWY_INLINE void LstmWholeChunk(const std::int8_t* weights, const float* bias,
                               std::span<const LstmOperands> states) {
  WholeInputs whole;
  for (std::size_t i = 0; i < states.size(); ++i) {
    whole.scale[i][0] = Whole(states[i].h, Units, whole.x[i]);
    whole.scale[i][1] = Whole(states[i].z, Units, whole.x[i] + Units);
  }
  for (int first = 0; first < Units; first += 16) {
    std::size_t i = 0;
    for (; i + 4 <= states.size(); i += 4) {
      LstmWholeSome<Units, 4>(weights, bias, first, whole, i, &states[i]);
    }
    if (i + 2 <= states.size()) {
      LstmWholeSome<Units, 2>(weights, bias, first, whole, i, &states[i]);
      i += 2;
    }
    if (i < states.size()) LstmWholeSome<Units, 1>(weights, bias, first, whole, i, &states[i]);
    weights += 2 * PanelBytes(2 * Units, Units);
    bias += 2 * kPanelRows;
  }
}

}  // namespace

void PackInt8(float* weights, int panels, int columns, int together) noexcept {
  auto* to = reinterpret_cast<std::int8_t*>(weights);
  std::vector<float> panel(static_cast<std::size_t>(columns) * kPanelRows);
  for (int p = 0; p < panels; ++p, weights += panel.size()) {
    std::copy_n(weights, panel.size(), panel.begin());  // `to` overtakes nothing but this copy
    const auto at = [&](int row, int column) {
      return panel[static_cast<std::size_t>(column) * kPanelRows + static_cast<std::size_t>(row)];
    };
    auto* const scales = reinterpret_cast<float*>(to + Pairs(columns) * kPairBytes);
    for (int row = 0; row < kPanelRows; ++row) {
      for (int first = 0, group = 0; first < columns; first += together, ++group) {
        const int end = HWY_MIN(first + together, columns);
        float largest = 0;
        for (int c = first; c < end; ++c) largest = HWY_MAX(largest, std::abs(at(row, c)));
        const float scale = HWY_MAX(largest / kMostWeight, kLeastScale);
        scales[group * kPanelRows + row] = scale;
        for (int c = first; c < end + end % 2; ++c) {
          const float weight = c < end ? at(row, c) / scale : 0.0F;
          to[WeightIndex(row, c)] =
              static_cast<std::int8_t>(std::lrint(HWY_MIN(HWY_MAX(weight, -127.0F), 127.0F)));
        }
      }
    }
    to += PanelBytes(columns, together);
  }
}

void AffineInt8(const float* packed, int panels, int columns, std::span<const Operands> inputs,
                bool relu) noexcept {
  constexpr int kPanelsTogether = 4;
  const auto* const weights = reinterpret_cast<const std::int8_t*>(packed);
  const V least = hn::Set(d, relu ? 0.0F : hwy::LowestValue<float>());
  WholeInputs whole;
  while (!inputs.empty()) {
    const std::size_t count = HWY_MIN(inputs.size(), kMostStates);
    for (std::size_t i = 0; i < count; ++i) {
      for (int column = 0, group = 0; column < columns; column += kScaleColumns, ++group) {
        whole.scale[i][group] = Whole(
            inputs[i].x + column, HWY_MIN(kScaleColumns, columns - column), whole.x[i] + column);
      }
      if (columns % 2 != 0) whole.x[i][columns] = 0;
    }
    for (int panel = 0; panel < panels; panel += kPanelsTogether) {
      const int first = panel * kVectors;
      const int vectors = HWY_MIN(kPanelsTogether, panels - panel) * kVectors;
      std::size_t i = 0;
      for (; i + 4 <= count; i += 4) {
        AffineWholeRows<4>(weights, first, vectors, columns, whole, i, &inputs[i], least);
      }
      if (i + 2 <= count) {
        AffineWholeRows<2>(weights, first, vectors, columns, whole, i, &inputs[i], least);
        i += 2;
      }
      if (i < count) {
        AffineWholeRows<1>(weights, first, vectors, columns, whole, i, &inputs[i], least);
      }
    }
    inputs = inputs.subspan(count);
  }
}

void LstmInt8(int units, const float* weights, const float* bias,
              std::span<const LstmOperands> states) noexcept {
  LstmOf(units, states, [=](auto n, std::span<const LstmOperands> some) {
    LstmWholeChunk<n>(reinterpret_cast<const std::int8_t*>(weights), bias, some);
  });
}

}  // namespace HWY_NAMESPACE
}  // namespace styled::net
HWY_AFTER_NAMESPACE();
