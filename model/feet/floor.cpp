#include "model/feet/floor.h"

#include <algorithm>

#include "model/base/smooth.h"

namespace styled::feet {
namespace {

constexpr float kFall_s = 0.1F, kRise_s = 2.0F;
constexpr float kStep_m = 0.05F;                           // a surprise beyond this counts as this
constexpr float kResting_mps = 0.15F, kMoving_mps = 0.6F;  // full and no evidence

}  // namespace

float Floor::Follow(float lowest_m, float speed_mps, float dt_s) noexcept {
  if (!started_) {
    started_ = true;
    height_m_ = lowest_m;
    return height_m_;
  }
  const float apart = std::clamp(lowest_m - height_m_, -kStep_m, kStep_m);
  const float evidence = 1 - SmoothStep(speed_mps, kResting_mps, kMoving_mps);
  height_m_ += evidence * DecayShare(dt_s, apart < 0 ? kFall_s : kRise_s) * apart;
  return height_m_;
}

}  // namespace styled::feet
