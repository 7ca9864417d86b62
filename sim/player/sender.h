#pragma once

#include <cstdint>
#include <string>

#include "model/base/status.h"
#include "sim/faults/faults.h"
#include "sim/player/link.h"

namespace styled::player {

struct StreamCounts {
  std::uint64_t frames = 0;     // made, lost ones included
  std::uint64_t bodies = 0;     // sent
  std::uint64_t datagrams = 0;  // sent, of either kind
  std::uint64_t bytes = 0;
  std::uint64_t sessions = 0;
};

// What the player plays: something that sends at every tick of the rate. One thread.
class Sender {
 public:
  enum class Step { kSent, kSilent, kEnd, kError };

  virtual ~Sender() = default;
  // Sends what is due at the next tick of the rate. kError: error() says why.
  virtual Step Tick(Link& link) = 0;
  // How long after its time the next Tick() comes: once before each, in seconds.
  virtual double NextDelay_s() { return 0; }
  // Sends what is still held back (reordered, late, of a burst). Call once at the end.
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
