#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "model/base/realtime.h"
#include "proto/arkit/shapes.h"

// The text of the apps iFacialMocap and Facemotion3d, in versions 1 ("jawOpen-12") and 2
// ("jawOpen&12"): parts that end with '|', expressions in percent, and "=head#", "rightEye#",
// "leftEye#" with degrees and metres. Known from the vendors' pages for developers. The receiver
// starts the stream by sending a text to the phone. Pure functions; any thread; nothing here
// allocates, blocks or throws. Pinned by tests/unit/ifacialmocap, fuzzed by
// tests/fuzz/ifacialmocap.
namespace styled::ifacialmocap {

inline constexpr std::uint16_t kPort = 49983;  // of the phone, and of the receiver
// The text that a receiver sends to the phone until data arrives; a restarted app has lost it.
inline constexpr std::string_view kStart =
    "iFacialMocap_sahuasouryya9218sauhuiayeta91555dy3719|sendDataVersion=v2";
inline constexpr std::size_t kMaxSize = 4096;  // the usual size is 900 to 1,000 bytes

struct Frame {
  std::array<float, arkit::kShapes> shapes{};    // 0 .. 1 as a rule; as received, not checked
  int known = 0;                                 // shapes that the text has
  std::array<float, 6> head{};                   // degrees x, y, z; metres x, y, z
  std::array<float, 3> right_eye{}, left_eye{};  // degrees; x: downwards
  friend bool operator==(const Frame&, const Frame&) = default;
};

enum class [[nodiscard]] DecodeResult : std::uint8_t {
  kOk,
  kNotFace,    // not text, or no part that is known
  kBadNumber,  // a known part whose value is not a number
  kTooLong,    // more than kMaxSize
  kCount
};
std::string_view Name(DecodeResult result) noexcept;

// Unknown parts are skipped; a shape that is missing is 0.
STYLED_REALTIME DecodeResult Decode(std::span<const std::byte> datagram, Frame& frame) noexcept;
// Writes version 1 or 2; returns 0 if `to` is too small. Weights are rounded to percents.
std::size_t Encode(const Frame& frame, int version, std::span<char> to) noexcept;

}  // namespace styled::ifacialmocap
