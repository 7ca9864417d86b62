#include "model/rig/motion_up.h"

#include <vector>

namespace styled::rig {
namespace {

// Of the poses that must stand along another axis than the zero pose: in a clip of a performer who
// walks and lies down for a while, fewer lie. No measurement picked the shares.
constexpr float kMost = 0.8F, kFew = 0.3F;
constexpr float kAlong = 0.8F;  // the cosine of 37 degrees: a trunk bows by as much in a walk

}  // namespace

Vec3 UpOf(const Binding& binding) {
  return binding.spec().canonical_from_source.conjugate() * Vec3::UnitY();
}

std::optional<Vec3> UpOfMotion(const Binding& binding, std::span<const RigPose> poses) {
  const BindingSpec& spec = binding.spec();
  const auto joint = [&](int left, int or_else) {
    const int mapped = spec.source_joint[static_cast<std::size_t>(left)];
    return static_cast<std::size_t>(
        mapped >= 0 ? mapped : spec.source_joint[static_cast<std::size_t>(or_else)]);
  };
  const std::size_t hips = joint(body::kHips, body::kHips), head = joint(body::kHead, body::kHead);
  const std::size_t left = joint(body::kLeftFoot, body::kLeftToes);
  const std::size_t right = joint(body::kRightFoot, body::kRightToes);
  std::vector<Vec3> positions;
  std::vector<Quat> rotations;
  std::vector<std::pair<Vec3, Vec3>> bodies;  // directions of trunk and legs, both upwards
  for (const RigPose& pose : poses) {
    WorldTransforms(spec.skeleton, pose, positions, rotations);
    bodies.emplace_back(
        (positions[head] - positions[hips]).stableNormalized(),
        (positions[hips] - 0.5F * (positions[left] + positions[right])).stableNormalized());
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
