#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "model/base/status.h"
#include "model/rig/skeleton.h"

namespace styled::clip {

// Motion as glTF takes it: at whatever times its frames have.
struct GlbMotion {
  std::string name = "motion";
  rig::Skeleton skeleton;       // its own units and axes
  std::vector<rig::Quat> rest;  // world rotations of the pose that the mesh is bound in; empty =
                                // all identity
  std::vector<double> times_s;  // one per frame, growing; the first one becomes 0
  std::vector<rig::RigPose> frames;
  float metres_per_unit = 1;  // > 0
  // Source axes to glTF's (+Y up, +Z forward); other than identity it becomes a node above the
  // root.
  rig::Quat gltf_from_source = rig::Quat::Identity();
};

// A glTF 2.0 binary: one node per joint (name, offset in metres, rest rotation), one animation with
// a rotation channel per joint and a translation channel for joint 0 and for those others that
// move, interpolated linearly, and one skin with a bone of eight triangles per joint, so that
// viewers show something. Frames nearer to the one before than float seconds can tell are left out.
// Errors: no joints or frames, sizes that do not match, times that do not grow, numbers that are
// not finite, more than 4 GiB. Any thread. Pinned by tests/unit/clip/glb_write_test.cpp and, by
// other hands' readers, tests/witness/gltf.
Result<std::vector<std::byte>> FormatGlb(const GlbMotion& motion);

// Errors name the file.
Status WriteGlb(const GlbMotion& motion, const std::filesystem::path& file);

}  // namespace styled::clip
