#include "model/net/stgcn/features.h"

#include <cmath>

#include "model/body/heading.h"

namespace styled::stgcn {

using body::kHips;
using body::kJointCount;
using body::Quat;
using body::Vec3;

namespace {

using Rotation = Eigen::Map<Eigen::Vector4f>;
using ConstRotation = Eigen::Map<const Eigen::Vector4f>;

constexpr float kShortest = 1e-6F;  // of a rotation that has a direction

}  // namespace

float ComputeFeatures(const body::Pose& pose, const FeatureParameters& parameters,
                      HeadingState& state, Features& features) noexcept {
  body::WorldPose world;
  body::ForwardKinematics(pose, world);
  const float keep = state.started && parameters.heading_tau_s > 0
                         ? std::exp(-1.0F / parameters.rate_hz / parameters.heading_tau_s)
                         : 0.0F;
  const float heading_rad =
      body::FilterHeading(body::Heading_rad(world), keep, state.cosine, state.sine);
  state.started = true;

  const Quat heading_from_world = body::Yaw(-heading_rad);
  const Vec3 below_hips(pose.hips_position_m.x(), 0, pose.hips_position_m.z());
  for (int joint = 0; joint < kJointCount; ++joint) {
    float* out = features.data() + kChannels * joint;
    Eigen::Map<Vec3> position(out);
    position = heading_from_world * (world.positions_m[joint] - below_hips);
    Quat q = heading_from_world * world.rotations[joint];
    if (q.coeffs().dot(parameters.hemisphere[joint].coeffs()) < 0) q.coeffs() = -q.coeffs();
    Rotation(out + kPositionChannels) = q.coeffs();
  }
  return heading_rad;
}

void PoseOf(const Features& features, float heading_rad, body::Pose& pose) noexcept {
  std::array<Quat, kJointCount> global;
  for (int joint = 0; joint < kJointCount; ++joint) {
    const ConstRotation q(features.data() + kChannels * joint + kPositionChannels);
    const float length = q.norm();
    global[joint] = length < kShortest ? Quat::Identity() : Quat(Eigen::Vector4f(q / length));
    const int parent = body::kHumanoid[joint].parent;
    pose.rotations[joint] = parent < 0 ? body::Yaw(heading_rad) * global[joint]
                                       : global[parent].conjugate() * global[joint];
  }
  pose.hips_position_m = Vec3(0, features[kChannels * kHips + 1], 0);
}

void ToDecoded(const Features& features, net::Decoded& out) noexcept {
  body::Pose pose;
  PoseOf(features, 0, pose);
  out.rotations = pose.rotations;
  out.velocities_m_s.fill(0);
  out.hips_height_m = pose.hips_position_m.y();
}

void MirrorFeatures(const Features& features, Features& out) noexcept {
  const Features source = features;  // `out` may be `features`
  // A reflection at x = 0 negates a position's x, and a rotation's y and z.
  constexpr std::array<float, kChannels> kSigns{-1, 1, 1, 1, -1, -1, 1};
  for (int joint = 0; joint < kJointCount; ++joint) {
    const float* from = source.data() + kChannels * body::MirrorJoint(joint);
    for (int channel = 0; channel < kChannels; ++channel) {
      out[kChannels * joint + channel] = kSigns[channel] * from[channel];
    }
  }
}

void SetHemisphere(const Features& mean, FeatureParameters& parameters) {
  for (int joint = 0; joint < kJointCount; ++joint) {
    parameters.hemisphere[joint].coeffs() =
        ConstRotation(mean.data() + kChannels * joint + kPositionChannels).normalized();
  }
}

}  // namespace styled::stgcn
