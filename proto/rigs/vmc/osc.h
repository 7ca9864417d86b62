#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "model/base/realtime.h"

// Open Sound Control 1.0 (opensoundcontrol.org/spec-1_0), as far as VMC requires it: big-endian
// messages and nested bundles, read in place. Timetags are ignored: the clocks of two machines do
// not agree, and a bundle with a future time must not wait. Pure functions; any thread; nothing
// here allocates, blocks or throws. Pinned by tests/unit/vmc/osc_test.cpp, against liblo and
// oscpack by tests/unit/vmc/witness_test.cpp; fuzzed by tests/fuzz/vmc.
namespace styled::vmc::osc {

inline constexpr std::size_t kMaxDatagramSize = 65507;  // what UDP over IPv4 carries
inline constexpr int kMaxDepth = 8;                     // nested bundles

// The error of a datagram. One invalid part refuses the whole datagram.
enum class [[nodiscard]] Result : std::uint8_t {
  kOk,
  kTooShort,      // no bytes, or a bundle of fewer than 16
  kTooLong,       // more than kMaxDatagramSize
  kBadSize,       // not a multiple of 4
  kBadAddress,    // a message does not begin with '/', or its address is not terminated by zeros
  kBadTypes,      // type tags do not begin with ',', lack their zeros, or include an unknown one
  kBadArguments,  // arguments exceed their message, or are not padded with zeros
  kSurplus,       // bytes after the last argument
  kBadElement,    // a bundle's element is empty, or exceeds the bundle
  kTooDeep,       // more than kMaxDepth nested bundles
  kCount          // the number of results
};
// A word for counters and messages: "ok", "too_short", ...
std::string_view Name(Result result) noexcept;

// A message in its datagram: views that are valid as long as those bytes are.
struct Message {
  std::span<const std::byte> bytes;  // the whole message, for passing it on unchanged
  std::string_view address;
  std::string_view types;  // one character per argument, without the ','; "" if there are none
  std::span<const std::byte> arguments;
};

// Iterates over the messages of a datagram and its bundles, in the order of the wire.
class Reader {
 public:
  enum class Step { kMessage, kEnd, kBroken };

  Reader() noexcept = default;
  explicit Reader(std::span<const std::byte> datagram) noexcept;

  // Writes `message` on kMessage only. After kBroken, result() gives the reason, and every further
  // call returns kBroken.
  STYLED_REALTIME Step Next(Message& message) noexcept;
  Result result() const noexcept { return result_; }

 private:
  Step EnterElement(std::span<const std::byte> element, Message& message) noexcept;
  Step Fail(Result why) noexcept;

  Result result_ = Result::kOk;
  bool started_ = false;
  int depth_ = 0;  // open bundles
  // Unread bytes of each open bundle; [0] is the datagram.
  std::array<std::span<const std::byte>, kMaxDepth + 1> rest_;
};

// Checks the whole datagram: kOk if a Reader will not return kBroken.
STYLED_REALTIME Result Check(std::span<const std::byte> datagram) noexcept;

// Reads a message's arguments from the front. Each call writes its value and advances only if the
// next argument has that type.
class Arguments {
 public:
  explicit Arguments(const Message& message) noexcept
      : types_(message.types), bytes_(message.arguments) {}

  STYLED_REALTIME bool Int(std::int32_t& value) noexcept;       // 'i'
  STYLED_REALTIME bool Float(float& value) noexcept;            // 'f'; any bits, including NaN
  STYLED_REALTIME bool Text(std::string_view& value) noexcept;  // 's'
  bool AtEnd() const noexcept { return types_.empty(); }

 private:
  bool ReadWord(char type, std::uint32_t& word) noexcept;

  std::string_view types_;
  std::span<const std::byte> bytes_;
};

// Writes one datagram to the front of `out`: a message, or bundles of them. If a part does not fit,
// or more than kMaxDepth bundles are nested, ok() becomes false for good and the content of `out`
// is invalid.
class Writer {
 public:
  explicit Writer(std::span<std::byte> out) noexcept : out_(out) {}

  STYLED_REALTIME void BeginBundle() noexcept;  // timetag: immediately
  STYLED_REALTIME void EndBundle() noexcept;
  // `types` is given without the ','. Call the argument functions in that order, once for each
  // type. Texts end at their first NUL.
  STYLED_REALTIME void BeginMessage(std::string_view address, std::string_view types) noexcept;
  STYLED_REALTIME void Int(std::int32_t value) noexcept;
  STYLED_REALTIME void Float(float value) noexcept;
  STYLED_REALTIME void Text(std::string_view value) noexcept;
  STYLED_REALTIME void EndMessage() noexcept;
  // Writes a whole message as it was received.
  STYLED_REALTIME void Raw(std::span<const std::byte> message) noexcept;

  std::size_t size() const noexcept { return size_; }
  bool ok() const noexcept { return ok_; }

 private:
  void BeginElement() noexcept;
  void EndElement() noexcept;
  void Word(std::uint32_t value) noexcept;
  void Padded(char first, std::string_view text) noexcept;
  std::byte* Grow(std::size_t size) noexcept;

  std::span<std::byte> out_;
  std::size_t size_ = 0;
  bool ok_ = true;
  int depth_ = 0;                                   // open elements: bundles and a message
  std::array<std::size_t, kMaxDepth + 1> begin_{};  // where each begins, without its size field
};

}  // namespace styled::vmc::osc
