#pragma once

#include <netinet/in.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "daemon/runtime/counters.h"
#include "daemon/runtime/realtime.h"
#include "daemon/source/frame_memory.h"
#include "daemon/source/transport.h"

namespace styled::source {

// Who sent a datagram. `id` tells senders of one source apart and is never 0.
struct Peer {
  std::uint64_t id = 1;
  sockaddr_storage address{};
  socklen_t address_size = 0;  // 0: nobody who could be answered (TCP, tests)
};

// What a rig's translator makes of the datagrams it was given: frames for the pipeline, refusals to
// be counted, lines for the log, answers to the rig. One per source; pipeline thread.
class Outbox {
 public:
  Outbox(int source, runtime::Counters& counters);

  // A frame or body for the pipeline; what it views is copied. Those that wait are handed on when
  // they fill a batch, and by Close().
  STYLED_REALTIME void Put(const SourceFrame& frame) noexcept;

  // The rig's datagram, or a part of it, was refused.
  STYLED_REALTIME void Refuse(runtime::Counter reason) noexcept {
    counters_.AddOf(source_, reason);
  }
  // A line for the log: `text()` makes it, outside the hot section. Not for every datagram.
  template <typename MakeText>
  void Note(const MakeText& text) {
    LeaveHotSection();
    receiver_->OnNote(source_, text());
  }
  // Answers a rig; what cannot be sent is not.
  STYLED_REALTIME void Reply(const Peer& peer, std::span<const std::byte> datagram) noexcept;
  // What follows may allocate: a new body. The promise of the hot path holds again with the next
  // batch.
  void LeaveHotSection() noexcept { hot_.Leave(); }

  // The transport's side: Open before a batch, Close after it.
  void Open(Receiver& receiver, int reply_socket) noexcept;
  void Close() noexcept;

 private:
  void HandOn() noexcept;

  int source_;
  runtime::Counters& counters_;
  Receiver* receiver_ = nullptr;
  int reply_socket_ = -1;
  runtime::HotSection hot_{runtime::HotSection::kOutside};
  std::vector<FrameMemory> memories_;        // of what waits
  std::array<SourceFrame, kBatch> waiting_;  // the first count_
  std::size_t count_ = 0;
};

}  // namespace styled::source
