#pragma once

#include <cstddef>
#include <filesystem>
#include <vector>

#include "model/base/status.h"
#include "model/clip/motion.h"

namespace styled::clip {

// A glTF 2.0 binary: one node per joint (name, offset in metres, rest rotation), one animation with
// a rotation channel per joint and a translation channel for joint 0 and for those others that
// move, interpolated linearly, and one skin with a bone of eight triangles per joint, so that
// viewers show something. Frames nearer to the one before than float seconds can tell are left out.
// Errors: no joints or frames, sizes that do not match, times that do not grow, numbers that are
// not finite, more than 4 GiB. Any thread.
//
// It cannot write: meshes, materials or textures other than these bones, morph targets, cameras,
// scale channels, several animations or skins, external buffers, extensions (VRM among them).
// A library would not make it shorter: of tinygltf's writer only the copying of fields to JSON
// would be used, while the accessors, the skin and the mesh would stay here; and it would come with
// a reader of files that is not needed.
// Pinned by tests/unit/clip/glb_write_test.cpp, which reads the file by the specification alone;
// tests/witness/gltf has the Khronos validator and three.js check it.
Result<std::vector<std::byte>> FormatGlb(const Motion& motion);

// Errors name the file.
Status WriteGlb(const Motion& motion, const std::filesystem::path& file);

}  // namespace styled::clip
