#include "model/feet/floor.h"

#include <algorithm>

#include "model/base/smooth.h"
#include "model/feet/tuning.h"

namespace styled::feet {
float Floor::Follow(float lowest_m, float speed_mps, float dt_s) noexcept {
  if (!started_) {
    started_ = true;
    height_m_ = lowest_m;
    return height_m_;
  }
  const float apart = std::clamp(lowest_m - height_m_, -tuning::kFloorStep_m, tuning::kFloorStep_m);
  const float evidence =
      1 - SmoothStep(speed_mps, tuning::kFloorResting_mps, tuning::kFloorMoving_mps);
  height_m_ +=
      evidence * DecayShare(dt_s, apart < 0 ? tuning::kFloorFall_s : tuning::kFloorRise_s) * apart;
  return height_m_;
}

}  // namespace styled::feet
