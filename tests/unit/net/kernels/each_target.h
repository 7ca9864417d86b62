#pragma once

// As in the kernels' sources: else SVE counts as a target of this build.
#define HWY_DISABLED_TARGETS (HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_RVV)
#include <hwy/targets.h>

namespace styled::net {

// Runs `body` once for each SIMD target of this build that the machine supports, with BestKernels()
// set to that target's. Not thread-safe.
template <typename Body>
void OnEachTarget(Body body) {
  for (const auto target : hwy::SupportedAndGeneratedTargets()) {
    hwy::SetSupportedTargetsForTest(target);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
    body();
    hwy::SetSupportedTargetsForTest(0);
  }
  hwy::GetChosenTarget().Update(hwy::SupportedTargets());
}

}  // namespace styled::net
