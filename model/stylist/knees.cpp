#include "model/stylist/knees.h"

#include <cmath>

#include "model/base/smooth.h"
#include "model/stylist/tuning.h"

namespace styled::stylist {
namespace {

using body::Quat;

constexpr float kPi = static_cast<float>(M_PI);

// The rotation about the knee's axis, x, in `q` = swing * turn; positive when the knee bends.
float Bend_rad(const Quat& q) { return std::remainder(2 * std::atan2(q.x(), q.w()), 2 * kPi); }

}  // namespace

void KeepKnees(const body::Pose& in, float share, body::Pose& styled) noexcept {
  for (const int joint : {body::kLeftLowerLeg, body::kRightLowerLeg}) {
    const auto knee = static_cast<std::size_t>(joint);
    const float own = Bend_rad(in.rotations[knee]);
    const float wanted = Bend_rad(styled.rotations[knee]);
    // The bound is the performer's own backward bend, if any. `pushed` is the bend that the rounded
    // corner adds; its value at the performer's own bend is subtracted, so that an unstyled knee is
    // unchanged. A knee bent far beyond what is possible is not corrected.
    const float least = -SoftPositive(-own, tuning::kKneeCorner_rad);
    const auto pushed = [least](float bend) {
      return SoftPositive(bend - least, tuning::kKneeCorner_rad) - (bend - least);
    };
    const float let_go = SmoothStep((kPi - std::abs(wanted)) / (kPi - tuning::kKneeBroken_rad));
    const body::Vec3 turn(share * let_go * (pushed(wanted) - pushed(own)), 0, 0);
    styled.rotations[knee] = (styled.rotations[knee] * body::Exp(turn)).normalized();
  }
}

}  // namespace styled::stylist
