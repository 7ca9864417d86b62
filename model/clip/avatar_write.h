#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "model/base/status.h"
#include "model/clip/avatar.h"
#include "model/clip/motion.h"

namespace styled::clip {

// An avatar's own file (.glb, .vrm), read once, into which any number of motions are written.
// Immutable; any number of threads. Allocates. Pinned by tests/unit/clip/avatar_write_test.cpp; in
// tests/witness/gltf the Khronos validator and three.js check what is written.
class AvatarFile {
 public:
  // Reads the file that `avatar` was read from. Refuses a file without meshes, one that is not a
  // glTF binary with all of its data inside, and JSON with more than 1024 keys in an object. Errors
  // begin with the file's name.
  static Result<AvatarFile> Read(const std::filesystem::path& avatar_file,
                                 const AvatarSkeleton& avatar);

  // Writes it with `motion` as its first animation: meshes, skins, materials, images, extensions
  // (VRM) and other animations stay as they are. The animation turns every joint's node and moves
  // joint 0's; a node that has a matrix gets the same transform as translation, rotation and scale,
  // because glTF animates no matrices. `motion` is of the avatar's skeleton, world space, metres.
  // Errors name the file: nodes that are not those of `avatar`, frames or rates as WriteGlb.
  Status Write(const AvatarSkeleton& avatar, const Motion& motion,
               const std::filesystem::path& file) const;

 private:
  struct Content;
  std::string name_;
  std::shared_ptr<const Content> content_;
};

}  // namespace styled::clip
