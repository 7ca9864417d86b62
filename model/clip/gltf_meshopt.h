#pragma once

#include <cstddef>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "model/base/status.h"

// The compression of buffer views that gltfpack writes (EXT_meshopt_compression), for animations.
// Included only by gltf_*.cpp. Pinned by tests/unit/clip/gltf_clip_test.cpp, whose files are packed
// by meshoptimizer's own encoder, and hostile_clips_test.cpp.
namespace styled::clip::gltf {

inline constexpr const char* kMeshopt = "EXT_meshopt_compression";

// Unpacks a buffer view of `size` bytes, its byteLength, from a file's binary chunk. `packed` is
// the extension's object. Only mode ATTRIBUTES, with any filter: the other two hold indices of
// meshes, which no animation has. Refuses a view of more than `most` bytes, before it allocates,
// and each value that the extension's specification does not allow. Allocates `size` bytes; takes
// time in proportion to them. Any thread.
Result<std::string> UnpackView(const nlohmann::json& packed, std::string_view data,
                               std::size_t size, std::size_t most);

}  // namespace styled::clip::gltf
