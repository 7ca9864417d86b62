#pragma once

#include <array>
#include <filesystem>

#include "model/base/status.h"
#include "model/rig/binding.h"
#include "model/rig/dialects.h"

namespace styled::clip {

// The skeleton of an avatar's file, its hips as joint 0.
struct GltfSkeleton {
  rig::Skeleton skeleton;  // metres; names made unique (a node without one is "node_INDEX")
  rig::RigPose stance;     // as the file has it: glTF's axes (+Y up), joint 0 placed in the world
  std::array<int, body::kJointCount>
      source_joint;     // given, VRM's own table, else by names; -1: missing
  bool t_pose = false;  // a VRM: its stance is the T-pose by definition
  // What joint 0's node hangs from: world = translation + scale * (rotation * node).
  rig::Vec3 above_translation_m = rig::Vec3::Zero();
  rig::Quat above_rotation = rig::Quat::Identity();
  float above_scale = 1;
};

// Reads .gltf, .glb or .vrm (0.x and 1.0); meshes, materials and images are not looked at. Joints
// are the hips, and below them the humanoid's bones (VRM) or the skins' joints with all that lies
// between; no more than the mapped ones where that would exceed rig::kMaxSourceJoints. Scales of
// nodes go into the offsets. Buffers and images are never opened, and a file is refused that wants
// one from outside its folder. Errors name the file and what was expected: no ordinary file, no
// glTF, glTF 1, nodes that form no tree, no hips, a node stretched unevenly. Any thread. Pinned by
// tests/unit/clip/gltf_read_test.cpp. Source: glTF 2.0 (Khronos), VRM 0.x and VRMC_vrm-1.0.
Result<GltfSkeleton> ReadGltfSkeleton(const std::filesystem::path& file,
                                      const rig::JointNames& given = {});

}  // namespace styled::clip
