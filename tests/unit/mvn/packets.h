#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

// MXTP datagrams put together by hand, byte for byte after the vendor's specification: what the
// decoder is held against, and the fuzzer's seeds. Not made by our encoder.
namespace styled::mvn::testing {

using Bytes = std::vector<std::byte>;

inline void Big(Bytes& out, std::uint32_t value, int size) {
  for (int shift = 8 * (size - 1); shift >= 0; shift -= 8) {
    out.push_back(static_cast<std::byte>((value >> shift) & 0xFFU));
  }
}
inline void Real(Bytes& out, float value) { Big(out, std::bit_cast<std::uint32_t>(value), 4); }
inline void Text(Bytes& out, std::string_view text) {
  for (const char c : text) out.push_back(static_cast<std::byte>(c));
}

// The header of a real MXTP02 datagram except for the size: sample 0x1A19, time 0x6CBD.
inline Bytes Head(std::string_view type, std::uint8_t items, std::uint8_t datagram = 0x80) {
  Bytes out;
  Text(out, "MXTP");
  Text(out, type);
  Big(out, 0x1A19, 4);
  Big(out, datagram, 1);
  Big(out, items, 1);
  Big(out, 0x6CBD, 4);
  for (const std::uint32_t byte : {0U, 23U, 0U, 0U}) Big(out, byte, 1);
  Big(out, 0, 2);
  Big(out, 0, 2);
  return out;
}

// Sets the payload's size, the last two bytes of the header.
inline Bytes Sized(Bytes datagram) {
  const std::size_t payload = datagram.size() - 24;
  datagram[22] = static_cast<std::byte>(payload >> 8U);
  datagram[23] = static_cast<std::byte>(payload & 0xFFU);
  return datagram;
}

// The Pelvis of a real datagram (see mvn_test.cpp), 22 times more with other ids.
inline Bytes Quaternions(int count = 23) {
  Bytes out = Head("02", static_cast<std::uint8_t>(count));
  for (int i = 0; i < count; ++i) {
    Big(out, static_cast<std::uint32_t>(i + 1), 4);
    for (const float value : {0.06897729F, 0.41073215F, 1.04834807F, 0.98897827F, -0.00467666F,
                              -0.07288225F, -0.12879553F}) {
      Real(out, value);
    }
  }
  return Sized(out);
}

inline Bytes Eulers() {
  Bytes out = Head("01", 23);
  for (int i = 0; i < 23; ++i) {
    Big(out, static_cast<std::uint32_t>(i + 1), 4);
    for (const float value : {41.073215F, 104.834807F, 6.897729F, 90.0F, 0.0F, 90.0F}) {
      Real(out, value);
    }
  }
  return Sized(out);
}

inline Bytes Meta(std::string_view lines) {
  Bytes out = Head("12", 1);
  Big(out, static_cast<std::uint32_t>(lines.size()), 4);
  Text(out, lines);
  return Sized(out);
}

inline Bytes ScaleOf(const std::vector<std::string>& names) {
  Bytes out = Head("13", 0, 0);
  Big(out, static_cast<std::uint32_t>(names.size()), 4);
  float x = 0;
  for (const auto& name : names) {
    Big(out, static_cast<std::uint32_t>(name.size()), 4);
    Text(out, name);
    for (const float value : {x, 0.25F, 1.5F}) Real(out, value);
    x += 1;
  }
  Big(out, 0, 4);
  return Sized(out);
}

inline Bytes TimecodeOf(std::string_view text, bool with_length) {
  Bytes out = Head("25", 1);
  if (with_length) Big(out, static_cast<std::uint32_t>(text.size()), 4);
  Text(out, text);
  return Sized(out);
}

// Inputs that the decoder has to tolerate.
inline std::vector<Bytes> Seeds() {
  return {Quaternions(),
          Quaternions(12),
          Eulers(),
          Meta("name:Anna\nxmid:00B40C49\ncolor:FF0080\n"),
          ScaleOf({"Pelvis", "L5", "L3"}),
          TimecodeOf("10:20:30.456", false),
          TimecodeOf("10:20:30.456", true)};
}

}  // namespace styled::mvn::testing
