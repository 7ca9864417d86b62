#pragma once

#include <sys/socket.h>

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <string>

#include "daemon/runtime/realtime.h"
#include "daemon/source/source_frame.h"
#include "model/base/realtime.h"
#include "model/base/status.h"

namespace styled::source {

// Bytes as they came, before anybody looked at them: a datagram, a piece of a TCP stream, what one
// USB transfer brought.
struct Arrival {
  int source = 0;
  std::int64_t time_ns = 0;  // monotonic
  std::span<const std::byte> bytes;
  const sockaddr* peer = nullptr;  // null: unknown
  socklen_t peer_size = 0;
  std::uint32_t device = 0;  // USB: numbers its opening, from 1
};

// What receives from all transports: the pipeline.
class Receiver {
 public:
  virtual ~Receiver() = default;
  // Frames and bodies that arrived together on source number `source`, 1 to kBatch of them, oldest
  // first; what they view is valid during the call only. `more_waiting`: the batch is full, so that
  // the newest frame may still be in the transport.
  virtual void OnFrames(int source, std::span<const SourceFrame> frames, bool more_waiting) = 0;
  // All bytes that come, once, before anything made of them is handed on by OnFrames: what a
  // recording keeps.
  STYLED_REALTIME virtual void OnArrival(const Arrival& /*arrival*/) noexcept {}
  // A line for the log, at most once for each thing that it says.
  virtual void OnNote(int /*source*/, const std::string& /*text*/) {}
};

// What a technician asks of a rig whose sensors do not know how they are worn.
enum class Calibration : std::uint8_t {
  kFull,     // the performer stands in the rest pose, looking ahead: mounting and heading
  kYaw,      // looking ahead: heading alone
  kMounting  // in the second pose of the rig's own habit
};

// What a delay does to the frames of a source, over the last second.
struct Smoothing {
  float delay_ms = 0;        // 0: none
  float arrived_ms = 0;      // 99 % of the frames came no further behind their sender's schedule
  float left_ms = 0;         // ... and left no further behind it and the delay
  std::uint64_t missed = 0;  // frames, since the start, that came later than the delay allows
};

// One way for bytes to come in; sources/<type>.h each. Used by the pipeline thread alone, except
// construction. Never blocks.
class Transport {
 public:
  virtual ~Transport() = default;
  // Hands what has arrived to `receiver`, up to a bound, and returns how many datagrams that was.
  virtual int DoWork(Receiver& receiver) = 0;
  // When DoWork has something to do though nothing arrives; INT64_MAX: never.
  virtual std::int64_t NextDeadline_ns() const { return std::numeric_limits<std::int64_t>::max(); }
  // Sensors that have to be told how they are worn, and no skeleton of their own.
  virtual bool has_sensors() const { return false; }
  // Errors say why not.
  virtual Status Calibrate(Calibration /*what*/, std::int64_t /*now_ns*/) {
    return Status::Error("a rig of this type has no sensors to calibrate");
  }
  // Readable when DoWork may find something.
  virtual int fd() const = 0;
  // The address bound, "HOST:PORT" with the real port.
  virtual const std::string& endpoint() const = 0;
  // Datagrams and records that arrived, those that were refused included.
  virtual std::uint64_t received() const = 0;
  virtual Smoothing smoothing() const { return {}; }
};

// At most this many frames are handed over at once: what bounds a cycle of the pipeline.
inline constexpr std::size_t kBatch = 32;

}  // namespace styled::source
