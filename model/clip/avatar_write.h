#pragma once

#include <filesystem>
#include <string>

#include "model/base/status.h"
#include "model/clip/avatar.h"
#include "model/clip/motion.h"

namespace styled::clip {

// Why WriteAvatarGlb cannot keep the meshes of this avatar's file; "" if it can. It needs a glTF
// binary (.glb, .vrm) with all of its data inside.
std::string WhyNotKept(const std::filesystem::path& avatar_file, const AvatarSkeleton& avatar);

// Writes the avatar's own file (.glb, .vrm) with `motion` as its first animation: meshes, skins,
// materials, images, extensions (VRM) and other animations stay as they are. The animation turns
// every joint's node and moves joint 0's; a node that has a matrix gets the same transform as
// translation, rotation and scale, because glTF animates no matrices. `motion` is of the avatar's
// skeleton, world space, metres. Errors name the file: what WhyNotKept says, a file that changed
// since ReadAvatar, frames or rates as WriteGlb. Allocates; any thread. Pinned by
// tests/unit/clip/avatar_write_test.cpp; in tests/witness/gltf the Khronos validator and three.js
// check it.
Status WriteAvatarGlb(const std::filesystem::path& avatar_file, const AvatarSkeleton& avatar,
                      const Motion& motion, const std::filesystem::path& file);

}  // namespace styled::clip
