#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "model/base/realtime.h"

// Datagrams of the app Live Link Face, version 6: a face's 52 expressions, and rotations of head
// and eyes in radians, big-endian. The layout is known from the readers of think-biq/LLV,
// JimWest/PyLiveLinkFace and tbxMb/GodotLiveLinkFace. Pure functions; any thread; nothing here
// allocates, blocks or throws. Pinned by tests/unit/livelinkface, fuzzed by
// tests/fuzz/livelinkface.
namespace styled::live_link_face {

inline constexpr std::size_t kValues = 61;  // arkit::kNames, then head and eyes: yaw, pitch, roll
inline constexpr std::size_t kMaxText = 255;
inline constexpr std::size_t kMaxSize = 27 + 2 * kMaxText + 4 * kValues;

struct Frame {
  std::string_view device;                   // the phone's id; a view of the datagram
  std::string_view subject;                  // the name that the user gave the phone
  std::int32_t frame = 0;                    // of an unknown epoch; falls when the app restarts
  float subframe = 0;                        // 0 .. 1
  std::int32_t rate = 60, rate_divisor = 1;  // frames per second
  bool has_face = false;                     // the camera sees a face
  std::array<float, kValues> values{};       // as received, not checked
};

enum class [[nodiscard]] DecodeResult : std::uint8_t {
  kOk,
  kNotFace,     // shorter than the smallest datagram, or texts that do not fit into it
  kBadVersion,  // not 6
  kBadText,     // a text longer than kMaxText
  kBadRate,     // a rate that is not positive
  kBadCount,    // not 61 values
  kBadSize,     // bytes missing or left over
  kCount
};
// A word for counters and messages: "ok", "not_face", ...
std::string_view Name(DecodeResult result) noexcept;

STYLED_REALTIME DecodeResult Decode(std::span<const std::byte> datagram, Frame& frame) noexcept;
// Writes a datagram; returns 0 if `to` is too small or a text is too long.
std::size_t Encode(const Frame& frame, std::span<std::byte> to) noexcept;

}  // namespace styled::live_link_face
