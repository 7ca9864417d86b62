#pragma once

#include <numbers>
#include <random>

#include "model/body/heading.h"
#include "model/body/pose.h"

namespace styled::body {

// Repeatable numbers for tests.
class Random {
 public:
  explicit Random(unsigned seed) : engine_(seed) {}

  float Between(float low, float high) {
    return low + (high - low) * static_cast<float>(engine_() >> 8) / 16777216.0F;
  }
  Vec3 Vector(float reach) {
    return {Between(-reach, reach), Between(-reach, reach), Between(-reach, reach)};
  }
  // A rotation of up to `most_rad` about any axis.
  Quat Turn(float most_rad) {
    const Vec3 axis = (Vector(1) + Vec3(1e-3F, 0, 0)).normalized();
    return Quat(Eigen::AngleAxisf(Between(-most_rad, most_rad), axis));
  }
  // A body at any place, with any heading and with every joint rotated.
  Pose AnyPose() {
    Pose pose;
    pose.hips_position_m = Vector(20);
    for (Quat& q : pose.rotations) q = Turn(1.5F);
    pose.rotations[kHips] = Turn(std::numbers::pi_v<float>);
    return pose;
  }

 private:
  std::mt19937 engine_;
};

// A roughly upright body, so that its heading is well defined.
inline Pose Upright(Random& random) {
  Pose pose;
  pose.hips_position_m = Vec3(random.Between(-5, 5), 0.95F, random.Between(-5, 5));
  for (Quat& q : pose.rotations) q = random.Turn(0.4F);
  return pose;
}

// The same body at another place, with another heading.
inline Pose Moved(const Pose& pose, float yaw_rad, const Vec3& shift) {
  Pose moved = pose;
  moved.hips_position_m = Yaw(yaw_rad) * pose.hips_position_m + shift;
  moved.rotations[kHips] = Yaw(yaw_rad) * pose.rotations[kHips];
  return moved;
}

// The angle between two rotations, radians; accurate near zero, where acos is not.
inline double Angle_rad(const Quat& a, const Quat& b) {
  const Eigen::Quaterniond d =
      a.cast<double>().normalized().conjugate() * b.cast<double>().normalized();
  return 2 * std::atan2(d.vec().norm(), std::abs(d.w()));
}

}  // namespace styled::body
