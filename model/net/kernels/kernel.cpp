#include "model/net/kernels/kernel.h"

#include <array>

// Targets with scalable vectors are disabled: such vectors cannot be stored in arrays.
#define HWY_DISABLED_TARGETS (HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_RVV)
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "model/net/kernels/kernel.cpp"
#include <hwy/cache_control.h>
#include <hwy/foreach_target.h>  // must precede highway.h
#include <hwy/highway.h>

#include "model/net/kernels/int8-inl.h"
#include "model/net/kernels/lanes-inl.h"

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

// The number of independent sets of sums over the columns, for `vectors` vectors of rows: a
// multiplication then need not wait for the one before. It does not depend on the number of inputs,
// so that an input gives the same bits alone or in a batch.
constexpr int Sets(int vectors) { return kManyRegisters ? HWY_MAX(1, 8 / vectors) : 1; }

// Adds one column of a product: sum[i] += W[:, column] x[i], for `Vectors` vectors from First on.
template <int Inputs, int First, int Vectors>
HWY_INLINE void AccumulateColumn(const float* HWY_RESTRICT weights, std::size_t panel_stride,
                                 const std::array<const float*, Inputs>& x, int column,
                                 V (&sum)[Inputs][Vectors]) {
  V factor[Inputs];
  HWY_UNROLL(4)
  for (int i = 0; i < Inputs; ++i) factor[i] = hn::Set(d, x[i][column]);
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
    HWY_UNROLL(4)
    for (int i = 0; i < Inputs; ++i) sum[i][k] = hn::MulAdd(weight, factor[i], sum[i][k]);
  }
}

// sum[i] += W x[i] for `Vectors` vectors of rows, from vector First on.
template <int Inputs, int First, int Vectors, int kSets>
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
      AccumulateColumn<Inputs, First, Vectors>(weights, panel_stride, x, column + s, set[s]);
      weights += kPanelRows;
    }
  }
  for (; column < columns; ++column) {
    AccumulateColumn<Inputs, First, Vectors>(weights, panel_stride, x, column, set[0]);
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
template <int Inputs, int All, int First>
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
  Accumulate<Inputs, First, kSome, Sets(All)>(weights, panel_stride, columns, x, sum);
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
    AffineVectors<Inputs, All, First + kSome>(weights, panel_stride, columns, row, x, inputs,
                                              least);
  }
}

template <int Panels, int Inputs>
HWY_INLINE void AffinePanels(const float* weights, int panel, int columns, const Operands* inputs,
                             bool relu) {
  std::array<const float*, Inputs> x;
  HWY_UNROLL(4)
  for (int i = 0; i < Inputs; ++i) x[i] = inputs[i].x;
  const std::size_t panel_stride = static_cast<std::size_t>(columns) * kPanelRows;
  const V least = hn::Set(d, relu ? 0.0F : hwy::LowestValue<float>());
  AffineVectors<Inputs, Panels * kVectors, 0>(weights + panel * panel_stride, panel_stride, columns,
                                              panel * kPanelRows, x, inputs, least);
}

// Some panels for all inputs, while their weights are in a near cache.
template <int Panels>
HWY_INLINE void AffineSome(const float* weights, int panel, int columns,
                           std::span<const Operands> inputs, bool relu) {
  for (; inputs.size() >= 4; inputs = inputs.subspan(4)) {
    AffinePanels<Panels, 4>(weights, panel, columns, inputs.data(), relu);
  }
  if (inputs.size() >= 2) {
    AffinePanels<Panels, 2>(weights, panel, columns, inputs.data(), relu);
    inputs = inputs.subspan(2);
  }
  if (!inputs.empty()) {
    AffinePanels<Panels, 1>(weights, panel, columns, inputs.data(), relu);
  }
}

// Processes as many panels at a time as the registers hold, then the rest.
template <int Most>
HWY_INLINE void AffinePanelwise(const float* weights, int panel, int panels, int columns,
                                std::span<const Operands> inputs, bool relu) {
  for (; panel + Most <= panels; panel += Most) {
    AffineSome<Most>(weights, panel, columns, inputs, relu);
  }
  if constexpr (Most > 1) {
    if (panel < panels) {
      AffinePanelwise<Most - 1>(weights, panel, panels, columns, inputs, relu);
    }
  }
}

void Affine(const float* weights, int panels, int columns, std::span<const Operands> inputs,
            bool relu) noexcept {
  if (kManyRegisters) {
    AffinePanelwise<5>(weights, 0, panels, columns, inputs, relu);
  } else if (inputs.size() == 1) {
    AffinePanelwise<2>(weights, 0, panels, columns, inputs, relu);
  } else {
    AffinePanelwise<1>(weights, 0, panels, columns, inputs, relu);
  }
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

// Gate sums of 16 units before their activations: `Vectors` vectors from First on.
template <int Units, int Inputs, int First, int Vectors>
HWY_INLINE void SomeGates(const float* weights, const float* bias,
                          const std::array<const float*, Inputs>& h,
                          const std::array<const float*, Inputs>& z, V (&sum)[Inputs][Vectors]) {
  constexpr int kColumns = Units;
  constexpr std::size_t kPanelStride = std::size_t{2} * kColumns * kPanelRows;
  HWY_UNROLL(4)
  for (int i = 0; i < Inputs; ++i) {
    HWY_UNROLL(16)
    for (int v = 0; v < Vectors; ++v) sum[i][v] = hn::Load(d, bias + (First + v) * kLanes);
  }
  // Wh h comes first, because it does not depend on the layer below.
  constexpr int kSets = Sets(kGateVectors);
  Accumulate<Inputs, First, Vectors, kSets>(weights, kPanelStride, kColumns, h, sum);
  Accumulate<Inputs, First, Vectors, kSets>(weights + kColumns * kPanelRows, kPanelStride, kColumns,
                                            z, sum);
}

template <int Units, int Inputs, int First = 0>
HWY_INLINE void Gates(const float* weights, const float* bias,
                      const std::array<const float*, Inputs>& h,
                      const std::array<const float*, Inputs>& z, V (&gates)[Inputs][kGateVectors]) {
  constexpr int kSome = VectorsAtATime<Inputs>(kGateVectors);
  V sum[Inputs][kSome];
  SomeGates<Units, Inputs, First, kSome>(weights, bias, h, z, sum);
  HWY_UNROLL(4)
  for (int i = 0; i < Inputs; ++i) {
    HWY_UNROLL(16)
    for (int v = 0; v < kSome; ++v) gates[i][First + v] = sum[i][v];
  }
  if constexpr (First + kSome < kGateVectors) {
    Gates<Units, Inputs, First + kSome>(weights, bias, h, z, gates);
  }
}

// 16 units of some states, from the old h of all units.
template <int Units, int Inputs>
HWY_INLINE void LstmSome(const float* weights, const float* bias, int first,
                         const std::array<const float*, 2>* from, const LstmOperands* states) {
  std::array<const float*, Inputs> h, z;
  HWY_UNROLL(4)
  for (int i = 0; i < Inputs; ++i) {
    h[i] = from[i][0];
    z[i] = from[i][1];
  }
  V gates[Inputs][kGateVectors];
  Gates<Units, Inputs>(weights, bias, h, z, gates);
  Activate<Inputs>(gates, first, states);
}

// Units outermost: the weights of 16 units stay in the first-level cache while the states pass.
// `from`: the old h and z of each state.
template <int Units>
HWY_INLINE void LstmUnits(const float* weights, const float* bias,
                          const std::array<const float*, 2>* from,
                          std::span<const LstmOperands> states) {
  for (int first = 0; first < Units; first += 16) {
    std::size_t i = 0;
    for (; i + 4 <= states.size(); i += 4) {
      LstmSome<Units, 4>(weights, bias, first, from + i, &states[i]);
    }
    if (i + 2 <= states.size()) {
      LstmSome<Units, 2>(weights, bias, first, from + i, &states[i]);
      i += 2;
    }
    if (i < states.size()) {
      LstmSome<Units, 1>(weights, bias, first, from + i, &states[i]);
    }
    weights += std::size_t{4} * Units * kPanelRows;
    bias += 2 * kPanelRows;
  }
}

template <int Units>
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
  LstmUnits<Units>(weights, bias, from.data(), states);
}

void Lstm(int units, const float* weights, const float* bias,
          std::span<const LstmOperands> states) noexcept {
  LstmOf(units, states,
         [=](auto n, std::span<const LstmOperands> some) { LstmChunk<n>(weights, bias, some); });
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
  static const Kernels of_floats{
      hwy::TargetName(HWY_TARGET), Affine, Standardize, Lstm, Normalize, nullptr};
  static const Kernels of_bytes{
      hwy::TargetName(HWY_TARGET), AffineInt8, Standardize, LstmInt8, Normalize, PackInt8};
  return precision == Precision::kInt8 ? of_bytes : of_floats;
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
