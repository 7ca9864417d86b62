#pragma once

#include <cstdint>

namespace styled::qtm {

// A timecode in QTM's packing: the kind and 64 bits.
struct Timecode {
  enum class Kind : std::uint32_t { kSmpte = 0, kIrig = 1, kCamera = 2 };
  Kind kind = Kind::kSmpte;
  std::uint32_t high = 0, low = 0;
};

// Hours, minutes, seconds, and frames (SMPTE) or tenths of a second (IRIG).
struct ClockTime {
  std::uint32_t hours = 0, minutes = 0, seconds = 0, parts = 0;
};

// `low` has the same layout for SMPTE and IRIG, except for the number of bits of the last field: 5
// and 4. A frame number of SMPTE is below 32. IRIG's year and day are in `high`.
constexpr ClockTime Unpack(const Timecode& timecode) noexcept {
  const std::uint32_t low = timecode.low;
  const std::uint32_t parts = timecode.kind == Timecode::Kind::kIrig ? 0xFU : 0x1FU;
  return {low & 0x1FU, low >> 5U & 0x3FU, low >> 11U & 0x3FU, low >> 17U & parts};
}
constexpr Timecode PackSmpte(const ClockTime& time) noexcept {
  return {Timecode::Kind::kSmpte, 0,
          time.hours | time.minutes << 5U | time.seconds << 11U | time.parts << 17U};
}

}  // namespace styled::qtm
