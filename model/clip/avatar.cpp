#include "model/clip/avatar.h"

#include <cctype>
#include <filesystem>
#include <utility>

#include "model/clip/bind_clip.h"
#include "model/clip/clip.h"
#include "model/clip/gltf_read.h"
#include "model/clip/read_file.h"
#include "model/rig/calibration.h"

namespace styled::clip {
namespace {

// The T-pose as local rotations.
rig::RigPose RestOf(const rig::Binding& binding) {
  const rig::Skeleton& skeleton = binding.skeleton();
  const auto& worlds = binding.spec().rest_rotations;
  rig::RigPose pose(skeleton);
  for (std::size_t joint = 0; joint < worlds.size(); ++joint) {
    const int parent = skeleton.parents[joint];
    pose.rotations[joint] =
        parent < 0
            ? worlds[joint]
            : (worlds[static_cast<std::size_t>(parent)].conjugate() * worlds[joint]).normalized();
  }
  return pose;
}

Result<rig::Binding> BindGltfFile(const std::string& file, const rig::JointNames& given,
                                  AvatarSkeleton& avatar) {
  auto read = ReadGltfSkeleton(file, given);
  if (!read.ok()) return read.status();
  const GltfSkeleton& gltf = read.value();
  avatar.dialect = gltf.t_pose ? "vrm" : "gltf";
  avatar.nodes = gltf.nodes;
  avatar.metres_per_unit = gltf.above_scale;
  avatar.above_translation = gltf.above_translation_m;
  avatar.above_rotation = gltf.above_rotation;
  avatar.above_scale = gltf.above_scale;
  avatar.tail = gltf.tail;
  auto binding = rig::BindStanding(gltf.skeleton, gltf.source_joint, gltf.stance, gltf.t_pose);
  if (!binding.ok()) return Status::Error(file + ": " + binding.status().message());
  return binding;
}

Result<rig::Binding> BindBvhFile(const std::string& file, const std::string& dialect,
                                 const rig::JointNames& given, AvatarSkeleton& avatar) {
  constexpr std::size_t kMaxBytes = std::size_t{1} << 28;  // far above a skeleton's size
  constexpr const char* kExpected = ", expected an avatar's BVH file";
  const auto opened = InputFile::Open(file, kExpected);
  if (!opened.ok()) return opened.status();
  if (opened.value().size() > kMaxBytes) {
    return Status::Error(file + ": found more than 256 MiB" + kExpected);
  }
  const auto text = opened.value().Read(0, kMaxBytes);
  if (!text.ok()) return text.status();
  auto read = ParseBvh(text.value(), file);
  if (!read.ok()) return read.status();
  const Clip& clip = read.value();
  auto bound = BindClip(clip, {dialect, {}, given, {}});
  if (!bound.ok()) return Status::Error(file + ": " + bound.status().message());
  avatar.dialect = bound.value().dialect;
  avatar.tail = rig::FindTail(clip.skeleton, bound.value().map.joint);
  return std::move(bound.value().binding);
}

}  // namespace

Result<AvatarSkeleton> ReadAvatar(const std::string& file, const std::string& dialect,
                                  const rig::JointNames& given) {
  std::string extension = std::filesystem::path(file).extension();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  AvatarSkeleton avatar;
  auto binding = extension == ".bvh" ? BindBvhFile(file, dialect, given, avatar)
                                     : BindGltfFile(file, given, avatar);
  if (!binding.ok()) return binding.status();
  avatar.binding = std::make_shared<const rig::Binding>(std::move(binding.value()));
  avatar.rest = RestOf(*avatar.binding);
  return avatar;
}

}  // namespace styled::clip
