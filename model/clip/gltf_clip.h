#pragma once

#include <string>
#include <string_view>

#include "model/base/status.h"
#include "model/clip/clip.h"
#include "model/clip/gltf_read.h"
#include "model/rig/binding.h"
#include "model/rig/dialects.h"

namespace styled::clip {

// The motion of a glTF file's humanoid, in metres and glTF's axes (+Y up). Joint 0 is the hips, in
// world space: its motion includes that of the nodes above.
struct GltfClip {
  Clip clip;
  // Of the same joints; its stance is the nodes' own pose. `t_pose` only if that is a T-pose: where
  // a VRM's or VRMA's stands upright in another, against its definition, clip.remark names it.
  GltfSkeleton skeleton;
};

// Whether bytes begin like glTF binary.
bool IsGltfBinary(std::string_view bytes);

// Reads the first animation of a glTF 2.0 binary (.glb, .vrm, or .vrma: VRMC_vrm_animation) that
// turns a bone of its humanoid. Bones: `joints` given by hand, VRM's own table, else as
// ReadGltfSkeleton finds them. The rate
// is that of the densest channel, in whole Hz, 10 to 240, or lower if the frames would take more
// than 4 times the file's bytes and 4 MiB; LINEAR, STEP and CUBICSPLINE channels are sampled at it.
// Rotations as floats or normalized integers, also in buffer views packed by
// EXT_meshopt_compression (gltfpack -c); scale and weights channels, and those of other nodes, are
// ignored. Refuses, in addition to ReadGltfSkeleton's refusals: a file without its data, data
// outside the file (also "data:" in the text), sparse or broken accessors, more values in its
// channels than bytes in the file (and 3 MiB, if packed), times that do not rise, numbers that are
// not finite, no such animation, keys after a day, less than a frame a second, more nodes and
// channels than take 6 times the file's bytes and 4 MiB, and a file that takes longer than
// limits.work. A refusal of the data names the extensions that the file requires. Time and memory
// in proportion to the file. Never throws on content. Errors: "NAME: found X, expected Y".
// Allocates; any thread. Pinned by tests/unit/clip/gltf_clip_test.cpp, hostile_clips_test.cpp;
// tests/witness/gltf has files that three.js has written.
Result<GltfClip> ParseGltfClip(std::string_view bytes, const std::string& name,
                               const ReadLimits& limits = {}, const rig::JointNames& joints = {});

// The binding of such a clip: with skeleton.t_pose the nodes' pose is the T-pose. For other files,
// with "auto" the nodes' pose is the rest pose if it stands upright, else the first frame that
// does; another dialect is rig::BindDialect's.
Result<rig::Binding> BindGltf(const GltfClip& clip, std::string_view dialect = "auto");

}  // namespace styled::clip
