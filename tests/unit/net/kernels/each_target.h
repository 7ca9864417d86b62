#pragma once

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
