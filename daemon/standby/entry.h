#pragma once

#include <cstdint>

#include "daemon/source/source_frame.h"
#include "proto/styled/v1/journal.pb.h"

namespace styled::standby {

// What became of a frame that a daemon handled.
struct Outcome {
  v1::Fate fate = v1::FATE_REFUSED;
  bool late = false;
  std::uint64_t published = 0;   // Frame.sequence, if it was styled
  std::uint32_t styled_crc = 0;  // of the styled pose on the canonical body
};

// A frame or body as an entry of the journal. Allocates.
void Write(const source::SourceFrame& frame, const Outcome& outcome, v1::Handled& entry);
// The frame of an entry, with views into it; false for one that no daemon writes.
bool Read(const v1::Handled& entry, source::SourceFrame& frame, Outcome& outcome);

}  // namespace styled::standby
