#pragma once

#include <memory>
#include <string>

#include "model/base/status.h"
#include "model/rig/binding.h"
#include "model/rig/dialects.h"

namespace styled::clip {

// A skeleton to put motion onto, read from an avatar's file and bound to the canonical humanoid.
struct AvatarSkeleton {
  std::shared_ptr<const rig::Binding> binding;  // metres and +Y up; of a BVH its units and axes
  rig::RigPose rest;                            // its T-pose
  std::string dialect;                          // "vrm", "gltf", "standing", or the BVH's
  float metres_per_unit = 0;  // as RootInFile and offsets in the file; 0 = unknown
  // What joint 0 hangs from in the file: world = translation + metres_per_unit * (rotation * file).
  rig::Vec3 above_translation = rig::Vec3::Zero();
  rig::Quat above_rotation = rig::Quat::Identity();
  float above_scale = 1;

  // Joint 0 as the file has it, relative to its parent there.
  rig::Vec3 RootInFile(const rig::Vec3& position) const {
    return above_rotation.conjugate() * (position - above_translation) / above_scale;
  }
  rig::Quat RootInFile(const rig::Quat& rotation) const {
    return (above_rotation.conjugate() * rotation).normalized();
  }
};

// By extension: .bvh, else glTF (.vrm, .glb, .gltf). A BVH is bound by `dialect` or, where that is
// "auto" and its zero pose none that we know, by its first frame, standing. `given`: joints by
// hand. Errors name the file and say what was expected. Any thread; allocates.
Result<AvatarSkeleton> ReadAvatar(const std::string& file, const std::string& dialect,
                                  const rig::JointNames& given);

}  // namespace styled::clip
