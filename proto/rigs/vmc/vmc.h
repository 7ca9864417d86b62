#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <variant>

#include "proto/rigs/vmc/osc.h"

// The messages of the Virtual Motion Capture protocol, version 3.1 (protocol.vmc.info;
// sh-akira/VirtualMotionCaptureProtocol, MIT), as far as they concern a pose. Unity's space:
// left-handed, +Y up, the avatar faces +Z, metres; quaternions x, y, z, w as received, not
// normalized, possibly not finite. Pure functions; any thread; no allocation. Pinned by
// tests/unit/vmc/vmc_test.cpp, fuzzed by tests/fuzz/vmc.
namespace styled::vmc {

inline constexpr std::string_view kTimeAddress = "/VMC/Ext/T";

struct Transform {
  std::array<float, 3> position{};
  std::array<float, 4> rotation{0, 0, 0, 1};
  friend bool operator==(const Transform&, const Transform&) = default;
};

// /VMC/Ext/OK. Fields that an older sender omits keep these defaults.
struct Available {
  std::int32_t loaded = 1;             // 1: an avatar is loaded
  std::int32_t calibration_state = 3;  // 0 none, 1 waiting, 2 in progress, 3 done
  std::int32_t calibration_mode = 0;   // 0 normal, 1 mixed reality, 2 mixed reality by the floor
  std::int32_t tracking = 1;
};
// /VMC/Ext/T: the sender's clock.
struct Time {
  float seconds = 0;
};
// /VMC/Ext/Root/Pos: the avatar in the world. Scale and offset of mixed reality are skipped.
struct Root {
  Transform transform;
};
// /VMC/Ext/Bone/Pos: relative to the parent bone; the hips relative to the root.
struct Bone {
  std::string_view name;
  Transform transform;
};
// /VMC/Ext/Blend/Val: the weight of a facial expression, 0 .. 1; the avatar defines the names.
struct Blend {
  std::string_view name;
  float value = 0;
};
// /VMC/Ext/Blend/Apply: the set of Blends is complete.
struct BlendApply {};
// /VMC/Thru/<any>/<any>: a message from an assistant to the marionette, passed on unchanged.
struct Thru {
  std::span<const std::byte> bytes;  // the whole message
};

// Texts point into the bytes that were read.
using Message = std::variant<std::monostate, Available, Time, Root, Bone, Blend, BlendApply, Thru>;

enum class [[nodiscard]] DecodeResult : std::uint8_t {
  kOk,
  kUnknownAddress,   // not about a pose, or not VMC
  kTooFewArguments,  // additional arguments are ignored: a later version
  kWrongType,
  kCount  // the number of results
};
std::string_view Name(DecodeResult result) noexcept;

// `message` is written only on kOk.
STYLED_REALTIME DecodeResult Decode(const osc::Message& bytes, Message& message) noexcept;

// Writes one message (within a bundle, if the writer is in one). Root has exactly eight arguments,
// because VMCLiveLink expects exactly those.
STYLED_REALTIME void Put(const Available& message, osc::Writer& writer) noexcept;
STYLED_REALTIME void Put(const Time& message, osc::Writer& writer) noexcept;
STYLED_REALTIME void Put(const Root& message, osc::Writer& writer) noexcept;
STYLED_REALTIME void Put(const Bone& message, osc::Writer& writer) noexcept;
STYLED_REALTIME void Put(const Blend& message, osc::Writer& writer) noexcept;
STYLED_REALTIME void Put(const BlendApply& message, osc::Writer& writer) noexcept;
STYLED_REALTIME void Put(const Thru& message, osc::Writer& writer) noexcept;

}  // namespace styled::vmc
