#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "proto/rigs/qtm/packet.h"

// Packets of QTM RT written field by field, beside the codec and without its help.
namespace styled::qtm::testing {

using Bytes = std::vector<std::byte>;

inline void Append(Bytes& bytes, std::uint64_t value, int size) {
  for (int i = 0; i < size; ++i) bytes.push_back(std::byte((value >> (8 * i)) & 0xFF));
}

struct U32 {
  std::uint64_t value;
  void AppendTo(Bytes& b) const { Append(b, value, 4); }
};
struct I64 {
  std::int64_t value;
  void AppendTo(Bytes& b) const { Append(b, static_cast<std::uint64_t>(value), 8); }
};
struct U8 {
  unsigned value;
  void AppendTo(Bytes& b) const { Append(b, value, 1); }
};
struct F32 {
  float value;
  void AppendTo(Bytes& b) const { Append(b, std::bit_cast<std::uint32_t>(value), 4); }
};
struct Text {
  std::string_view value;
  bool nul = true;
  void AppendTo(Bytes& b) const {
    for (const char c : value) b.push_back(std::byte(c));
    if (nul) b.push_back(std::byte{0});
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

// A whole packet; `error` is added to its stated size.
template <typename... Fields>
Bytes Pack(std::uint32_t type, const Fields&... fields) {
  const Bytes payload = Join(fields...);
  return Join(U32{8 + payload.size()}, U32{type}, Part{payload});
}

inline Bytes Command(std::string_view text) { return Pack(1, Text{text}); }
inline Bytes Error(std::string_view text) { return Pack(0, Text{text}); }
inline Bytes Xml(std::string_view text) { return Pack(2, Text{text}); }
inline Bytes EventOf(unsigned number) { return Pack(6, U8{number}); }

// A component of a data packet.
template <typename... Fields>
Part ComponentOf(std::uint32_t type, const Fields&... fields) {
  const Bytes body = Join(fields...);
  return {Join(U32{8 + body.size()}, U32{type}, Part{body})};
}
// A data packet of these components.
template <typename... Components>
Bytes Data(std::int64_t time_us, std::uint32_t number, const Components&... components) {
  return Pack(3, I64{time_us}, U32{number}, U32{sizeof...(components)}, components...);
}
inline Part SegmentOf(std::uint32_t id, float x, float y, float z, float qx, float qy, float qz,
                      float qw) {
  return {Join(U32{id}, F32{x}, F32{y}, F32{z}, F32{qx}, F32{qy}, F32{qz}, F32{qw})};
}

}  // namespace styled::qtm::testing
