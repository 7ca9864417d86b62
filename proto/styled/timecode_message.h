#pragma once

#include "proto/styled/timecode.h"
#include "proto/styled/v1/frame.pb.h"

namespace styled {

// Fills all fields of the message. Allocates nothing.
inline void WriteTimecode(const Timecode& from, v1::Timecode& to) noexcept {
  to.set_hours(from.hours);
  to.set_minutes(from.minutes);
  to.set_seconds(from.seconds);
  to.set_frames(from.frames);
  to.set_rate(from.rate);
  to.set_drop_frame(from.drop_frame);
}

}  // namespace styled
