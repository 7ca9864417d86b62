#pragma once

#include <array>
#include <cstdint>
#include <string_view>
#include <variant>

#include "model/base/realtime.h"
#include "proto/rigs/vmc/osc.h"

// The OSC messages in which VRChat receives trackers, and in which it sends its own devices
// (VRChat's documentation, "OSC Trackers"; vrchat-community/vrc-oscquery-lib, MIT). Unity's space:
// left-handed, +Y up, +Z ahead, metres; values as received, possibly not finite. Pure functions;
// any thread; no allocation. Pinned by tests/unit/vrchat/vrchat_test.cpp, fuzzed by
// tests/fuzz/vrchat.
namespace styled::vrchat {

namespace osc = vmc::osc;

// Trackers are numbered 1 .. 8. A number is not a body part.
inline constexpr int kTrackers = 8;
// Stands for "head" in `Tracker::index`.
inline constexpr int kHead = 0;

// /tracking/trackers/<1..8>/position and /rotation, /tracking/trackers/head/position and /rotation.
// The position of the head is that of the avatar's head bone, not the eyes. Its rotation is used
// for the heading only, and is usually sent once per reset.
struct Tracker {
  int index = kHead;
  bool is_rotation = false;
  std::array<float, 3> values{};  // metres, or Euler angles in degrees (QuaternionOf)
};

// /tracking/vrsystem/{head,leftwrist,rightwrist}/pose: what VRChat sends.
enum class System : std::uint8_t { kHead, kLeftWrist, kRightWrist };
struct SystemPose {
  System device = System::kHead;
  std::array<float, 3> position{};  // metres
  std::array<float, 3> euler{};     // degrees
};

using Message = std::variant<std::monostate, Tracker, SystemPose>;

enum class [[nodiscard]] DecodeResult : std::uint8_t {
  kOk,
  kUnknownAddress,   // not about trackers: avatar parameters, chat, eyes, an index beyond 8
  kTooFewArguments,  // additional arguments are ignored
  kWrongType,
  kCount  // the number of results
};
std::string_view Name(DecodeResult result) noexcept;

// `message` is written only on kOk.
STYLED_REALTIME DecodeResult Decode(const osc::Message& bytes, Message& message) noexcept;

STYLED_REALTIME void Put(const Tracker& message, osc::Writer& writer) noexcept;
STYLED_REALTIME void Put(const SystemPose& message, osc::Writer& writer) noexcept;

// Unity's Quaternion.Euler: a turn about z, then about x, then about y, all on fixed axes
// (q = qY qX qZ). x, y, z, w; degrees.
STYLED_REALTIME std::array<float, 4> QuaternionOf(const std::array<float, 3>& euler) noexcept;
// The inverse, of a unit quaternion. Where x is within 0.1 degrees of +-90, y and z turn about the
// same axis: z is 0 then.
STYLED_REALTIME std::array<float, 3> EulerOf(const std::array<float, 4>& quaternion) noexcept;

}  // namespace styled::vrchat
