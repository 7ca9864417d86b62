// The kernels of weights in int8, compiled in int8.cpp for the targets of kernel.cpp; functions as
// in kernel.h.
#if defined(STYLED_INT8_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef STYLED_INT8_INL_H
#undef STYLED_INT8_INL_H
#else
#define STYLED_INT8_INL_H
#endif

#include <hwy/highway.h>

#include <span>

#include "model/net/kernels/kernel.h"

HWY_BEFORE_NAMESPACE();
namespace styled::net {
namespace HWY_NAMESPACE {

void PackInt8(float* weights, int panels, int columns, int together) noexcept;
void AffineInt8(const float* weights, int panels, int columns, std::span<const Operands> inputs,
                bool relu) noexcept;
void LstmInt8(int units, const float* weights, const float* bias,
              std::span<const LstmOperands> states) noexcept;

}  // namespace HWY_NAMESPACE
}  // namespace styled::net
HWY_AFTER_NAMESPACE();

#endif  // per target
