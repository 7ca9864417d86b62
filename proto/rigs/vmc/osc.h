#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "model/base/realtime.h"

// Open Sound Control 1.0 (opensoundcontrol.org/spec-1_0), as much of it as VMC needs: big-endian
// messages and nested bundles, read in place. Timetags are ignored: the clocks of two machines do
// not agree, and a bundle "of the future" must not wait. Pure functions; any thread; nothing here
// allocates, blocks or throws. Pinned by tests/unit/vmc/osc_test.cpp, against liblo and oscpack by
// tests/unit/vmc/witness_test.cpp; fuzzed by tests/fuzz/vmc.
namespace styled::vmc::osc {

inline constexpr std::size_t kMaxDatagramSize = 65507;  // what UDP over IPv4 carries
inline constexpr int kMaxDepth = 8;                     // bundles within one another

// What is wrong with a datagram. One broken part refuses the whole of it.
enum class [[nodiscard]] Result : std::uint8_t {
  kOk,
  kTooShort,      // no bytes, or a bundle of fewer than 16
  kTooLong,       // more than kMaxDatagramSize
  kBadSize,       // not a multiple of 4
  kBadAddress,    // a message not begun by '/', or an address without its zeros at the end
  kBadTypes,      // type tags not begun by ',', or without their zeros, or one unknown to us
  kBadArguments,  // arguments that leave their message, or are not padded with zeros
  kSurplus,       // bytes after the last argument
  kBadElement,    // a bundle's element of no size, or one that leaves the bundle
  kTooDeep,       // more than kMaxDepth bundles within one another
  kCount          // the number of results
};
// A word for counters and messages: "ok", "too_short", ...
std::string_view Name(Result result) noexcept;

// A message as it lies in its datagram: views, valid as long as those bytes are.
struct Message {
  std::span<const std::byte> bytes;  // all of it, to be passed on unchanged
  std::string_view address;
  std::string_view types;  // one character per argument, without the ','; "" where there are none
  std::span<const std::byte> arguments;
};

// Walks over the messages of a datagram, into its bundles, in the order of the wire.
class Reader {
 public:
  enum class Step { kMessage, kEnd, kBroken };

  Reader() noexcept = default;
  explicit Reader(std::span<const std::byte> datagram) noexcept;

  // `message` is written on kMessage. kBroken: result() says why; it stays so.
  STYLED_REALTIME Step Next(Message& message) noexcept;
  Result result() const noexcept { return result_; }

 private:
  Step TakeElement(std::span<const std::byte> element, Message& message) noexcept;
  Step Fail(Result why) noexcept;

  Result result_ = Result::kOk;
  bool started_ = false;
  int depth_ = 0;                                               // bundles open now
  std::array<std::span<const std::byte>, kMaxDepth + 1> rest_;  // of each; [0] is the datagram
};

// Walks over all of it: kOk where a Reader will not break.
STYLED_REALTIME Result Check(std::span<const std::byte> datagram) noexcept;

// Takes a message's arguments from the front. Each call writes its value and moves on only where
// the next argument is of that type.
class Arguments {
 public:
  explicit Arguments(const Message& message) noexcept
      : types_(message.types), bytes_(message.arguments) {}

  STYLED_REALTIME bool Int(std::int32_t& value) noexcept;       // 'i'
  STYLED_REALTIME bool Float(float& value) noexcept;            // 'f'; any bits, NaN among them
  STYLED_REALTIME bool Text(std::string_view& value) noexcept;  // 's'
  bool AtEnd() const noexcept { return types_.empty(); }

 private:
  bool Take(char type, std::uint32_t& word) noexcept;

  std::string_view types_;
  std::span<const std::byte> bytes_;
};

// Writes one datagram to the front of `out`: a message, or bundles of them. What does not fit, or
// more than kMaxDepth bundles, makes ok() false for good; what was written then is worth nothing.
class Writer {
 public:
  explicit Writer(std::span<std::byte> out) noexcept : out_(out) {}

  STYLED_REALTIME void BeginBundle() noexcept;  // timetag: immediately
  STYLED_REALTIME void EndBundle() noexcept;
  // `types` without the ','. As many calls of the argument functions follow, in that order; texts
  // end at their first NUL.
  STYLED_REALTIME void BeginMessage(std::string_view address, std::string_view types) noexcept;
  STYLED_REALTIME void Int(std::int32_t value) noexcept;
  STYLED_REALTIME void Float(float value) noexcept;
  STYLED_REALTIME void Text(std::string_view value) noexcept;
  STYLED_REALTIME void EndMessage() noexcept;
  // A whole message as it was received.
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
  int depth_ = 0;                                   // elements open now: bundles and a message
  std::array<std::size_t, kMaxDepth + 1> begin_{};  // where each begins, its size field excluded
};

}  // namespace styled::vmc::osc
