#pragma once

#include <array>
#include <filesystem>
#include <vector>

#include "model/base/status.h"
#include "model/rig/binding.h"
#include "model/rig/dialects.h"
#include "model/rig/tail.h"

namespace styled::clip {

// The skeleton of an avatar's file; its hips are joint 0.
struct GltfSkeleton {
  rig::Skeleton skeleton;  // metres; names made unique (a node without one is "node_INDEX")
  rig::RigPose stance;     // the file's pose: glTF's axes (+Y up), joint 0 in world space
  // Joint per canonical joint: as given, else by VRM's own table, else by name; -1: missing.
  std::array<int, body::kJointCount> source_joint;
  rig::TailMap tail = rig::NoTail();  // fingers, eyes and jaw, by the same
  std::vector<int> nodes;             // per joint, of the file
  bool t_pose = false;                // a VRM, whose stance is the T-pose by definition
  // The world transform of joint 0's parent: world = translation + scale * (rotation * node).
  rig::Vec3 above_translation_m = rig::Vec3::Zero();
  rig::Quat above_rotation = rig::Quat::Identity();
  float above_scale = 1;
};

// Reads .gltf, .glb or .vrm (0.x and 1.0); meshes, materials and images are ignored. The joints are
// the hips, and below them the humanoid's bones (VRM) or the skins' joints, with all nodes between;
// if these are more than rig::kMaxSourceJoints, only the mapped ones. Scales of nodes are applied
// to the offsets. A node that is stretched unevenly, mirrored or of scale 0 is left out, with what
// hangs from it; the file is refused only if that holds for a node between the root and a bone of
// the humanoid, fingers and the like included. Buffers and images are never opened; a file that
// refers to one outside its folder is refused, and so is one whose paths to them take longer than a
// second to follow. Other errors: not a regular file, not glTF, glTF 1, nodes that do not form a
// tree, no hips. Errors name the file, the node by number and name, and what was expected.
// Allocates; any thread. Pinned by tests/unit/clip/gltf_read_test.cpp, hostile_clips_test.cpp.
// Sources: glTF 2.0 (Khronos), VRM 0.x and VRMC_vrm-1.0.
Result<GltfSkeleton> ReadGltfSkeleton(const std::filesystem::path& file,
                                      const rig::JointNames& given = {});

}  // namespace styled::clip
