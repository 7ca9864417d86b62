#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "model/base/realtime.h"

namespace styled::rokoko {

// Reads one JSON text (RFC 8259) from front to back, value by value, without allocating: the caller
// asks for what it knows and skips the rest, which is checked all the same. After the first mistake
// every call fails and error() says why. Strict: UTF-8 must be valid, escaped surrogates in pairs,
// numbers must fit a double. The text must outlive the reader. One thread.
// Pinned against nlohmann::json by tests/unit/rokoko/json_reader_test.cpp.
class JsonReader {
 public:
  static constexpr int kMaxDepth = 32;  // of objects and arrays in one another

  enum class Error : std::uint8_t {
    kNone,
    kSyntax,   // not JSON, or not UTF-8, or a number beyond a double
    kTooDeep,  // more than kMaxDepth
    kOther     // well so far, but the next value is of another type than what was asked for
  };
  enum class Type : std::uint8_t {
    kObject,
    kArray,
    kString,
    kNumber,
    kTrue,
    kFalse,
    kNull,
    kNothing
  };

  explicit JsonReader(std::string_view text) noexcept : text_(text) {}

  Error error() const noexcept { return error_; }
  bool ok() const noexcept { return error_ == Error::kNone; }

  // What the next value is; kNothing where there is none.
  STYLED_REALTIME Type Peek() noexcept;

  // Objects: BeginObject, then per member NextMember and exactly one of the functions that take a
  // value; NextMember is false after the last member. `key` is unescaped (cut at 64 bytes where it
  // holds escapes) and valid until the next call.
  STYLED_REALTIME bool BeginObject() noexcept;
  STYLED_REALTIME bool NextMember(std::string_view& key) noexcept;
  // Arrays: the same, element by element.
  STYLED_REALTIME bool BeginArray() noexcept;
  STYLED_REALTIME bool NextElement() noexcept;

  STYLED_REALTIME bool ReadNumber(double& value) noexcept;
  STYLED_REALTIME bool ReadBool(bool& value) noexcept;
  // As many whole characters as fit; `size` is set to their bytes.
  STYLED_REALTIME bool ReadString(std::span<char> out, std::size_t& size) noexcept;
  // Any value.
  STYLED_REALTIME bool Skip() noexcept;
  // Whether nothing but space is left. To be asked after the one value of the text.
  STYLED_REALTIME bool AtEnd() noexcept;

 private:
  // Where the characters of a string go; those that do not fit are dropped.
  struct Sink {
    std::span<char> out;
    std::size_t size = 0;
    bool full = false;
    void Put(std::string_view character) noexcept;
  };

  bool Fail(Error error) noexcept;
  void SkipSpace() noexcept;
  bool Take(char expected) noexcept;
  bool TakeWord(std::string_view word) noexcept;
  bool Begin(char open) noexcept;
  bool Next(char close) noexcept;
  bool TakeString(Sink& sink, std::string_view* raw) noexcept;
  bool TakeEscape(Sink& sink) noexcept;
  bool TakeHex(std::uint32_t& code) noexcept;
  bool TakeMultibyte(Sink& sink) noexcept;
  bool TakeNumber(double& value) noexcept;
  std::size_t TakeDigits() noexcept;
  bool SkipScalar() noexcept;

  std::string_view text_;
  std::size_t at_ = 0;
  int depth_ = 0;
  std::array<bool, kMaxDepth> fresh_{};  // per level: no member taken yet
  std::array<char, 64> key_{};
  Error error_ = Error::kNone;
};

}  // namespace styled::rokoko
