#pragma once

#include <simdjson.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string_view>

#include "model/base/realtime.h"

namespace styled::rokoko {

// Reads JSON texts (RFC 8259) of a bounded size and depth with simdjson's on-demand parser. That
// parser does not check values that are never read, so each value must be read by exactly one of
// the functions below: then a text is either correct as a whole or refused. Strict: UTF-8 must be
// valid, escaped surrogates must come in pairs, numbers must fit a double, exponents have at most
// 19 digits. After the first error every call fails and error() gives the reason; of several errors
// in a text any one may be reported. The constructor allocates (7 bytes per byte of text), the
// other functions do not. One thread. Pinned against nlohmann::json by
// tests/unit/rokoko/json_reader_test.cpp.
class JsonReader {
 public:
  using Value = simdjson::ondemand::value;
  using Type = simdjson::ondemand::json_type;
  static constexpr int kMaxDepth = 32;  // nested objects and arrays

  enum class Error : std::uint8_t {
    kNone,
    kSyntax,   // not JSON, not UTF-8, or a number beyond a double
    kTooDeep,  // more than kMaxDepth
    kOther     // the value's type differs from what the call expects
  };

  explicit JsonReader(std::size_t max_bytes);

  // Write the next text here; max_bytes long.
  std::span<char> buffer() noexcept { return {text_.get(), max_bytes_}; }

  // Reads the first `size` bytes of the buffer, which must be one object, like Members.
  template <typename Read>
  STYLED_REALTIME bool Text(std::size_t size, const Read& read) noexcept;

  // Calls `read(std::string_view key, Value&)` per member; `key` is unescaped and valid until the
  // next text.
  template <typename Read>
  STYLED_REALTIME bool Members(Value& value, const Read& read) noexcept;
  // Calls `read(Value&)` per element.
  template <typename Read>
  STYLED_REALTIME bool Elements(Value& value, const Read& read) noexcept;
  STYLED_REALTIME bool Number(Value& value, double& number) noexcept {
    return (ok() && value.get_double().get(number) == simdjson::SUCCESS) ||
           Mismatch(value, Type::number);
  }
  STYLED_REALTIME bool Bool(Value& value, bool& flag) noexcept;
  // Copies as many whole characters as fit and sets `size` to their bytes.
  STYLED_REALTIME bool String(Value& value, std::span<char> out, std::size_t& size) noexcept;
  // Checks any value and drops it.
  STYLED_REALTIME bool Skip(Value& value) noexcept;

  // Decides by the value's first character, without reading the value.
  static bool Is(Value& value, Type type) noexcept {
    Type found{};
    return value.type().get(found) == simdjson::SUCCESS && found == type;
  }
  Error error() const noexcept { return error_; }
  bool ok() const noexcept { return error_ == Error::kNone; }

 private:
  bool Fail(Error error) noexcept;
  // Fails with the reason why `value` is not a correct value of `type`.
  bool Mismatch(Value& value, Type type) noexcept;
  bool Open(std::size_t size, simdjson::ondemand::document& document,
            simdjson::ondemand::object& root) noexcept;
  bool Close(simdjson::ondemand::document& document) noexcept;
  template <typename Read>
  bool EachMember(simdjson::ondemand::object& object, const Read& read) noexcept;
  bool Enter() noexcept { return depth_++ < kMaxDepth || Fail(Error::kTooDeep); }
  static bool HasHalfPair(std::string_view text) noexcept;

  std::size_t max_bytes_;
  std::unique_ptr<char[]> text_;
  simdjson::ondemand::parser parser_;
  int depth_ = 0;
  Error error_ = Error::kNone;
};

template <typename Read>
bool JsonReader::Text(std::size_t size, const Read& read) noexcept {
  simdjson::ondemand::document document;
  simdjson::ondemand::object root;
  return Open(size, document, root) && EachMember(root, read) && Close(document);
}

template <typename Read>
bool JsonReader::Members(Value& value, const Read& read) noexcept {
  simdjson::ondemand::object object;
  if (!ok() || value.get_object().get(object) != simdjson::SUCCESS) {
    return Mismatch(value, Type::object);
  }
  return Enter() && EachMember(object, read);
}

template <typename Read>
bool JsonReader::EachMember(simdjson::ondemand::object& object, const Read& read) noexcept {
  for (auto field : object) {
    std::string_view key;
    Value value;
    if (field.unescaped_key().get(key) != simdjson::SUCCESS || HasHalfPair(key) ||
        field.value().get(value) != simdjson::SUCCESS) {
      return Fail(Error::kSyntax);
    }
    if (!read(key, value)) return false;
  }
  --depth_;
  return true;
}

template <typename Read>
bool JsonReader::Elements(Value& value, const Read& read) noexcept {
  simdjson::ondemand::array array;
  if (!ok() || value.get_array().get(array) != simdjson::SUCCESS) {
    return Mismatch(value, Type::array);
  }
  if (!Enter()) return false;
  for (auto element : array) {
    Value inner;
    if (element.get(inner) != simdjson::SUCCESS) return Fail(Error::kSyntax);
    if (!read(inner)) return false;
  }
  --depth_;
  return true;
}

// simdjson decodes half of an escaped surrogate pair as if it were a character: ED A0 80 to ED BF
// BF, which is not UTF-8. It has checked everything else in `text`.
inline bool JsonReader::HasHalfPair(std::string_view text) noexcept {
  for (std::size_t i = 0; i + 1 < text.size(); ++i) {
    if (text[i] == '\xED' && static_cast<unsigned char>(text[i + 1]) >= 0xA0) return true;
  }
  return false;
}

}  // namespace styled::rokoko
