#include "model/net/erd/features.h"

#include <cmath>

#include "model/body/heading.h"

namespace styled::erd {

using body::kHips;
using body::kJointCount;
using body::Pose;
using body::Quat;
using body::Vec3;
using body::WorldPose;

float ComputeFeatures(const Pose& pose, const FeatureParameters& parameters, FeatureState& state,
                      Features& features) noexcept {
  WorldPose world;
  body::ForwardKinematics(pose, world);

  const float raw_rad = body::Heading_rad(world);
  const float period_s = 1.0F / parameters.rate_hz;
  const float keep = state.started && parameters.heading_tau_s > 0
                         ? std::exp(-period_s / parameters.heading_tau_s)
                         : 0.0F;
  const float heading_rad =
      body::FilterHeading(raw_rad, keep, state.heading_cos, state.heading_sin);
  const Quat heading_from_world = body::Yaw(-heading_rad);

  for (int joint = 0; joint < kJointCount; ++joint) {
    Quat q = pose.rotations[joint];
    if (joint == kHips) q = heading_from_world * q;
    if (q.coeffs().dot(parameters.hemisphere[joint].coeffs()) < 0) q.coeffs() = -q.coeffs();
    Eigen::Map<Eigen::Vector4f>(features.data() + 4 * joint) = q.coeffs();

    const Vec3 position = heading_from_world * (world.positions_m[joint] - pose.hips_position_m);
    Eigen::Map<Vec3>(features.data() + kPositionBegin + 3 * joint) = position;

    const Vec3 step_m =
        state.started ? Vec3(world.positions_m[joint] - state.positions_m[joint]) : Vec3::Zero();
    Eigen::Map<Vec3>(features.data() + kVelocityBegin + 3 * joint) =
        heading_from_world * step_m * parameters.rate_hz;
  }
  features[kHipsHeightIndex] = pose.hips_position_m.y();

  state.positions_m = world.positions_m;
  state.started = true;
  return heading_rad;
}

}  // namespace styled::erd
