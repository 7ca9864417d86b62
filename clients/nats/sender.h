#pragma once

#include <atomic>
#include <cstdint>
#include <thread>

#include "clients/nats/frame_queue.h"
#include "clients/nats/link.h"

namespace styled::stylenats {

// Publishes the frames and bodies of a queue on a thread of its own, since natsConnection_Publish
// blocks while the broker does not read. Frames that wait together are written together: a broker
// that reads 16 at once writes once to each viewer, not 16 times. The headers of a frame are
// Styled-Epoch and Styled-Sequence, decimal numbers. While there is no connection the frames are
// dropped and counted: none is sent late.
class Sender {
 public:
  // Totals since the start; any thread.
  struct Counts {
    std::atomic<std::uint64_t> frames{0};        // passed to libnats
    std::atomic<std::uint64_t> bodies{0};        // the same
    std::atomic<std::uint64_t> disconnected{0};  // dropped, no connection
    std::atomic<std::uint64_t> too_large{0};     // dropped, above the broker's max_payload
    std::atomic<std::uint64_t> failed{0};        // dropped, libnats refused
    std::atomic<std::uint64_t> stalled{0};       // calls that took longer than kStall
    std::atomic<std::uint64_t> longest_call_us{0};
  };
  // A broker that has a slow subscriber makes its publishers wait; a leaf server without viewers
  // does not. 20 ms are more than two frame periods at 120 Hz.
  static constexpr std::chrono::milliseconds kStall{20};

  Sender(FrameQueue& queue, Link& link);
  // Sends the waiting messages, then ends the thread: at once, or when a blocked call returns (the
  // link's write deadline, 1 s).
  void Stop();
  const Counts& counts() const { return counts_; }

 private:
  void Loop(const std::stop_token& stop);
  void Send(const QueuedFrame& frame);
  void Write();
  template <typename Call>
  natsStatus Timed(const Call& call);  // counts a call that blocks

  FrameQueue& queue_;
  Link& link_;
  Counts counts_;
  std::uint64_t unwritten_ = 0;  // frames since the last Write
  std::jthread thread_;          // last: it ends before the rest
};

}  // namespace styled::stylenats
