#include "daemon/source/face.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstring>

#include "daemon/source/wire.h"

namespace styled::source {
namespace {

// Protobuf's tags, (field << 3) | wire type.
constexpr std::uint32_t kExpressionsTag = 18U << 3U | 2U, kThruTag = 19U << 3U | 2U;
constexpr std::uint32_t kName = 1U << 3U | 2U, kValue = 2U << 3U | 5U;

// proto3 omits fields with default values: an empty name, and a weight whose bits are all 0.
void Write(const Face::Expression& expression, WireWriter& out) noexcept {
  const std::size_t name = expression.name.size();
  const bool has_value = std::bit_cast<std::uint32_t>(expression.value) != 0;
  out.Varint(kExpressionsTag);
  out.Varint((name > 0 ? 1 + VarintSize(name) + name : 0) + (has_value ? 1 + sizeof(float) : 0));
  if (name > 0) {
    out.Varint(kName);
    out.Varint(name);
    out.Bytes(std::as_bytes(std::span(expression.name)));
  }
  if (has_value) {
    out.Varint(kValue);
    out.Bytes(std::as_bytes(std::span(&expression.value, 1)));
  }
}

// Reads a varint. Returns false if the bytes end within it, or it is larger than a length can be.
bool ReadVarint(std::span<const std::byte> bytes, std::size_t& at, std::size_t& value) noexcept {
  value = 0;
  for (unsigned shift = 0; at < bytes.size() && shift < 28; shift += 7) {
    const auto byte = std::to_integer<std::size_t>(bytes[at++]);
    value |= (byte & 0x7FU) << shift;
    if (byte < 0x80U) return true;
  }
  return false;
}

// The fields of an encoded face, one after the other.
class FieldReader {
 public:
  explicit FieldReader(std::span<const std::byte> bytes) noexcept : bytes_(bytes) {}
  // Returns false at the end, and at bytes that are not a field with a length.
  bool Next() noexcept {
    begin = at_;
    if (at_ == bytes_.size() || !ReadVarint(bytes_, at_, tag) || !ReadVarint(bytes_, at_, size)) {
      return false;
    }
    content = at_;
    if ((tag & 7U) != 2 || size > bytes_.size() - at_) return false;
    at_ += size;
    return true;
  }
  std::size_t tag = 0, begin = 0, content = 0, size = 0;

 private:
  std::span<const std::byte> bytes_;
  std::size_t at_ = 0;
};

struct SideWord {
  std::string_view here, there;
};
constexpr auto kSideWords = std::to_array<SideWord>({{"Left", "Right"},
                                                     {"Right", "Left"},
                                                     {"left", "right"},
                                                     {"right", "left"},
                                                     {"LEFT", "RIGHT"},
                                                     {"RIGHT", "LEFT"},
                                                     {"L", "R"},
                                                     {"R", "L"},
                                                     {"l", "r"},
                                                     {"r", "l"}});

constexpr bool IsLower(char c) { return c >= 'a' && c <= 'z'; }
constexpr bool IsUpper(char c) { return c >= 'A' && c <= 'Z'; }
constexpr bool IsLetter(char c) { return IsLower(c) || IsUpper(c); }
constexpr bool IsSeparator(char c) { return c == '_' || c == '.' || c == '-' || c == ' '; }

// The word for a side at a place of a name; null: there is none.
const SideWord* SideWordAt(std::string_view name, std::size_t at) noexcept {
  for (const SideWord& word : kSideWords) {
    if (name.substr(at, word.here.size()) != word.here) continue;
    const std::size_t end = at + word.here.size();
    const char before = at > 0 ? name[at - 1] : '_', after = end < name.size() ? name[end] : '_';
    if (word.here.size() == 1) {
      const bool alone = IsSeparator(before) && IsSeparator(after) && name.size() > 1;
      return alone ? &word : nullptr;
    }
    // In camel case a capital letter begins a word.
    const bool begins = (IsUpper(word.here[0]) && IsLower(word.here[1])) || !IsLetter(before);
    const bool ends = IsUpper(word.here[1]) ? !IsLetter(after) : !IsLower(after);
    return begins && ends ? &word : nullptr;
  }
  return nullptr;
}

// Calls `sink` with the parts of a name whose sides are exchanged, in order.
template <typename Sink>
void ForMirrored(std::string_view name, Sink sink) noexcept {
  std::size_t from = 0;
  for (std::size_t at = 0; at < name.size();) {
    const SideWord* const word = SideWordAt(name, at);
    if (word == nullptr) {
      ++at;
      continue;
    }
    sink(name.substr(from, at - from));
    sink(word->there);
    at += word->here.size();
    from = at;
  }
  sink(name.substr(from));
}

// An encoded expression: its name and where that field begins and ends, begin == end: it has none;
// and where the bytes of its value are, 0: nowhere, it is 0. `whole`: it has no other field.
struct Encoded {
  std::size_t name_begin = 0, name_end = 0, value_at = 0;
  std::string_view name;
  bool whole = false;
};
Encoded ReadExpression(std::span<const std::byte> expression) noexcept {
  Encoded read;
  std::size_t at = 0, key = 0, size = 0;
  while (at < expression.size()) {
    const std::size_t begin = at;
    if (!ReadVarint(expression, at, key)) return read;
    if (key == kValue && expression.size() - at >= sizeof(float)) {
      read.value_at = at;
      at += sizeof(float);
    } else if (key == kName && ReadVarint(expression, at, size) && size <= expression.size() - at) {
      read.name = {reinterpret_cast<const char*>(expression.data()) + at, size};
      at += size;
      read.name_begin = begin;
      read.name_end = at;
    } else {
      return read;
    }
  }
  read.whole = true;
  return read;
}

float ValueOf(std::span<const std::byte> expression, const Encoded& read) noexcept {
  float value = 0;
  if (read.value_at > 0) std::memcpy(&value, &expression[read.value_at], sizeof value);
  return value;
}

bool ClosesAnEye(std::string_view name) noexcept {
  constexpr std::string_view kBlink = "blink";
  const auto same = [](char c, char lower) {
    return c == lower || (IsUpper(c) && c - 'A' + 'a' == lower);
  };
  return !std::ranges::search(name, kBlink, same).empty();
}

void WriteMirrored(std::span<const std::byte> expression, WireWriter& out) noexcept {
  const Encoded read = ReadExpression(expression);
  std::size_t name = 0;
  ForMirrored(read.name, [&name](std::string_view part) { name += part.size(); });
  const std::size_t others = expression.size() - (read.name_end - read.name_begin);
  out.Varint(kExpressionsTag);
  if (read.name_begin == read.name_end) {
    out.Varint(expression.size());
    return out.Bytes(expression);
  }
  out.Varint(others + 1 + VarintSize(name) + name);
  out.Bytes(expression.first(read.name_begin));
  out.Varint(kName);
  out.Varint(name);
  ForMirrored(read.name,
              [&out](std::string_view part) { out.Bytes(std::as_bytes(std::span(part))); });
  out.Bytes(expression.subspan(read.name_end));
}

}  // namespace

std::size_t MirrorFace(std::span<const std::byte> face, std::span<std::byte> to) noexcept {
  WireWriter out(to);
  FieldReader fields(face);
  std::size_t done = 0;
  while (fields.Next() && fields.tag == kExpressionsTag) {
    WriteMirrored(face.subspan(fields.content, fields.size), out);
    done = fields.content + fields.size;
  }
  out.Bytes(face.subspan(done));
  return out.fits() ? out.size() : 0;
}

std::span<const std::byte> PassedOn(std::span<const std::byte> face) noexcept {
  FieldReader fields(face);
  while (fields.Next()) {
    if (fields.tag == kThruTag) return face.subspan(fields.begin);
  }
  return {};
}

void ScaleFace(std::span<std::byte> face, float by) noexcept {
  FieldReader fields(face);
  while (fields.Next() && fields.tag == kExpressionsTag) {
    const auto expression = face.subspan(fields.content, fields.size);
    const Encoded read = ReadExpression(expression);
    const float value = by * ValueOf(expression, read);
    if (read.value_at > 0) std::memcpy(&expression[read.value_at], &value, sizeof value);
    if (!read.whole) return;
  }
}

std::size_t RestFace(std::span<const std::byte> face, float by, float closed,
                     std::span<std::byte> to) noexcept {
  WireWriter out(to);
  FieldReader fields(face);
  while (fields.Next() && fields.tag == kExpressionsTag) {
    const auto expression = face.subspan(fields.content, fields.size);
    const Encoded read = ReadExpression(expression);
    if (!read.whole) return 0;
    const float value = by * ValueOf(expression, read);
    Write({read.name, ClosesAnEye(read.name) ? std::max(value, closed) : value}, out);
  }
  out.Bytes(PassedOn(face));
  return out.fits() ? out.size() : 0;
}

std::size_t EncodeFace(const Face& face, std::span<std::byte> to) noexcept {
  WireWriter out(to);
  for (const auto& expression : face.expressions) Write(expression, out);
  for (const auto bytes : face.thru) {
    out.Varint(kThruTag);
    out.Varint(bytes.size());
    out.Bytes(bytes);
  }
  return out.fits() ? out.size() : 0;
}

}  // namespace styled::source
