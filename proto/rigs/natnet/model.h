#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "proto/rigs/natnet/packet.h"

namespace styled::natnet {

inline constexpr std::size_t kMaxSkeletons = 16;  // per model and frame; further ones are left out
inline constexpr std::size_t kMaxBones = 64;      // a skeleton with more is left out
inline constexpr std::size_t kMaxRigidBodies =
    64;  // per model and frame; further ones are not read

// One bone of a skeleton at rest, as Motive describes it.
struct BoneDescription {
  std::string_view name;
  std::int32_t id = 0;              // 1 to N within the skeleton
  std::int32_t parent = 0;          // the parent's id; 0: none
  std::array<float, 3> offset_m{};  // from the parent, in the rest pose
};
struct SkeletonDescription {
  std::string_view name;
  std::int32_t id = 0;
  std::size_t bone_count = 0;
  std::array<BoneDescription, kMaxBones> bones;
};

struct RigidBodyDescription {
  std::string_view name;
  std::int32_t id = 0;
  std::int32_t parent = -1;  // above 0: it is a part of something
};

// MODELDEF: the tracked objects. Skeletons and rigid bodies are read, the others skipped.
struct Model {
  std::size_t rigid_body_count = 0;   // in the packet
  std::size_t rigid_bodies_read = 0;  // of them, in rigid_bodies
  std::array<RigidBodyDescription, kMaxRigidBodies> rigid_bodies;
  std::size_t skeleton_count = 0;
  std::size_t skeletons_left_out = 0;
  // False: before 4.1, a data set of an unknown kind hides everything after it.
  bool complete = true;
  std::array<SkeletonDescription, kMaxSkeletons> skeletons;
};

// `model` is unspecified unless kOk; names point into `payload`. More bytes may follow the last
// data set.
STYLED_REALTIME DecodeResult DecodeModel(std::span<const std::byte> payload, Version version,
                                         Model& model) noexcept;

// Encodes the skeletons and rigid_bodies_read bodies, without markers. Returns 0 if they do not
// fit.
STYLED_REALTIME std::size_t EncodeModel(const Model& model, Version version,
                                        std::span<std::byte> out) noexcept;

}  // namespace styled::natnet
