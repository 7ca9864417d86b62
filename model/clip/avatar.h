#pragma once

#include <memory>
#include <string>
#include <vector>

#include "model/base/status.h"
#include "model/rig/binding.h"
#include "model/rig/dialects.h"
#include "model/rig/tail.h"

namespace styled::clip {

// The skeleton of an avatar's file, bound to the canonical humanoid, for retargeting motion onto
// it.
struct AvatarSkeleton {
  // glTF: metres, +Y up; BVH: the file's units and axes
  std::shared_ptr<const rig::Binding> binding;
  rig::RigPose rest;                  // its T-pose
  rig::TailMap tail = rig::NoTail();  // its fingers, eyes and jaw
  std::string dialect;                // "vrm", "gltf", "standing", or the BVH's
  std::vector<int> nodes;             // glTF: the file's node of each joint; BVH: none
  float metres_per_unit = 0;          // of RootInFile and the file's offsets; 0: unknown
  // The transform of joint 0's parent in the file: world = translation + scale * (rotation * file).
  rig::Vec3 above_translation = rig::Vec3::Zero();
  rig::Quat above_rotation = rig::Quat::Identity();
  float above_scale = 1;

  // Joint 0's world position or rotation as stored in the file, relative to its parent there.
  rig::Vec3 RootInFile(const rig::Vec3& position) const {
    return above_rotation.conjugate() * (position - above_translation) / above_scale;
  }
  rig::Quat RootInFile(const rig::Quat& rotation) const {
    return (above_rotation.conjugate() * rotation).normalized();
  }
};

// Reads an avatar: .bvh by extension, anything else as glTF (.vrm, .glb, .gltf). A BVH is bound as
// a clip is (BindClip), under `dialect`. `given`: joints named by hand. Errors name the file and
// what was expected. Any thread; allocates.
Result<AvatarSkeleton> ReadAvatar(const std::string& file, const std::string& dialect,
                                  const rig::JointNames& given);

}  // namespace styled::clip
