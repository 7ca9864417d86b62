#pragma once

#include <cstdint>

#include "model/base/status.h"
#include "sim/faults/faults.h"
#include "sim/player/link.h"

namespace styled::player {

struct StreamCounts {
  std::uint64_t frames = 0;     // produced, lost ones included
  std::uint64_t bodies = 0;     // sent
  std::uint64_t datagrams = 0;  // sent, of either kind
  std::uint64_t bytes = 0;
  std::uint64_t sessions = 0;
};

// A source of datagrams that the player calls once per period. One thread.
class Sender {
 public:
  enum class Step { kSent, kSilent, kEnd, kError };

  virtual ~Sender() = default;
  // Sends the datagrams that are due in the next period. kError: see error().
  virtual Step Tick(Link& link) = 0;
  // Delay of the next Tick() in seconds; called once before each.
  virtual double NextDelay_s() { return 0; }
  // Sends the datagrams that are still held back (reordered, late, or in a burst). Call once at the
  // end.
  virtual Status Flush(Link& link) = 0;

  virtual int performers() const { return 1; }
  virtual const faults::Faults& faults() const = 0;
  const StreamCounts& counts() const { return counts_; }
  const Status& error() const { return error_; }

 protected:
  Status SendBytes(Link& link, std::span<const std::byte> datagram) {
    ++counts_.datagrams;
    counts_.bytes += datagram.size();
    return link.Send(datagram);
  }
  StreamCounts counts_;
  Status error_ = Status::Ok();
};

}  // namespace styled::player
