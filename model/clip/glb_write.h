#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "model/base/status.h"
#include "model/clip/motion.h"

namespace styled::clip {

// Formats a motion as a glTF 2.0 binary: one node per joint (name, offset in metres, rest
// rotation); one animation with a rotation channel per joint, and a translation channel for joint 0
// and every other joint that moves, interpolated linearly; one skin with a bone of eight triangles
// per joint, so that viewers show something. A frame is left out if its time equals the previous
// one's as float seconds. Errors: no joints or frames, sizes that do not match, times that do not
// increase, numbers that are not finite, more than 4 GiB. Allocates; any thread.
//
// It cannot write: meshes, materials or textures other than these bones, morph targets, cameras,
// scale channels, several animations or skins, external buffers, extensions (VRM among them). A
// library would not make it shorter: tinygltf's writer would only copy fields to JSON, while the
// accessors, the skin and the mesh would stay here; and it would add a file reader that is not
// needed. Pinned by tests/unit/clip/glb_write_test.cpp, which reads the file by the specification
// alone; in tests/witness/gltf the Khronos validator and three.js check it.
Result<std::vector<std::byte>> FormatGlb(const Motion& motion);

// Writes FormatGlb's bytes to a file. Errors name the file.
Status WriteGlb(const Motion& motion, const std::filesystem::path& file);

// Whether a motion can be written: the errors above, without the size.
Status CheckMotion(const Motion& motion);

// The frames whose times differ as float seconds, and these times, from 0.
struct KeyTimes {
  std::vector<std::size_t> frames;
  std::vector<float> seconds;
};
KeyTimes TimesOf(const Motion& motion);

// The binary form of glTF (4.4) of a JSON text and a buffer; and the writing of such bytes. Errors:
// more than 4 GiB; a file that cannot be written, which is named.
Result<std::vector<std::byte>> JoinGlb(std::string text, std::span<const std::byte> binary);
Status WriteBytes(std::span<const std::byte> bytes, const std::filesystem::path& file);

}  // namespace styled::clip
