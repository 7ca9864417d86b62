#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <span>

// Interprets a fuzzer's bytes as a script of the senders' actions. After the last byte every value
// is 0.
namespace styled::fuzz {

enum class Action : std::uint8_t {
  kWait,      // time passes
  kBody,      // a sender sends its body, possibly an invalid one
  kFrame,     // ... a frame
  kFrames,    // ... several valid frames
  kDamaged,   // ... a datagram damaged in transit
  kSession,   // ... starts a new session, or uses another sender's
  kSequence,  // ... continues with another sequence number
  kMachine,   // ... moves to another machine
  kClock,     // ... has its clock set
  kControl,   // an operator changes the style of a performer other than the victim
  kSubscribe,
  kCount
};

class Script {
 public:
  explicit Script(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}

  bool done() const { return bytes_.empty(); }
  std::uint8_t Byte() {
    if (bytes_.empty()) return 0;
    const std::uint8_t value = bytes_.front();
    bytes_ = bytes_.subspan(1);
    return value;
  }
  std::size_t Below(std::size_t n) { return Byte() % n; }
  std::uint64_t Word() {
    std::uint64_t value = 0;
    for (int i = 0; i < 8; ++i) value = (value << 8U) | Byte();
    return value;
  }
  // From 1 to 2^64, with the powers of two equally likely.
  std::uint64_t Magnitude() {
    const std::uint8_t power = Byte() % 64;
    return (1ULL << power) + (static_cast<std::uint64_t>(Byte()) << power) / 256;
  }
  // An invalid or extreme number.
  float Strange() {
    switch (Below(8)) {
      case 0:
        return std::numeric_limits<float>::quiet_NaN();
      case 1:
        return std::numeric_limits<float>::infinity();
      case 2:
        return -std::numeric_limits<float>::infinity();
      case 3:
        return 1e30F;
      case 4:
        return -1e30F;
      case 5:
        return std::numeric_limits<float>::denorm_min();
      case 6:
        return 0;
      default: {
        const auto bits = static_cast<std::uint32_t>(Word());
        float value = 0;
        std::memcpy(&value, &bits, sizeof value);
        return value;
      }
    }
  }

 private:
  std::span<const std::uint8_t> bytes_;
};

}  // namespace styled::fuzz
