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

// The name of an encoded expression and where its field begins and ends; begin == end: it has none.
struct NameField {
  std::size_t begin = 0, end = 0;
  std::string_view name;
};
NameField FindName(std::span<const std::byte> expression) noexcept {
  std::size_t at = 0, key = 0, size = 0;
  while (at < expression.size()) {
    const std::size_t begin = at;
    if (!ReadVarint(expression, at, key)) break;
    if (key == kValue && expression.size() - at >= sizeof(float)) {
      at += sizeof(float);
      continue;
    }
    if (key != kName || !ReadVarint(expression, at, size) || size > expression.size() - at) break;
    return {begin, at + size, {reinterpret_cast<const char*>(expression.data()) + at, size}};
  }
  return {};
}

void WriteMirrored(std::span<const std::byte> expression, WireWriter& out) noexcept {
  const NameField field = FindName(expression);
  std::size_t name = 0;
  ForMirrored(field.name, [&name](std::string_view part) { name += part.size(); });
  const std::size_t others = expression.size() - (field.end - field.begin);
  out.Varint(kExpressionsTag);
  if (field.begin == field.end) {
    out.Varint(expression.size());
    return out.Bytes(expression);
  }
  out.Varint(others + 1 + VarintSize(name) + name);
  out.Bytes(expression.first(field.begin));
  out.Varint(kName);
  out.Varint(name);
  ForMirrored(field.name,
              [&out](std::string_view part) { out.Bytes(std::as_bytes(std::span(part))); });
  out.Bytes(expression.subspan(field.end));
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
    std::size_t at = 0, key = 0, name = 0;
    while (at < expression.size() && ReadVarint(expression, at, key)) {
      if (key == kName) {
        if (!ReadVarint(expression, at, name) || name > expression.size() - at) return;
        at += name;
      } else if (key == kValue && expression.size() - at >= sizeof(float)) {
        float value = 0;
        std::memcpy(&value, &expression[at], sizeof value);
        value *= by;
        std::memcpy(&expression[at], &value, sizeof value);
        at += sizeof value;
      } else {
        return;
      }
    }
  }
}

namespace {

char Lower(char c) noexcept { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }

bool ClosesAnEye(std::string_view name) noexcept {
  constexpr std::string_view kBlink = "blink";
  return std::ranges::search(name, kBlink, [](char a, char b) { return Lower(a) == b; }).begin() !=
         name.end();
}

// An expression's message. Returns false for fields that it does not have.
bool ReadExpression(std::span<const std::byte> bytes, Face::Expression& expression) noexcept {
  expression = {};
  std::size_t at = 0, key = 0, size = 0;
  while (at < bytes.size()) {
    if (!ReadVarint(bytes, at, key)) return false;
    if (key == kName) {
      if (!ReadVarint(bytes, at, size) || size > bytes.size() - at) return false;
      expression.name = {reinterpret_cast<const char*>(bytes.data()) + at, size};
      at += size;
    } else if (key == kValue && bytes.size() - at >= sizeof(float)) {
      std::memcpy(&expression.value, bytes.data() + at, sizeof(float));
      at += sizeof(float);
    } else {
      return false;
    }
  }
  return true;
}

}  // namespace

std::size_t RestFace(std::span<const std::byte> face, float by, float closed,
                     std::span<std::byte> to) noexcept {
  WireWriter out(to);
  FieldReader fields(face);
  while (fields.Next() && fields.tag == kExpressionsTag) {
    Face::Expression expression;
    if (!ReadExpression(face.subspan(fields.content, fields.size), expression)) return 0;
    expression.value *= by;
    if (ClosesAnEye(expression.name)) expression.value = std::max(expression.value, closed);
    Write(expression, out);
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
