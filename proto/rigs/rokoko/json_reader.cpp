#include "proto/rigs/rokoko/json_reader.h"

#include <algorithm>
#include <charconv>
#include <cmath>

namespace styled::rokoko {
namespace {

bool IsDigit(char c) noexcept { return c >= '0' && c <= '9'; }

// A code point as UTF-8; how many bytes.
std::size_t EncodeUtf8(std::uint32_t code, std::array<char, 4>& out) noexcept {
  const auto tail = [&](int shift) { return static_cast<char>(0x80 | ((code >> shift) & 0x3F)); };
  if (code < 0x80) {
    out = {static_cast<char>(code)};
    return 1;
  }
  if (code < 0x800) {
    out = {static_cast<char>(0xC0 | (code >> 6)), tail(0)};
    return 2;
  }
  if (code < 0x10000) {
    out = {static_cast<char>(0xE0 | (code >> 12)), tail(6), tail(0)};
    return 3;
  }
  out = {static_cast<char>(0xF0 | (code >> 18)), tail(12), tail(6), tail(0)};
  return 4;
}

// Whether a number that from_chars found out of range is too small, and so 0, rather than too
// large: by the decimal place of its first digit that counts. `text` is a JSON number.
bool IsTiny(std::string_view text) noexcept {
  const std::size_t e = std::min(text.find_first_of("eE"), text.size());
  const std::string_view mantissa = text.substr(0, e);
  const std::size_t first = mantissa.find_first_of("123456789");
  if (first == std::string_view::npos) return true;
  const std::size_t point = std::min(mantissa.find('.'), mantissa.size());
  auto place = static_cast<double>(point) - static_cast<double>(first);
  if (e < text.size()) {
    std::string_view exponent = text.substr(e + 1);
    if (exponent.starts_with('+')) exponent.remove_prefix(1);
    const bool negative = exponent.starts_with('-');
    int value = 0;
    const auto [end, error] =
        std::from_chars(exponent.data(), exponent.data() + exponent.size(), value);
    if (error == std::errc::result_out_of_range) return negative;
    place += value;
  }
  return place < 0;
}

}  // namespace

void JsonReader::Sink::Put(std::string_view character) noexcept {
  full = full || size + character.size() > out.size();
  if (full) return;
  std::copy(character.begin(), character.end(), out.begin() + static_cast<std::ptrdiff_t>(size));
  size += character.size();
}

bool JsonReader::Fail(Error error) noexcept {
  if (ok()) error_ = error;
  return false;
}

void JsonReader::SkipSpace() noexcept {
  while (at_ < text_.size() &&
         (text_[at_] == ' ' || text_[at_] == '\n' || text_[at_] == '\r' || text_[at_] == '\t')) {
    ++at_;
  }
}

bool JsonReader::Take(char expected) noexcept {
  if (at_ >= text_.size() || text_[at_] != expected) return Fail(Error::kSyntax);
  ++at_;
  return true;
}

bool JsonReader::TakeWord(std::string_view word) noexcept {
  if (text_.substr(at_, word.size()) != word) return Fail(Error::kSyntax);
  at_ += word.size();
  return true;
}

JsonReader::Type JsonReader::Peek() noexcept {
  if (!ok()) return Type::kNothing;
  SkipSpace();
  if (at_ >= text_.size()) return Type::kNothing;
  switch (text_[at_]) {
    case '{':
      return Type::kObject;
    case '[':
      return Type::kArray;
    case '"':
      return Type::kString;
    case 't':
      return Type::kTrue;
    case 'f':
      return Type::kFalse;
    case 'n':
      return Type::kNull;
    default:
      return text_[at_] == '-' || IsDigit(text_[at_]) ? Type::kNumber : Type::kNothing;
  }
}

bool JsonReader::Begin(char open) noexcept {
  const Type type = Peek();
  if (type == Type::kNothing) return Fail(Error::kSyntax);
  if (type != (open == '{' ? Type::kObject : Type::kArray)) return Fail(Error::kOther);
  if (depth_ == kMaxDepth) return Fail(Error::kTooDeep);
  ++at_;
  fresh_[static_cast<std::size_t>(depth_++)] = true;
  return true;
}

// Whether another member or element comes; takes the comma before it, or the closing bracket.
bool JsonReader::Next(char close) noexcept {
  if (!ok()) return false;
  SkipSpace();
  bool& fresh = fresh_[static_cast<std::size_t>(depth_ - 1)];
  if (at_ < text_.size() && text_[at_] == close) {
    ++at_;
    --depth_;
    return false;
  }
  if (!fresh && !Take(',')) return false;
  fresh = false;
  return true;
}

bool JsonReader::BeginObject() noexcept { return Begin('{'); }

bool JsonReader::NextMember(std::string_view& key) noexcept {
  if (!Next('}')) return false;
  SkipSpace();
  Sink sink{key_};
  if (!TakeString(sink, &key)) return false;
  SkipSpace();
  return Take(':');
}

bool JsonReader::BeginArray() noexcept { return Begin('['); }

bool JsonReader::NextElement() noexcept { return Next(']'); }

bool JsonReader::ReadNumber(double& value) noexcept {
  const Type type = Peek();
  if (type == Type::kNothing) return Fail(Error::kSyntax);
  if (type != Type::kNumber) return Fail(Error::kOther);
  return TakeNumber(value);
}

bool JsonReader::ReadBool(bool& value) noexcept {
  const Type type = Peek();
  if (type == Type::kNothing) return Fail(Error::kSyntax);
  if (type != Type::kTrue && type != Type::kFalse) return Fail(Error::kOther);
  value = type == Type::kTrue;
  return TakeWord(value ? "true" : "false");
}

bool JsonReader::ReadString(std::span<char> out, std::size_t& size) noexcept {
  const Type type = Peek();
  if (type == Type::kNothing) return Fail(Error::kSyntax);
  if (type != Type::kString) return Fail(Error::kOther);
  Sink sink{out};
  if (!TakeString(sink, nullptr)) return false;
  size = sink.size;
  return true;
}

// `raw`, where asked for, is the string itself: in the text where it has no escapes, else in the
// sink.
bool JsonReader::TakeString(Sink& sink, std::string_view* raw) noexcept {
  if (!Take('"')) return false;
  const std::size_t begin = at_;
  bool escaped = false;
  while (at_ < text_.size()) {
    const char c = text_[at_];
    if (c == '"') {
      if (raw != nullptr) {
        *raw = escaped ? std::string_view(sink.out.data(), sink.size)
                       : text_.substr(begin, at_ - begin);
      }
      ++at_;
      return true;
    }
    if (c == '\\') {
      escaped = true;
      if (!TakeEscape(sink)) return false;
    } else if ((static_cast<unsigned char>(c) & 0x80U) != 0) {
      if (!TakeMultibyte(sink)) return false;
    } else {
      if (static_cast<unsigned char>(c) < 0x20) break;
      sink.Put({&c, 1});
      ++at_;
    }
  }
  return Fail(Error::kSyntax);
}

bool JsonReader::TakeHex(std::uint32_t& code) noexcept {
  code = 0;
  for (int i = 0; i < 4; ++i, ++at_) {
    const char c = at_ < text_.size() ? text_[at_] : '\0';
    std::uint32_t digit = 0;
    if (IsDigit(c)) {
      digit = static_cast<std::uint32_t>(c - '0');
    } else if (c >= 'a' && c <= 'f') {
      digit = static_cast<std::uint32_t>(c - 'a' + 10);
    } else if (c >= 'A' && c <= 'F') {
      digit = static_cast<std::uint32_t>(c - 'A' + 10);
    } else {
      return Fail(Error::kSyntax);
    }
    code = code * 16 + digit;
  }
  return true;
}

bool JsonReader::TakeEscape(Sink& sink) noexcept {
  ++at_;  // the backslash
  const char c = at_ < text_.size() ? text_[at_] : '\0';
  ++at_;
  if (c != 'u') {
    constexpr std::string_view kLetters = "\"\\/bfnrt", kMeant = "\"\\/\b\f\n\r\t";
    const std::size_t which = c == '\0' ? std::string_view::npos : kLetters.find(c);
    if (which == std::string_view::npos) return Fail(Error::kSyntax);
    sink.Put(kMeant.substr(which, 1));
    return true;
  }
  std::uint32_t code = 0;
  if (!TakeHex(code)) return false;
  if (code >= 0xDC00 && code < 0xE000) return Fail(Error::kSyntax);
  if (code >= 0xD800 && code < 0xDC00) {
    std::uint32_t low = 0;
    if (!TakeWord("\\u") || !TakeHex(low)) return false;
    if (low < 0xDC00 || low >= 0xE000) return Fail(Error::kSyntax);
    code = 0x10000 + ((code - 0xD800) << 10) + (low - 0xDC00);
  }
  std::array<char, 4> bytes{};
  const std::size_t size = EncodeUtf8(code, bytes);
  sink.Put({bytes.data(), size});
  return true;
}

// One character of two to four bytes: neither overlong, nor a surrogate, nor beyond U+10FFFF.
bool JsonReader::TakeMultibyte(Sink& sink) noexcept {
  const auto lead = static_cast<unsigned char>(text_[at_]);
  const std::size_t size = lead >= 0xF0 ? 4 : lead >= 0xE0 ? 3 : 2;
  if (lead < 0xC2 || lead > 0xF4 || text_.size() - at_ < size) return Fail(Error::kSyntax);
  std::uint32_t code = lead & (0x7FU >> size);
  for (std::size_t i = 1; i < size; ++i) {
    const auto tail = static_cast<unsigned char>(text_[at_ + i]);
    if ((tail & 0xC0U) != 0x80) return Fail(Error::kSyntax);
    code = (code << 6) | (tail & 0x3FU);
  }
  const std::uint32_t smallest = size == 4 ? 0x10000 : size == 3 ? 0x800 : 0x80;
  if (code < smallest || code > 0x10FFFF || (code >= 0xD800 && code < 0xE000)) {
    return Fail(Error::kSyntax);
  }
  sink.Put(text_.substr(at_, size));
  at_ += size;
  return true;
}

std::size_t JsonReader::TakeDigits() noexcept {
  const std::size_t begin = at_;
  while (at_ < text_.size() && IsDigit(text_[at_])) ++at_;
  return at_ - begin;
}

// from_chars knows no JSON: the grammar first.
bool JsonReader::TakeNumber(double& value) noexcept {
  const std::size_t begin = at_;
  if (text_[at_] == '-') ++at_;
  const std::size_t whole = at_;
  const std::size_t digits = TakeDigits();
  if (digits == 0 || (digits > 1 && text_[whole] == '0')) return Fail(Error::kSyntax);
  if (at_ < text_.size() && text_[at_] == '.') {
    ++at_;
    if (TakeDigits() == 0) return Fail(Error::kSyntax);
  }
  if (at_ < text_.size() && (text_[at_] == 'e' || text_[at_] == 'E')) {
    ++at_;
    if (at_ < text_.size() && (text_[at_] == '+' || text_[at_] == '-')) ++at_;
    if (TakeDigits() == 0) return Fail(Error::kSyntax);
  }
  const std::string_view number = text_.substr(begin, at_ - begin);
  const auto [end, error] = std::from_chars(number.data(), number.data() + number.size(), value);
  if (error == std::errc::result_out_of_range) {
    const bool negative = number.starts_with('-');
    if (!IsTiny(number.substr(negative ? 1 : 0))) return Fail(Error::kSyntax);
    value = negative ? -0.0 : 0.0;
  }
  return true;
}

bool JsonReader::SkipScalar() noexcept {
  Sink nowhere;
  double unused = 0;
  switch (Peek()) {
    case Type::kString:
      return TakeString(nowhere, nullptr);
    case Type::kNumber:
      return TakeNumber(unused);
    case Type::kTrue:
      return TakeWord("true");
    case Type::kFalse:
      return TakeWord("false");
    case Type::kNull:
      return TakeWord("null");
    default:
      return Fail(Error::kSyntax);
  }
}

bool JsonReader::Skip() noexcept {
  const int outside = depth_;
  std::array<bool, kMaxDepth + 1> is_object{};  // by the depth outside of it
  std::string_view key;
  do {
    const Type type = Peek();
    is_object[static_cast<std::size_t>(depth_)] = type == Type::kObject;
    if (type == Type::kObject || type == Type::kArray) {
      if (!Begin(type == Type::kObject ? '{' : '[')) return false;
    } else if (!SkipScalar()) {
      return false;
    }
    // On to the next value, out of all that ends here.
    while (depth_ > outside) {
      if (is_object[static_cast<std::size_t>(depth_ - 1)] ? NextMember(key) : NextElement()) break;
      if (!ok()) return false;
    }
  } while (depth_ > outside);
  return true;
}

bool JsonReader::AtEnd() noexcept {
  if (!ok()) return false;
  SkipSpace();
  return at_ == text_.size() || Fail(Error::kSyntax);
}

}  // namespace styled::rokoko
