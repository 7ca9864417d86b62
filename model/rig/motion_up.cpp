#include "model/rig/motion_up.h"

#include <algorithm>
#include <utility>
#include <vector>

namespace styled::rig {
namespace {

// Of the poses that must stand along another axis than the zero pose: in a clip of a performer who
// walks and lies down for a while, fewer lie. No measurement picked the shares.
constexpr float kMost = 0.8F, kFew = 0.3F;
constexpr float kAlong = 0.8F;  // a cosine: 37 degrees

}  // namespace

Vec3 UpOf(const Binding& binding) {
  return binding.spec().canonical_from_source.conjugate() * Vec3::UnitY();
}

std::optional<Vec3> UpOfMotion(const Binding& binding, std::span<const RigPose> poses) {
  const BindingSpec& spec = binding.spec();
  const auto joint = [&spec](int c) { return spec.source_joint[static_cast<std::size_t>(c)]; };
  const auto hips = static_cast<std::size_t>(joint(body::kHips));
  const auto head = static_cast<std::size_t>(joint(body::kHead));
  std::vector<std::size_t> feet;  // a binding has at least one
  for (const auto& [foot, toes] : {std::pair{body::kLeftFoot, body::kLeftToes},
                                   std::pair{body::kRightFoot, body::kRightToes}}) {
    const int mapped = joint(foot) >= 0 ? joint(foot) : joint(toes);
    if (mapped >= 0) feet.push_back(static_cast<std::size_t>(mapped));
  }
  std::vector<Vec3> positions;
  std::vector<Quat> rotations;
  std::vector<std::pair<Vec3, Vec3>> bodies;  // directions of trunk and legs, both upwards
  for (const RigPose& pose : poses) {
    WorldTransforms(spec.skeleton, pose, positions, rotations);
    Vec3 below = Vec3::Zero();
    for (const std::size_t foot : feet) below += positions[foot] / static_cast<float>(feet.size());
    bodies.emplace_back((positions[head] - positions[hips]).stableNormalized(),
                        (positions[hips] - below).stableNormalized());
  }
  const auto share = [&](const Vec3& axis) {
    int along = 0;
    for (const auto& [trunk, legs] : bodies) {
      along += trunk.dot(axis) > kAlong && legs.dot(axis) > kAlong ? 1 : 0;
    }
    return static_cast<float>(along) / static_cast<float>(std::max<std::size_t>(bodies.size(), 1));
  };
  if (bodies.empty() || share(UpOf(binding)) > kFew) return std::nullopt;
  for (int axis = 0; axis < 3; ++axis) {
    for (const float sign : {1.0F, -1.0F}) {
      const Vec3 up = sign * Vec3::Unit(axis);
      if (share(up) >= kMost) return up;
    }
  }
  return std::nullopt;
}

bool StandsOnFloor(const Binding& binding, std::span<const RigPose> poses) {
  constexpr float kLow_m = 0.5F, kHigh_m = 1.5F;  // the humanoid's hips stand at 0.98 m
  body::Pose pose;
  int standing = 0;
  for (const RigPose& source : poses) {
    binding.Bind(source, pose);
    const float height_m = pose.hips_position_m.y();
    standing += height_m > kLow_m && height_m < kHigh_m ? 1 : 0;
  }
  return static_cast<float>(standing) >= kMost * static_cast<float>(poses.size());
}

Result<Binding> WithUp(const Binding& binding, const Vec3& up) {
  BindingSpec spec = binding.spec();
  const Vec3 now = UpOf(binding);
  // Upside down: half a turn about the axis across the body.
  const Vec3 across = spec.canonical_from_source.conjugate() * Vec3::UnitX();
  const Quat turn = now.dot(up) < -0.99F ? Quat(Eigen::AngleAxisf(3.14159265F, across))
                                         : body::ShortestTurn(now, up);
  for (Quat& rest : spec.rest_rotations) rest = (turn * rest).normalized();
  spec.canonical_from_source = (spec.canonical_from_source * turn.conjugate()).normalized();
  return Binding::Make(std::move(spec));
}

}  // namespace styled::rig
