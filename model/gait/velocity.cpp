#include "model/gait/velocity.h"

#include <utility>

#include "model/base/smooth.h"
#include "model/gait/tuning.h"

namespace styled::gait {

void Velocity::Follow(const body::Vec3& hips_m, float dt_s) noexcept {
  const body::Vec3 step_m(hips_m.x() - last_m_.x(), 0, hips_m.z() - last_m_.z());
  last_m_ = hips_m;
  const bool first = !std::exchange(placed_, true);
  if (first || !(step_m.norm() <= tuning::kFastest_mps * dt_s)) {  // NaN included
    seen_ = 0;                                                     // the former velocity is useless
    return;
  }
  const float share = DecayShare(dt_s, tuning::kVelocity_s);
  seen_ += share * (1 - seen_);
  if (seen_ > 0 && dt_s > 0) mps_ += share / seen_ * (step_m / dt_s - mps_);
}

void Velocity::Carry(Checkpoint& c) noexcept {
  c(last_m_, mps_, seen_, placed_);
  if (!c.reads() || !c.ok()) return;
  if (!last_m_.allFinite() || !mps_.allFinite() || !(seen_ >= 0 && seen_ <= 1)) c.Refuse();
}

}  // namespace styled::gait
