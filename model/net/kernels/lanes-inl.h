// The vectors of a SIMD target, and the activations of an LSTM layer: what the kernels of each
// precision share. Included once per target, as Highway's headers are. Pure functions; no
// allocation.
#if defined(STYLED_LANES_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef STYLED_LANES_INL_H
#undef STYLED_LANES_INL_H
#else
#define STYLED_LANES_INL_H
#endif

#include <hwy/highway.h>

#include <cstddef>
#include <span>
#include <type_traits>

#include "model/net/kernels/kernel.h"

// NOLINTBEGIN(misc-definitions-in-headers): all is of an anonymous namespace, once per target.
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

constexpr std::size_t kMostStates = 16;  // at a time

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

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace styled::net
HWY_AFTER_NAMESPACE();
// NOLINTEND(misc-definitions-in-headers)

#endif  // per target
