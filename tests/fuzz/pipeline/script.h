#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <span>

// A fuzzer's bytes as a script: what the senders do, one after the other. Where the bytes end every
// answer is 0.
namespace styled::fuzz {

enum class Action : std::uint8_t {
  kWait,      // time passes
  kBody,      // a sender sends its body, perhaps a strange one
  kFrame,     // ... a frame
  kFrames,    // ... some frames as they should be
  kDamaged,   // ... a datagram that was changed on the way
  kSession,   // ... begins another session, or takes another's
  kSequence,  // ... counts on from elsewhere
  kMachine,   // ... goes to another machine
  kClock,     // ... has its clock set
  kControl,   // an operator changes a style of somebody but the victim
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
  // From 1 to 2^64, evenly over the powers of two.
  std::uint64_t Magnitude() {
    const std::uint8_t power = Byte() % 64;
    return (1ULL << power) + (static_cast<std::uint64_t>(Byte()) << power) / 256;
  }
  // A number as it should not be.
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
