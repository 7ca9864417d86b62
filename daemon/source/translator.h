#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>

#include "daemon/source/outbox.h"
#include "daemon/source/transport.h"
#include "model/base/status.h"

namespace styled::source {

// Translates a rig's own protocol (a codec of proto/rigs) into frames for the pipeline: one
// PerformerStream per performer fills them in and puts them into the Outbox. The pipeline applies
// the same rules to the frames of every rig; nothing that is specific to one rig leaves its
// translator. One per source, pipeline thread. From a performer's second frame on it does not
// allocate, lock, log or throw.
//
// Poses leave it on a right-handed skeleton as local rotations (parent from joint). A sender's
// restart becomes PerformerStream::Restart, a joint that is not tracked becomes NaN.
class Translator {
 public:
  Translator() = default;
  virtual ~Translator() = default;
  Translator(const Translator&) = delete;
  Translator& operator=(const Translator&) = delete;

  // Handles one datagram, or record of a stream, that arrived at `now_ns` (monotonic). The bytes
  // are valid during the call.
  virtual void Handle(std::span<const std::byte> datagram, const Peer& peer, std::int64_t now_ns,
                      Outbox& out) = 0;

  // Handles everything that depends on time alone: unfinished frames, ticks of a clock, heartbeats.
  // Called after every batch and when NextDeadline_ns() has passed.
  virtual void Tick(std::int64_t /*now_ns*/, Outbox& /*out*/) {}
  virtual std::int64_t NextDeadline_ns() const { return kNever; }
  static constexpr std::int64_t kNever = std::numeric_limits<std::int64_t>::max();

  // Whether the rig consists of sensors without a skeleton, which must be calibrated to the body.
  virtual bool has_sensors() const { return false; }
  // Errors give the reason.
  virtual Status Calibrate(Calibration /*what*/, std::int64_t /*now_ns*/) {
    return Status::Error("a rig of this type has no sensors to calibrate");
  }
};

}  // namespace styled::source
