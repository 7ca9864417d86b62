#include "model/body/heading.h"

#include <cmath>

namespace styled::body {

Quat Yaw(float heading_rad) noexcept {
  return {std::cos(0.5F * heading_rad), 0.0F, std::sin(0.5F * heading_rad), 0.0F};
}

float Heading_rad(const WorldPose& world) noexcept {
  // Both lines point to the body's left. The factor 0.6 gives the wider shoulders about the same
  // weight as the hips.
  const Vec3 left = (world.positions_m[kLeftUpperLeg] - world.positions_m[kRightUpperLeg]) +
                    0.6F * (world.positions_m[kLeftUpperArm] - world.positions_m[kRightUpperArm]);
  const Vec3 forward = left.cross(Vec3::UnitY());
  return std::atan2(forward.x(), forward.z());
}

float FilterHeading(float raw_rad, float keep, float& cosine, float& sine) noexcept {
  cosine = keep * cosine + (1 - keep) * std::cos(raw_rad);
  sine = keep * sine + (1 - keep) * std::sin(raw_rad);
  return std::atan2(sine, cosine);
}

}  // namespace styled::body
