#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "model/base/status.h"
#include "model/clip/bind_clip.h"
#include "model/clip/clip.h"
#include "model/clip/gltf_clip.h"
#include "model/rig/dialects.h"

namespace styled::clip {

// A clip as read from any of the formats.
struct AnyClip : GltfClip {
  bool is_gltf = false;  // else a BVH file, and `skeleton` has nothing
};

// Reads a clip: BVH, or glTF binary with VRM and VRMA (gltf_clip.h), by its first bytes. `joints`:
// glTF's, given by hand. Errors are those of the two readers; FBX, glTF as text and ZIP archives
// are refused by name. Any thread; allocates. Pinned by tests/unit/clip/any_clip_test.cpp.
Result<AnyClip> ParseAnyClip(std::string_view bytes, const std::string& name,
                             const ReadLimits& limits = {}, const rig::JointNames& joints = {});
// The same of a file. BVH may also come from a pipe.
Result<AnyClip> ReadAnyClip(const std::filesystem::path& file, const ReadLimits& limits = {},
                            const rig::JointNames& joints = {});

// Binds it, as BindClip or as BindGltf, whose dialect is "vrm" or "gltf". glTF states its axes and
// how its nodes stand: options.rest and options.up are refused. No error names the file.
Result<BoundClip> BindAnyClip(const AnyClip& clip, const BindOptions& options = {});

// A motion of a glTF skeleton as BVH can hold it: its zero pose is the T-pose (WithTPose), the root
// has no offset beside its position, and names have no blanks.
Clip AsBvh(Clip clip, const rig::Binding& binding);

}  // namespace styled::clip
