#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "model/body/pose.h"
#include "proto/rigs/natnet/frame.h"
#include "proto/rigs/natnet/model.h"

// A performer on a NatNet server's stage, in every convention that it may stream in.
namespace styled::natnet::testing {

inline constexpr std::array<std::string_view, body::kJointCount> kMotiveBones{
    "Hip",   "Ab",    "Chest",     "Neck",   "Head",  "LShoulder", "LUArm",
    "LFArm", "LHand", "RShoulder", "RUArm",  "RFArm", "RHand",     "LThigh",
    "LShin", "LFoot", "LToe",      "RThigh", "RShin", "RFoot",     "RToe"};

struct Streaming {
  bool local = false;    // bones relative to their parents
  bool z_up = false;     // the frames
  bool z_model = false;  // the description
};

inline body::Vec3 ZUp(const body::Vec3& v) { return {v.x(), -v.z(), v.y()}; }
inline body::Quat ZUp(const body::Quat& q) { return {q.w(), q.x(), -q.z(), q.y()}; }

inline void Describe(std::string_view name, std::int32_t id, const Streaming& as,
                     SkeletonDescription& skeleton) {
  skeleton.name = name;
  skeleton.id = id;
  skeleton.bone_count = kMotiveBones.size();
  for (int j = 0; j < body::kJointCount; ++j) {
    body::Vec3 offset = j == 0 ? body::Vec3(0, 0, 0) : body::Offset(j);
    if (as.z_model) offset = ZUp(offset);
    skeleton.bones[static_cast<std::size_t>(j)] = {
        kMotiveBones[static_cast<std::size_t>(j)],
        j + 1,
        body::kHumanoid[static_cast<std::size_t>(j)].parent + 1,
        {offset.x(), offset.y(), offset.z()}};
  }
}

inline void Place(const body::Pose& pose, std::int32_t id, const Streaming& as,
                  Skeleton& skeleton) {
  body::WorldPose world;
  body::ForwardKinematics(pose, world);
  skeleton.id = id;
  skeleton.bone_count = kMotiveBones.size();
  for (std::size_t j = 0; j < kMotiveBones.size(); ++j) {
    const bool local = as.local && j > 0;
    body::Vec3 p = local ? body::Offset(static_cast<int>(j)) : world.positions_m[j];
    body::Quat q = local ? pose.rotations[j] : world.rotations[j];
    if (as.z_up) {
      p = ZUp(p);
      q = ZUp(q);
    }
    skeleton.bones[j] = {id << 16 | static_cast<std::int32_t>(j + 1),
                         {p.x(), p.y(), p.z()},
                         {q.x(), q.y(), q.z(), q.w()},
                         true};
  }
}

// Bent in every joint, away from the origin.
inline body::Pose BentPose(float phase = 0) {
  body::Pose pose;
  pose.hips_position_m = {0.5F + phase, 0.9F, -1.25F};
  for (int j = 0; j < body::kJointCount; ++j) {
    const float angle = 0.3F + 0.02F * static_cast<float>(j) + phase;
    const body::Vec3 axis(static_cast<float>(j % 3) - 0.7F, static_cast<float>(j % 5) - 1.6F, 1);
    pose.rotations[static_cast<std::size_t>(j)] =
        body::Quat(Eigen::AngleAxisf(angle, axis.normalized()));
  }
  return pose;
}

}  // namespace styled::natnet::testing
