#include "model/net/kernels/kernel.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <vector>

// Targets with scalable vectors are disabled: such vectors cannot be stored in arrays.
#define HWY_DISABLED_TARGETS (HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_RVV)
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "model/net/kernels/kernel.cpp"
#include <hwy/cache_control.h>
#include <hwy/foreach_target.h>  // must precede highway.h
#include <hwy/highway.h>

// Forces a Highway vector into a register from here on.
#if HWY_ARCH_X86 && HWY_COMPILER_GCC_ACTUAL
#define STYLED_KEEP_IN_REGISTER(vector) asm("" : "+v"((vector).raw))
#else
#define STYLED_KEEP_IN_REGISTER(vector) static_cast<void>(0)
#endif

HWY_BEFORE_NAMESPACE();
namespace styled::net {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;
using D = hn::CappedTag<float, 16>;
using V = hn::Vec<D>;
constexpr D d;
constexpr int kLanes = hn::MaxLanes(d);
constexpr int kVectors = kPanelRows / kLanes;  // vectors per panel
constexpr bool kManyRegisters = kLanes == 16;  // AVX-512 has 32

// The number of independent sets of sums over the columns, for `vectors` vectors of rows: a
// multiplication then need not wait for the one before. It does not depend on the number of inputs,
// so that an input gives the same bits alone or in a batch.
constexpr int Sets(int vectors) { return kManyRegisters ? HWY_MAX(1, 8 / vectors) : 1; }

// Columns of float32 that a column of a packed matrix holds: of bfloat16 an even one, in the lower
// 16 bits, and the next.
constexpr int Together(Precision precision) { return precision == Precision::kBfloat16 ? 2 : 1; }

// The weights of the even columns of pairs, as floats. A weight of an odd column is all 32 bits of
// its pair: the even one in the lower half is the end of its mantissa, and PackPairs has chosen the
// upper half accordingly.
HWY_INLINE V Even(V pairs) {
  const hn::RebindToUnsigned<D> bits;
  return hn::BitCast(d, hn::ShiftLeft<16>(hn::BitCast(bits, pairs)));
}

// Adds one column of a product: sum[i] += W[:, column] x[i], for `Vectors` vectors from First on.
template <Precision kPrecision, int Inputs, int First, int Vectors>
HWY_INLINE void AccumulateColumn(const float* HWY_RESTRICT weights, std::size_t panel_stride,
                                 const std::array<const float*, Inputs>& x, int column,
                                 V (&sum)[Inputs][Vectors]) {
  constexpr bool kPairs = kPrecision == Precision::kBfloat16;
  V factor[Inputs], odd_factor[Inputs];
  HWY_UNROLL(4)
  for (int i = 0; i < Inputs; ++i) {
    factor[i] = hn::Set(d, x[i][kPairs ? 2 * column : column]);
    if constexpr (kPairs) odd_factor[i] = hn::Set(d, x[i][2 * column + 1]);
  }
  HWY_UNROLL(32)
  for (int k = 0; k < Vectors; ++k) {
    const int v = First + k;
    const float* const from = weights + v / kVectors * panel_stride + v % kVectors * kLanes;
    V weight = hn::Load(d, from);
    if constexpr (Inputs > 1) {
      // Several inputs are limited by the bandwidth of the first-level cache: load each weight once
      // (GCC would load it for each multiplication), and prefetch.
      STYLED_KEEP_IN_REGISTER(weight);
      if (v * kLanes % 16 == 0) hwy::Prefetch(from + 4 * kPanelRows);
    }
    if constexpr (kPairs) {
      const V even = Even(weight);
      HWY_UNROLL(4)
      for (int i = 0; i < Inputs; ++i) {
        sum[i][k] = hn::MulAdd(weight, odd_factor[i], hn::MulAdd(even, factor[i], sum[i][k]));
      }
    } else {
      HWY_UNROLL(4)
      for (int i = 0; i < Inputs; ++i) sum[i][k] = hn::MulAdd(weight, factor[i], sum[i][k]);
    }
  }
}

// sum[i] += W x[i] for `Vectors` vectors of rows, from vector First on.
template <Precision kPrecision, int Inputs, int First, int Vectors, int kSets>
HWY_INLINE void Accumulate(const float* HWY_RESTRICT weights, std::size_t panel_stride, int columns,
                           const std::array<const float*, Inputs>& x, V (&sum)[Inputs][Vectors]) {
  V set[kSets][Inputs][Vectors];
  HWY_UNROLL(8)
  for (int s = 0; s < kSets; ++s) {
    HWY_UNROLL(4)
    for (int i = 0; i < Inputs; ++i) {
      HWY_UNROLL(32)
      for (int v = 0; v < Vectors; ++v) set[s][i][v] = s == 0 ? sum[i][v] : hn::Zero(d);
    }
  }
  int column = 0;
  for (; column + kSets <= columns; column += kSets) {
    HWY_UNROLL(8)
    for (int s = 0; s < kSets; ++s) {
      AccumulateColumn<kPrecision, Inputs, First, Vectors>(weights, panel_stride, x, column + s,
                                                           set[s]);
      weights += kPanelRows;
    }
  }
  for (; column < columns; ++column) {
    AccumulateColumn<kPrecision, Inputs, First, Vectors>(weights, panel_stride, x, column, set[0]);
    weights += kPanelRows;
  }
  HWY_UNROLL(4)
  for (int i = 0; i < Inputs; ++i) {
    HWY_UNROLL(32)
    for (int v = 0; v < Vectors; ++v) {
      sum[i][v] = set[0][i][v];
      HWY_UNROLL(8)
      for (int s = 1; s < kSets; ++s) sum[i][v] = hn::Add(sum[i][v], set[s][i][v]);
    }
  }
}

// How many of `vectors` vectors of rows fit into the registers at a time.
template <int Inputs>
constexpr int VectorsAtATime(int vectors) {
  if (Inputs == 1 || (Inputs == 2 && kManyRegisters)) return vectors;
  const int room = (kManyRegisters ? 20 : 8) / (Inputs * Sets(vectors));
  int some = vectors;
  while (some > HWY_MAX(1, room) || vectors % some != 0) --some;
  return some;
}

// y = max(W x + bias, least) for the vectors First .. All - 1, as many at a time as fit.
template <Precision kPrecision, int Inputs, int All, int First>
HWY_INLINE void AffineVectors(const float* weights, std::size_t panel_stride, int columns, int row,
                              const std::array<const float*, Inputs>& x, const Operands* inputs,
                              V least) {
  constexpr int kSome = VectorsAtATime<Inputs>(All);
  V sum[Inputs][kSome];
  HWY_UNROLL(4)
  for (int i = 0; i < Inputs; ++i) {
    HWY_UNROLL(32)
    for (int v = 0; v < kSome; ++v) sum[i][v] = hn::Zero(d);
  }
  Accumulate<kPrecision, Inputs, First, kSome, Sets(All)>(weights, panel_stride, columns, x, sum);
  HWY_UNROLL(4)
  for (int i = 0; i < Inputs; ++i) {
    HWY_UNROLL(32)
    for (int v = 0; v < kSome; ++v) {
      const int at = row + (First + v) * kLanes;
      // The bias is added last: it may be large compared to the terms of the sum, which would lose
      // digits.
      const V y = hn::Add(sum[i][v], hn::Load(d, inputs[i].bias + at));
      hn::Store(hn::Max(y, least), d, inputs[i].y + at);
    }
  }
  if constexpr (First + kSome < All) {
    AffineVectors<kPrecision, Inputs, All, First + kSome>(weights, panel_stride, columns, row, x,
                                                          inputs, least);
  }
}

template <Precision kPrecision, int Panels, int Inputs>
HWY_INLINE void AffinePanels(const float* weights, int panel, int columns, const Operands* inputs,
                             bool relu) {
  std::array<const float*, Inputs> x;
  HWY_UNROLL(4)
  for (int i = 0; i < Inputs; ++i) x[i] = inputs[i].x;
  const std::size_t panel_stride = static_cast<std::size_t>(columns) * kPanelRows;
  const V least = hn::Set(d, relu ? 0.0F : hwy::LowestValue<float>());
  AffineVectors<kPrecision, Inputs, Panels * kVectors, 0>(
      weights + panel * panel_stride, panel_stride, columns, panel * kPanelRows, x, inputs, least);
}

// Some panels for all inputs, while their weights are in a near cache.
template <Precision kPrecision, int Panels>
HWY_INLINE void AffineSome(const float* weights, int panel, int columns,
                           std::span<const Operands> inputs, bool relu) {
  for (; inputs.size() >= 4; inputs = inputs.subspan(4)) {
    AffinePanels<kPrecision, Panels, 4>(weights, panel, columns, inputs.data(), relu);
  }
  if (inputs.size() >= 2) {
    AffinePanels<kPrecision, Panels, 2>(weights, panel, columns, inputs.data(), relu);
    inputs = inputs.subspan(2);
  }
  if (!inputs.empty()) {
    AffinePanels<kPrecision, Panels, 1>(weights, panel, columns, inputs.data(), relu);
  }
}

// Processes as many panels at a time as the registers hold, then the rest.
template <Precision kPrecision, int Most>
HWY_INLINE void AffinePanelwise(const float* weights, int panel, int panels, int columns,
                                std::span<const Operands> inputs, bool relu) {
  for (; panel + Most <= panels; panel += Most) {
    AffineSome<kPrecision, Most>(weights, panel, columns, inputs, relu);
  }
  if constexpr (Most > 1) {
    if (panel < panels) {
      AffinePanelwise<kPrecision, Most - 1>(weights, panel, panels, columns, inputs, relu);
    }
  }
}

template <Precision kPrecision>
HWY_INLINE void AffineAll(const float* weights, int panels, int columns,
                          std::span<const Operands> inputs, bool relu) {
  if (kManyRegisters) {
    AffinePanelwise<kPrecision, 5>(weights, 0, panels, columns, inputs, relu);
  } else if (inputs.size() == 1) {
    AffinePanelwise<kPrecision, 2>(weights, 0, panels, columns, inputs, relu);
  } else {
    AffinePanelwise<kPrecision, 1>(weights, 0, panels, columns, inputs, relu);
  }
}

void Affine(const float* weights, int panels, int columns, std::span<const Operands> inputs,
            bool relu) noexcept {
  AffineAll<Precision::kFloat32>(weights, panels, columns, inputs, relu);
}

void Standardize(const float* x, const float* mean, const float* inverse_deviation, int count,
                 float limit, float* u) noexcept {
  const auto some = [=](auto tag, int i) {
    const auto scaled = hn::Mul(hn::Sub(hn::LoadU(tag, x + i), hn::Load(tag, mean + i)),
                                hn::Load(tag, inverse_deviation + i));
    const auto number = hn::IfThenElseZero(hn::Eq(scaled, scaled), scaled);
    hn::Store(hn::Clamp(number, hn::Set(tag, -limit), hn::Set(tag, limit)), tag, u + i);
  };
  int i = 0;
  for (; i + kLanes <= count; i += kLanes) some(d, i);
  for (; i < count; ++i) some(hn::CappedTag<float, 1>(), i);
}

// tanh(x) = x P(x²) / Q(x²) as numerator and denominator, so that gates can share one division.
// Minimax on |x| <= 8.7, relative error 1.5e-8; beyond, tanh is 1 up to 6e-8.
struct Ratio {
  V over, under;
};
HWY_INLINE Ratio Tanh(V x) {
  const auto k = [](float value) { return hn::Set(d, value); };
  x = hn::Clamp(x, k(-8.7F), k(8.7F));
  const V y = hn::Mul(x, x);
  V p = hn::MulAdd(y, k(1.389812695e-8F), k(2.099421483e-5F));
  V q = hn::MulAdd(y, k(7.996737357e-7F), k(3.32368698e-4F));
  p = hn::MulAdd(y, p, k(3.518768357e-3F));
  q = hn::MulAdd(y, q, k(2.596498771e-2F));
  p = hn::MulAdd(y, p, k(0.1340048756F));
  q = hn::MulAdd(y, q, k(0.4673380782F));
  p = hn::MulAdd(y, p, k(0.9999999853F));
  q = hn::MulAdd(y, q, k(1.0F));
  return {hn::Mul(x, p), q};
}

// One vector of units from its gates; the sigmoid gates are halved: σ(x) = (1 + tanh(x / 2)) / 2.
HWY_INLINE void Unit(V in, V forget, V cell, V open, float* h, float* c) {
  const V half = hn::Set(d, 0.5F);
  const Ratio i = Tanh(in), f = Tanh(forget), g = Tanh(cell), o = Tanh(open);
  // σ(f) c + σ(i) tanh(g) over one common denominator.
  const V under = hn::Mul(i.under, g.under);
  const V kept = hn::Mul(hn::Mul(hn::Add(f.under, f.over), hn::Load(d, c)), under);
  const V added = hn::Mul(hn::Mul(hn::Add(i.under, i.over), g.over), f.under);
  const V cell_state = hn::Div(hn::Mul(half, hn::Add(kept, added)), hn::Mul(under, f.under));
  hn::Store(cell_state, d, c);
  const Ratio t = Tanh(cell_state);
  const V opened = hn::Mul(half, hn::Add(o.under, o.over));
  hn::Store(hn::Div(hn::Mul(opened, t.over), hn::Mul(o.under, t.under)), d, h);
}

constexpr int kGateVectors = 4 * 16 / kLanes;  // vectors of the four gates of 16 units

// Gate sums of 16 units before their activations: `Vectors` vectors from First on.
template <Precision kPrecision, int Units, int Inputs, int First, int Vectors>
HWY_INLINE void SomeGates(const float* weights, const float* bias,
                          const std::array<const float*, Inputs>& h,
                          const std::array<const float*, Inputs>& z, V (&sum)[Inputs][Vectors]) {
  constexpr int kColumns = Units / Together(kPrecision);
  constexpr std::size_t kPanelStride = std::size_t{2} * kColumns * kPanelRows;
  HWY_UNROLL(4)
  for (int i = 0; i < Inputs; ++i) {
    HWY_UNROLL(16)
    for (int v = 0; v < Vectors; ++v) sum[i][v] = hn::Load(d, bias + (First + v) * kLanes);
  }
  // Wh h comes first, because it does not depend on the layer below.
  constexpr int kSets = Sets(kGateVectors);
  Accumulate<kPrecision, Inputs, First, Vectors, kSets>(weights, kPanelStride, kColumns, h, sum);
  Accumulate<kPrecision, Inputs, First, Vectors, kSets>(weights + kColumns * kPanelRows,
                                                        kPanelStride, kColumns, z, sum);
}

template <Precision kPrecision, int Units, int Inputs, int First = 0>
HWY_INLINE void Gates(const float* weights, const float* bias,
                      const std::array<const float*, Inputs>& h,
                      const std::array<const float*, Inputs>& z, V (&gates)[Inputs][kGateVectors]) {
  constexpr int kSome = VectorsAtATime<Inputs>(kGateVectors);
  V sum[Inputs][kSome];
  SomeGates<kPrecision, Units, Inputs, First, kSome>(weights, bias, h, z, sum);
  HWY_UNROLL(4)
  for (int i = 0; i < Inputs; ++i) {
    HWY_UNROLL(16)
    for (int v = 0; v < kSome; ++v) gates[i][First + v] = sum[i][v];
  }
  if constexpr (First + kSome < kGateVectors) {
    Gates<kPrecision, Units, Inputs, First + kSome>(weights, bias, h, z, gates);
  }
}

// 16 units of some states, from their gate sums.
template <int Inputs>
HWY_INLINE void Activate(const V (&gates)[Inputs][kGateVectors], int first,
                         const LstmOperands* states) {
  constexpr int kGate = 16 / kLanes;  // vectors of a gate's 16 units
  HWY_UNROLL(4)
  for (int i = 0; i < Inputs; ++i) {
    HWY_UNROLL(4)
    for (int v = 0; v < kGate; ++v) {
      const V* const gate = gates[i] + v;
      const int unit = first + v * kLanes;
      Unit(gate[0], gate[kGate], gate[2 * kGate], gate[3 * kGate], states[i].h + unit,
           states[i].c + unit);
    }
  }
}

// 16 units of some states, from the old h of all units.
template <Precision kPrecision, int Units, int Inputs>
HWY_INLINE void LstmSome(const float* weights, const float* bias, int first,
                         const std::array<const float*, 2>* from, const LstmOperands* states) {
  std::array<const float*, Inputs> h, z;
  HWY_UNROLL(4)
  for (int i = 0; i < Inputs; ++i) {
    h[i] = from[i][0];
    z[i] = from[i][1];
  }
  V gates[Inputs][kGateVectors];
  Gates<kPrecision, Units, Inputs>(weights, bias, h, z, gates);
  Activate<Inputs>(gates, first, states);
}

constexpr std::size_t kMostStates = 16;  // at a time

// Units outermost: the weights of 16 units stay in the first-level cache while the states pass.
// `from`: the old h and z of each state.
template <Precision kPrecision, int Units>
HWY_INLINE void LstmUnits(const float* weights, const float* bias,
                          const std::array<const float*, 2>* from,
                          std::span<const LstmOperands> states) {
  for (int first = 0; first < Units; first += 16) {
    std::size_t i = 0;
    for (; i + 4 <= states.size(); i += 4) {
      LstmSome<kPrecision, Units, 4>(weights, bias, first, from + i, &states[i]);
    }
    if (i + 2 <= states.size()) {
      LstmSome<kPrecision, Units, 2>(weights, bias, first, from + i, &states[i]);
      i += 2;
    }
    if (i < states.size()) {
      LstmSome<kPrecision, Units, 1>(weights, bias, first, from + i, &states[i]);
    }
    weights += std::size_t{4} * Units / Together(kPrecision) * kPanelRows;
    bias += 2 * kPanelRows;
  }
}

template <Precision kPrecision, int Units>
HWY_INLINE void LstmChunk(const float* weights, const float* bias,
                          std::span<const LstmOperands> states) {
  // All units read the old h, so it is copied before h is overwritten.
  alignas(64) float old[kMostStates][Units];
  std::array<std::array<const float*, 2>, kMostStates> from;
  for (std::size_t i = 0; i < states.size(); ++i) {
    for (int u = 0; u < Units; u += kLanes) {
      hn::Store(hn::Load(d, states[i].h + u), d, old[i] + u);
    }
    from[i] = {old[i], states[i].z};
  }
  LstmUnits<kPrecision, Units>(weights, bias, from.data(), states);
}

// Calls run(units, states) for at most kMostStates at a time.
template <typename Run>
HWY_INLINE void LstmOf(int units, std::span<const LstmOperands> states, const Run& run) {
  while (!states.empty()) {
    const std::size_t count = HWY_MIN(states.size(), kMostStates);
    units == 64 ? run(std::integral_constant<int, 64>(), states.first(count))
                : run(std::integral_constant<int, 32>(), states.first(count));
    states = states.subspan(count);
  }
}

template <Precision kPrecision>
void Lstm(int units, const float* weights, const float* bias,
          std::span<const LstmOperands> states) noexcept {
  LstmOf(units, states, [=](auto n, std::span<const LstmOperands> some) {
    LstmChunk<kPrecision, n>(weights, bias, some);
  });
}

// The upper 16 bits of the least normal number (smaller ones would cost time) and of the largest
// bfloat16.
constexpr std::uint32_t kLeast = 0x0080, kLargest = 0x7F7F;

// The nearest finite bfloat16, ties to even; its 16 bits. Subnormal numbers become 0.
std::uint32_t Bfloat16(float x) {
  const auto bits = std::bit_cast<std::uint32_t>(x);
  const std::uint32_t sign = bits >> 31 << 15, magnitude = bits & 0x7FFFFFFFU;
  if (magnitude < kLeast << 16) return sign;
  return sign | HWY_MIN((magnitude + 0x7FFFU + (magnitude >> 16 & 1U)) >> 16, kLargest);
}

// The upper 16 bits with which a finite float with these lower bits is nearest to x: as near as a
// bfloat16 is. Near 0 it is the least normal number.
std::uint32_t UpperBits(float x, std::uint32_t lower) {
  const auto bits = std::bit_cast<std::uint32_t>(x);
  const std::uint32_t sign = bits >> 31 << 15, magnitude = bits & 0x7FFFFFFFU;
  if (magnitude == 0 && lower == 0) return 0;
  if (magnitude < (kLeast + 1) << 16) return sign | kLeast;
  return sign | HWY_MIN((magnitude - lower + 0x8000U) >> 16, kLargest);
}

// The columns of a panel two by two, in place; an odd last one is paired with 0.
void PackPairs(float* weights, int panels, int columns, int /*together*/) noexcept {
  float* to = weights;
  for (int panel = 0; panel < panels; ++panel) {
    for (int column = 0; column < columns; column += 2) {
      const bool two = column + 1 < columns;
      for (int row = 0; row < kPanelRows; ++row) {
        const std::uint32_t even = Bfloat16(weights[row]);
        const std::uint32_t odd = UpperBits(two ? weights[kPanelRows + row] : 0.0F, even);
        *to++ = std::bit_cast<float>(odd << 16 | even);
      }
      weights += two ? 2 * kPanelRows : kPanelRows;
    }
  }
}

void AffinePairs(const float* weights, int panels, int columns, std::span<const Operands> inputs,
                 bool relu) noexcept {
  if (columns % 2 == 0) {
    return AffineAll<Precision::kBfloat16>(weights, panels, columns / 2, inputs, relu);
  }
  // The last pair needs a second input, which is 0.
  alignas(64) float x[kMostStates][kMostColumns];
  std::array<Operands, kMostStates> some;
  while (!inputs.empty()) {
    const std::size_t count = HWY_MIN(inputs.size(), kMostStates);
    for (std::size_t i = 0; i < count; ++i) {
      std::copy_n(inputs[i].x, columns, x[i]);
      x[i][columns] = 0;
      some[i] = {inputs[i].bias, x[i], inputs[i].y};
    }
    AffineAll<Precision::kBfloat16>(weights, panels, (columns + 1) / 2,
                                    std::span(some).first(count), relu);
    inputs = inputs.subspan(count);
  }
}

// Weights of int8. A panel holds, two columns at a time, the weights of its rows one after another:
// 64 bytes; and after its last columns, for each group of columns that share a number, the numbers
// of its rows. A sum of products of whole numbers below 2^31: 64 columns of 127 * 32767.
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
          to[(c / 2 * kPanelRows + row) * 2 + c % 2] =
              static_cast<std::int8_t>(std::lrint(HWY_MIN(HWY_MAX(weight, -127.0F), 127.0F)));
        }
      }
    }
    to += PanelBytes(columns, together);
  }
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

// Of each of 32 bits two whole numbers of 16 bits: a0 b0 + a1 b1.
HWY_INLINE VI SumOfPairs(hn::Vec<DH> a, hn::Vec<DH> b) {
#if HWY_TARGET == HWY_AVX2
  return VI{_mm256_madd_epi16(a.raw, b.raw)};
#elif HWY_ARCH_X86 && HWY_TARGET <= HWY_AVX3
  return VI{_mm512_madd_epi16(a.raw, b.raw)};
#else
  const VI x = hn::BitCast(di, a), y = hn::BitCast(di, b);
  const auto lower = [](VI pair) { return hn::ShiftRight<16>(hn::ShiftLeft<16>(pair)); };
  return hn::Add(hn::Mul(lower(x), lower(y)),
                 hn::Mul(hn::ShiftRight<16>(x), hn::ShiftRight<16>(y)));
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
        whole[i][k] = hn::Add(whole[i][k], SumOfPairs(weight, factor[i]));
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
constexpr int kWholeVectors = kManyRegisters ? (Inputs == 1   ? 8
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

void LstmInt8(int units, const float* weights, const float* bias,
              std::span<const LstmOperands> states) noexcept {
  LstmOf(units, states, [=](auto n, std::span<const LstmOperands> some) {
    LstmWholeChunk<n>(reinterpret_cast<const std::int8_t*>(weights), bias, some);
  });
}

// q / |q|. An estimate of 1 / |q| (8 bits on some targets) with two Newton steps is faster than a
// square root and a division.
template <class Tag>
HWY_INLINE void NormalizeSome(Tag tag, const float* quaternions, float* unit) {
  constexpr float kLeastSquare = 1e-12F;
  alignas(16) constexpr float kIdentity[4] = {0, 0, 0, 1};
  const auto q = hn::LoadU(tag, quaternions);
  const auto squares = hn::Mul(q, q);
  // Sum the squares of each group of four lanes, into all four of them.
  const auto pairs = hn::Add(squares, hn::Shuffle2301(squares));
  const auto square = hn::Add(pairs, hn::Shuffle1032(pairs));
  const auto half_square = hn::Mul(hn::Set(tag, 0.5F), square);
  auto inverse = hn::ApproximateReciprocalSqrt(square);
  HWY_UNROLL(2)
  for (int step = 0; step < 2; ++step) {
    const auto correction =
        hn::NegMulAdd(hn::Mul(half_square, inverse), inverse, hn::Set(tag, 1.5F));
    inverse = hn::Mul(inverse, correction);
  }
  hn::StoreU(hn::IfThenElse(hn::Gt(square, hn::Set(tag, kLeastSquare)), hn::Mul(q, inverse),
                            hn::LoadDup128(tag, kIdentity)),
             tag, unit);
}

void Normalize(const float* quaternions, int count, float* unit) noexcept {
  int i = 0;
  for (; i + kLanes <= 4 * count; i += kLanes) NormalizeSome(d, quaternions + i, unit + i);
  for (; i < 4 * count; i += 4) {
    NormalizeSome(hn::CappedTag<float, 4>(), quaternions + i, unit + i);
  }
}

}  // namespace

const Kernels& TargetKernels(Precision precision) {
  static const Kernels of_floats{hwy::TargetName(HWY_TARGET), Affine,    Standardize,
                                 Lstm<Precision::kFloat32>,   Normalize, nullptr};
  static const Kernels of_pairs{hwy::TargetName(HWY_TARGET), AffinePairs, Standardize,
                                Lstm<Precision::kBfloat16>,  Normalize,   PackPairs};
  static const Kernels of_bytes{
      hwy::TargetName(HWY_TARGET), AffineInt8, Standardize, LstmInt8, Normalize, PackInt8};
  return precision == Precision::kInt8       ? of_bytes
         : precision == Precision::kBfloat16 ? of_pairs
                                             : of_floats;
}

}  // namespace HWY_NAMESPACE
}  // namespace styled::net
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace styled::net {
HWY_EXPORT(TargetKernels);

const Kernels& BestKernels(Precision precision) {
  return HWY_DYNAMIC_DISPATCH(TargetKernels)(precision);
}
}  // namespace styled::net
#endif
