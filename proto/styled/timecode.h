#pragma once

#include <cstdint>

namespace styled {

// SMPTE timecode as the rig sends it (message Timecode of frame.proto).
struct Timecode {
  std::uint32_t hours = 0, minutes = 0, seconds = 0, frames = 0;
  float rate = 0;           // frames per second; 0: unknown; 1000: `frames` are milliseconds
  bool drop_frame = false;  // numbering skips frames so that labels keep up with the clock
};

}  // namespace styled
