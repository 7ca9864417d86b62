#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>

#include "daemon/source/outbox.h"
#include "daemon/source/transport.h"
#include "model/base/status.h"

namespace styled::source {

// Turns a rig's own protocol (a codec of proto/rigs) into frames for the pipeline: a
// PerformerStream per performer fills them in and puts them into the Outbox. Every rig's frames
// meet the same rules in the pipeline; what only one rig needs ends here. One per source, pipeline
// thread. From a performer's second frame on it does not allocate, lock, log or throw.
//
// Poses leave it on a right-handed skeleton as local rotations (parent from joint), a sender's
// restart as PerformerStream::Restart, a joint that is not tracked as NaN.
class Translator {
 public:
  Translator() = default;
  virtual ~Translator() = default;
  Translator(const Translator&) = delete;
  Translator& operator=(const Translator&) = delete;

  // One datagram, or record of a stream, that arrived at `now_ns` (monotonic). The bytes are valid
  // during the call.
  virtual void Take(std::span<const std::byte> datagram, const Peer& peer, std::int64_t now_ns,
                    Outbox& out) = 0;

  // What time alone brings about: frames that nobody closes, ticks of a clock, heartbeats. Called
  // after every batch and when NextDeadline_ns() has passed.
  virtual void Tick(std::int64_t /*now_ns*/, Outbox& /*out*/) {}
  virtual std::int64_t NextDeadline_ns() const { return kNever; }
  static constexpr std::int64_t kNever = std::numeric_limits<std::int64_t>::max();

  // Sensors that have to be told how they are worn, and no skeleton of their own.
  virtual bool has_sensors() const { return false; }
  // Errors say why not.
  virtual Status Calibrate(Calibration /*what*/, std::int64_t /*now_ns*/) {
    return Status::Error("a rig of this type has no sensors to calibrate");
  }
};

}  // namespace styled::source
