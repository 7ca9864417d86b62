#pragma once

#include <cstddef>
#include <filesystem>
#include <vector>

#include "model/base/status.h"
#include "model/clip/motion.h"

namespace styled::clip {

// Formats a motion as a VRM animation (VRMC_vrm_animation 1.0 in glTF 2.0 binary), which moves any
// VRM avatar: the canonical humanoid's 21 joints in VRM's T-pose, all rotations 0, below a node at
// the origin; a rotation channel for each and a translation channel for the hips, linear, in
// canonical metres (programs scale it by the height of the hips). Motion::binding says which joints
// are which; without one they are found by names and tree, with Motion::rest as the T-pose.
// Fingers, faces, gaze and extra joints are left out. Errors: those of WriteGlb; no humanoid.
// Allocates; any thread. Pinned by tests/unit/clip/vrma_write_test.cpp; in tests/witness/gltf the
// Khronos validator, three.js and three-vrm-animation read it. The web page writes its takes by
// clients/web/page/src/vrma.ts.
Result<std::vector<std::byte>> FormatVrma(const Motion& motion);

// Writes FormatVrma's bytes to a file. Errors name the file.
Status WriteVrma(const Motion& motion, const std::filesystem::path& file);

}  // namespace styled::clip
