#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

// Payloads written field by field, beside the codec and without its help.
namespace styled::natnet::testing {

using Bytes = std::vector<std::byte>;

inline void Append(Bytes& bytes, std::uint64_t value, int size) {
  for (int i = 0; i < size; ++i) bytes.push_back(std::byte((value >> (8 * i)) & 0xFF));
}

struct I32 {
  std::int64_t value;
  void AppendTo(Bytes& b) const { Append(b, static_cast<std::uint64_t>(value), 4); }
};
struct I16 {
  int value;
  void AppendTo(Bytes& b) const { Append(b, static_cast<std::uint64_t>(value), 2); }
};
struct U64 {
  std::uint64_t value;
  void AppendTo(Bytes& b) const { Append(b, value, 8); }
};
struct F32 {
  float value;
  void AppendTo(Bytes& b) const { Append(b, std::bit_cast<std::uint32_t>(value), 4); }
};
struct F64 {
  double value;
  void AppendTo(Bytes& b) const { Append(b, std::bit_cast<std::uint64_t>(value), 8); }
};
struct Text {
  std::string_view value;
  void AppendTo(Bytes& b) const {
    for (const char c : value) b.push_back(std::byte(c));
    b.push_back(std::byte{0});
  }
};
// Bytes of which nothing matters but how many there are.
struct Any {
  std::size_t size;
  void AppendTo(Bytes& b) const { b.insert(b.end(), size, std::byte{0x5A}); }
};
struct Part {
  Bytes value;
  void AppendTo(Bytes& b) const { b.insert(b.end(), value.begin(), value.end()); }
};

template <typename... Fields>
Bytes Join(const Fields&... fields) {
  Bytes bytes;
  (fields.AppendTo(bytes), ...);
  return bytes;
}

}  // namespace styled::natnet::testing
