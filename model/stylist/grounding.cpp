#include "model/stylist/grounding.h"

#include <algorithm>
#include <limits>

namespace styled::stylist {
namespace {

constexpr int kFeet[] = {body::kLeftFoot, body::kLeftToes, body::kRightFoot, body::kRightToes};

rig::Vec3 WorldPosition(const rig::Skeleton& skeleton, const rig::RigPose& pose, int joint) {
  rig::Vec3 position = pose.translations[static_cast<std::size_t>(joint)];
  for (int above = skeleton.parents[static_cast<std::size_t>(joint)]; above >= 0;
       above = skeleton.parents[static_cast<std::size_t>(above)]) {
    const auto a = static_cast<std::size_t>(above);
    position = pose.translations[a] + pose.rotations[a].normalized() * position;
  }
  return position;
}

float LowestFoot(const rig::Binding& binding, const rig::RigPose& pose, const rig::Vec3& up) {
  float lowest = std::numeric_limits<float>::max();
  for (int foot : kFeet) {
    const int joint = binding.spec().source_joint[static_cast<std::size_t>(foot)];
    if (joint < 0) continue;
    lowest = std::min(lowest, WorldPosition(binding.skeleton(), pose, joint).dot(up));
  }
  return lowest;
}

}  // namespace

void Ground(const body::Pose& input, body::Pose& styled) noexcept {
  body::WorldPose world;
  body::ForwardKinematics(input, world);
  const float wanted_m = body::LowestFoot_m(world);
  body::ForwardKinematics(styled, world);
  styled.hips_position_m.y() += wanted_m - body::LowestFoot_m(world);
}

void Ground(const rig::Binding& binding, const rig::RigPose& input, rig::RigPose& styled) noexcept {
  const rig::Vec3 up = binding.spec().canonical_from_source.conjugate() * rig::Vec3::UnitY();
  const float shift = LowestFoot(binding, input, up) - LowestFoot(binding, styled, up);
  const rig::Skeleton& skeleton = binding.skeleton();
  const auto hips = static_cast<std::size_t>(binding.spec().source_joint[body::kHips]);
  // The shift is along the world's up; the hips' translation is in their parent's frame.
  rig::Quat world_from_parent = rig::Quat::Identity();
  for (int above = skeleton.parents[hips]; above >= 0;
       above = skeleton.parents[static_cast<std::size_t>(above)]) {
    world_from_parent =
        styled.rotations[static_cast<std::size_t>(above)].normalized() * world_from_parent;
  }
  styled.translations[hips] += world_from_parent.conjugate() * (shift * up);
}

}  // namespace styled::stylist
