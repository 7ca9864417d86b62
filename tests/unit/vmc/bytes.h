#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

// OSC written out by hand, after the specification and without our encoder.
namespace styled::vmc::testing {

// A type of its own, for its operators.
struct Bytes : std::vector<std::byte> {
  using vector::vector;
};

inline Bytes ToBytes(std::string_view text) {
  Bytes bytes;
  for (const char c : text) bytes.push_back(static_cast<std::byte>(c));
  return bytes;
}

inline Bytes operator+(Bytes a, const Bytes& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

// Big-endian.
inline Bytes I(std::uint32_t value) {
  return {std::byte(value >> 24U), std::byte(value >> 16U), std::byte(value >> 8U),
          std::byte(value)};
}
inline Bytes F(float value) { return I(std::bit_cast<std::uint32_t>(value)); }

// A NUL, then zeros up to a multiple of 4.
inline Bytes S(std::string_view text) {
  Bytes bytes = ToBytes(text);
  do bytes.push_back(std::byte{0});
  while (bytes.size() % 4 != 0);
  return bytes;
}

inline Bytes Floats(const std::vector<float>& values) {
  Bytes bytes;
  for (const float value : values) bytes = bytes + F(value);
  return bytes;
}

inline Bytes Bundle(const std::vector<Bytes>& elements, std::uint64_t timetag = 1) {
  Bytes bytes = S("#bundle") + I(static_cast<std::uint32_t>(timetag >> 32U)) +
                I(static_cast<std::uint32_t>(timetag));
  for (const Bytes& element : elements) {
    bytes = bytes + I(static_cast<std::uint32_t>(element.size())) + element;
  }
  return bytes;
}

// The messages of VMC.
inline Bytes TimeMessage(float seconds) { return S("/VMC/Ext/T") + S(",f") + F(seconds); }
inline Bytes OkMessage() { return S("/VMC/Ext/OK") + S(",i") + I(1); }
inline Bytes BoneMessage(std::string_view name, const std::vector<float>& values) {
  return S("/VMC/Ext/Bone/Pos") + S(",sfffffff") + S(name) + Floats(values);
}
// A bone told apart by the x of its position.
inline Bytes BoneMessage(std::string_view name, float x = 0) {
  return BoneMessage(name, {x, 0, 0, 0, 0, 0, 1});
}
inline Bytes RootMessage(float x = 0) {
  return S("/VMC/Ext/Root/Pos") + S(",sfffffff") + S("root") + Floats({x, 0, 0, 0, 0, 0, 1});
}
inline Bytes BlendMessage(std::string_view name, float value) {
  return S("/VMC/Ext/Blend/Val") + S(",sf") + S(name) + F(value);
}
inline Bytes ApplyMessage() { return S("/VMC/Ext/Blend/Apply") + S(","); }

}  // namespace styled::vmc::testing
