#include "model/train/erd/views.h"

#include "model/net/erd/features.h"

namespace styled::train::style_erd {
namespace {

using torch::Tensor;

// Both legs are consecutive joints of the humanoid, the last ones.
constexpr int64_t kLegBegin = 3 * body::kLeftUpperLeg;
constexpr int64_t kLegFeatures = erd::kPositionFeatures - kLegBegin;

}  // namespace

int64_t FeaturesOf(View view) {
  return view == View::kLegs ? 2 * kLegFeatures : erd::kPositionFeatures + erd::kVelocityFeatures;
}

Tensor Seen(const Tensor& judged, View view) {
  if (view == View::kWhole) return judged;
  if (view == View::kMovement) return judged - judged.mean(0, true);
  return torch::cat({judged.narrow(2, kLegBegin, kLegFeatures),
                     judged.narrow(2, erd::kPositionFeatures + kLegBegin, kLegFeatures)},
                    2);
}

}  // namespace styled::train::style_erd
