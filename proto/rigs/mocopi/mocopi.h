#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "model/base/realtime.h"

// Sony mocopi's motion format: little-endian chunks {u32 length, 4 letters, payload}, some of which
// contain chunks. A datagram is `head`, `sndf` and either `skdf` (the skeleton, about every 3.5 s)
// or `fram` (a pose). The grammar and the meaning of its fields are known from the work of
// seagetch/mcp-receiver, t-34400/mocopi_protocol_supplement and animu-sphere/usd-vrm-plugins. Bones
// are local to their parents, metres, right-handed, +Y up, +Z forward, +X the body's left; all
// rotations are identity in the T-pose. Pure functions; any thread; nothing here allocates, blocks
// or throws. Pinned by tests/unit/mocopi, fuzzed by tests/fuzz/mocopi.
namespace styled::mocopi {

inline constexpr int kBones = 27;
// Sony's own plug-in distinguishes datagrams by these sizes.
inline constexpr std::size_t kSkeletonSize = 1821;
inline constexpr std::size_t kFrameSize = 1591;  // with `uttm`; +14 with `tmcd`, -16 without `uttm`
inline constexpr std::size_t kFrameSizeWithTimecode = 1605;

// Relative to the parent bone. As received: neither normalized nor checked (rest is often sent as
// -0, 0, -0, -1).
struct Transform {
  std::array<float, 4> rotation{0, 0, 0, 1};  // x, y, z, w
  std::array<float, 3> position_m{};
  friend bool operator==(const Transform&, const Transform&) = default;
};

struct Sender {
  std::array<std::byte, 8> address{};  // `ipad`: the sender's address as it sees it; unreliable
  std::uint16_t port = 12351;          // `rcvp`: the receiver's port
  friend bool operator==(const Sender&, const Sender&) = default;
};

struct Bone {
  int parent = -1;  // an earlier bone; -1 for bone 0 only
  Transform rest;
  friend bool operator==(const Bone&, const Bone&) = default;
};
using Skeleton = std::array<Bone, kBones>;

struct Frame {
  std::uint32_t number = 0;           // `fnum`: +1 per frame
  float time_s = 0;                   // `time`: since the stream began; 0 to 1e9
  std::optional<double> unix_time_s;  // `uttm`: absent in the apps of early 2023
  // `tmcd`: in newer apps; its meaning is unknown.
  std::optional<std::array<std::byte, 6>> timecode;
  std::array<Transform, kBones> bones;
};

struct Datagram {
  enum class Kind : std::uint8_t { kSkeleton, kFrame };
  Sender sender;  // default values if the datagram has no `sndf`
  Kind kind = Kind::kFrame;
  Skeleton skeleton;  // kSkeleton: one entry per bone id
  Frame frame;        // kFrame
};

enum class [[nodiscard]] DecodeResult : std::uint8_t {
  kOk,
  kNotMocopi,   // does not begin with a `head` whose `ftyp` is "sony motion format"
  kBadVersion,  // `vrsn` is not 1
  kCutChunk,    // a chunk exceeds its container, or fewer bytes than a chunk's header
  kBadSize,     // a field's size differs from its type's
  kMissing,     // a required field, or both `skdf` and `fram`, are absent
  kRepeated,    // a chunk occurs twice, or both `skdf` and `fram` occur
  kBadBone,     // an id beyond 26 or given twice, or a parent that is not an earlier bone
  kBadTime,     // `time` is not a number from 0 to 1e9
  kCount        // the number of results
};
// A word for counters and messages: "ok", "not_mocopi", ...
std::string_view Name(DecodeResult result) noexcept;

// Decodes one whole datagram. Chunks may follow `head` in any order. Unknown ones are skipped by
// their length and never entered, so that the nesting depth is limited to the grammar's four
// levels. `datagram` is unspecified unless kOk.
STYLED_REALTIME DecodeResult Decode(std::span<const std::byte> bytes, Datagram& datagram) noexcept;

// Write a datagram to the front of `out`, in the order of real ones, and return its size. Return 0
// and write nothing if `out` is too small.
STYLED_REALTIME std::size_t Encode(const Sender& sender, const Skeleton& skeleton,
                                   std::span<std::byte> out) noexcept;
STYLED_REALTIME std::size_t Encode(const Sender& sender, const Frame& frame,
                                   std::span<std::byte> out) noexcept;

// The bones and their offsets in an adult's T-pose: the default until a `skdf` arrives. Rounded
// from the published sample.
struct BoneRow {
  std::string_view name;
  int parent;
  float x_m, y_m, z_m;
};
inline constexpr std::array<BoneRow, kBones> kBoneTable{{
    {"root", -1, 0.0F, 0.93293F, 0.0F},
    {"torso_1", 0, 0.0F, 0.05079F, -0.01151F},
    {"torso_2", 1, 0.0F, 0.05617F, 0.01071F},
    {"torso_3", 2, 0.0F, 0.05990F, 0.00115F},
    {"torso_4", 3, 0.0F, 0.06506F, -0.00444F},
    {"torso_5", 4, 0.0F, 0.07605F, -0.01506F},
    {"torso_6", 5, 0.0F, 0.09497F, -0.00914F},
    {"torso_7", 6, 0.0F, 0.10551F, 0.01577F},
    {"neck_1", 7, 0.0F, 0.04786F, 0.00715F},
    {"neck_2", 8, 0.0F, 0.04821F, 0.00422F},
    {"head", 9, 0.0F, 0.04830F, 0.00765F},
    {"l_shoulder", 7, 0.01233F, -0.07607F, 0.07534F},
    {"l_up_arm", 11, 0.12955F, 0.03249F, -0.03269F},
    {"l_low_arm", 12, 0.29208F, 0.00060F, 0.00137F},
    {"l_hand", 13, 0.24234F, 0.00050F, 0.00114F},
    {"r_shoulder", 7, -0.01233F, -0.07607F, 0.07534F},
    {"r_up_arm", 15, -0.12955F, 0.03249F, -0.03269F},
    {"r_low_arm", 16, -0.29208F, 0.00060F, 0.00137F},
    {"r_hand", 17, -0.24234F, 0.00050F, 0.00114F},
    {"l_up_leg", 0, 0.09237F, -0.04206F, 0.02033F},
    {"l_low_leg", 19, -0.00852F, -0.38772F, -0.00655F},
    {"l_foot", 20, -0.02326F, -0.40402F, -0.06049F},
    {"l_toes", 21, 0.00779F, -0.09884F, 0.12496F},
    {"r_up_leg", 0, -0.09237F, -0.04206F, 0.02033F},
    {"r_low_leg", 23, 0.00852F, -0.38772F, -0.00655F},
    {"r_foot", 24, 0.02326F, -0.40402F, -0.06049F},
    {"r_toes", 25, -0.00779F, -0.09884F, 0.12496F},
}};

// kBoneTable as a skeleton, rotations identity.
Skeleton UsualSkeleton() noexcept;

}  // namespace styled::mocopi
