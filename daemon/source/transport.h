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

// Bytes as they arrived, before any decoding: a datagram, a piece of a TCP stream, or one USB
// transfer.
struct Arrival {
  int source = 0;
  std::int64_t time_ns = 0;  // monotonic
  std::span<const std::byte> bytes;
  const sockaddr* peer = nullptr;  // null: unknown
  socklen_t peer_size = 0;
  std::uint32_t device = 0;  // USB: number of the device's opening, from 1; else 0
};

// The receiver of all transports' output: the pipeline.
class Receiver {
 public:
  virtual ~Receiver() = default;
  // Frames and bodies that arrived together on source number `source`: 1 to kBatch of them, oldest
  // first. Their views are valid during the call only. `more_waiting`: the batch is full, so the
  // newest frame may still be in the transport.
  virtual void OnFrames(int source, std::span<const SourceFrame> frames, bool more_waiting) = 0;
  // All arriving bytes, once, before OnFrames delivers the frames made from them. A recording
  // stores these bytes.
  STYLED_REALTIME virtual void OnArrival(const Arrival& /*arrival*/) noexcept {}
  // A line for the log, a warning. The caller limits how often the same fact is reported.
  virtual void OnNote(int /*source*/, const std::string& /*text*/) {}
  // The same for a line that is not a warning: a rig is calibrated, a server answers again.
  virtual void OnNotice(int source, const std::string& text) { OnNote(source, text); }
};

// The calibrations of a rig whose sensors do not know how they are mounted on the body.
enum class Calibration : std::uint8_t {
  kFull,     // the performer stands in the rest pose, facing forward: mounting and heading
  kYaw,      // facing forward: heading alone
  kMounting  // in the second pose that the rig defines
};

// The effect of a delay on the frames of a source, over the last second.
struct Smoothing {
  float delay_ms = 0;  // 0: none
  // The lateness, relative to the sender's schedule, that 99 % of the frames did not exceed: at
  // arrival, and at leaving without the delay itself.
  float arrived_ms = 0;
  float left_ms = 0;
  std::uint64_t missed = 0;  // frames since the start that arrived later than the delay allows
};

// One way for data to arrive; one implementation per type of source. Used by the pipeline thread
// alone, except for construction. Never blocks.
class Transport {
 public:
  virtual ~Transport() = default;
  // Passes the data that has arrived to `receiver`, up to a bound, and returns the number of
  // datagrams.
  virtual int DoWork(Receiver& receiver) = 0;
  // The time at which DoWork has work even if nothing arrives; INT64_MAX: never.
  virtual std::int64_t NextDeadline_ns() const { return std::numeric_limits<std::int64_t>::max(); }
  // As Translator::has_sensors() and Translator::Calibrate().
  virtual bool has_sensors() const { return false; }
  virtual Status Calibrate(Calibration /*what*/, std::int64_t /*now_ns*/) {
    return Status::Error("a rig of this type has no sensors to calibrate");
  }
  // A descriptor that is readable when DoWork may find something.
  virtual int fd() const = 0;
  // The bound address, "HOST:PORT" with the actual port; the server's, if we connect to one.
  virtual const std::string& endpoint() const = 0;
  // Number of datagrams and records that arrived, including refused ones.
  virtual std::uint64_t received() const = 0;
  virtual Smoothing smoothing() const { return {}; }
  // Call about once a second, outside of the hot section: reads values that arrive with no
  // datagram.
  virtual void Sample() {}
  // Datagrams that the kernel dropped because the buffer was full, as of the last Sample().
  virtual std::uint64_t kernel_dropped() const { return 0; }
};

// The most frames of one call of OnFrames, which bounds a cycle of the pipeline.
inline constexpr std::size_t kBatch = 32;

}  // namespace styled::source
