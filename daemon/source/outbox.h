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

// The sender of a datagram. `id` distinguishes the senders of one source and is never 0.
struct Peer {
  std::uint64_t id = 1;
  sockaddr_storage address{};
  socklen_t address_size = 0;  // 0: cannot be answered (TCP, tests)
};

// The output of a rig's translator: frames for the pipeline, refusals to be counted, lines for the
// log, replies to the rig. One per source; pipeline thread.
class Outbox {
 public:
  Outbox(int source, runtime::Counters& counters);

  // Queues a frame or body for the pipeline and copies the data that it views. The queue is passed
  // on when it holds a full batch, and by Close().
  STYLED_REALTIME void Put(const SourceFrame& frame) noexcept;

  // Counts a refused datagram of the rig, or a refused part of one.
  STYLED_REALTIME void Refuse(runtime::Counter reason) noexcept {
    counters_.AddOf(source_, reason);
  }
  // Logs a line. `text()` composes it outside the hot section. Not for every datagram.
  template <typename MakeText>
  void Note(const MakeText& text) {
    LeaveHotSection();
    receiver_->OnNote(source_, text());
  }
  // The same for a line that is not a warning (Receiver::OnNotice).
  template <typename MakeText>
  void Notice(const MakeText& text) {
    LeaveHotSection();
    receiver_->OnNotice(source_, text());
  }
  // Sends a reply to a rig; dropped if it cannot be sent at once.
  STYLED_REALTIME void Reply(const Peer& peer, std::span<const std::byte> datagram) noexcept;
  // Call before work that may allocate, such as a new body. The hot section is entered again with
  // the next batch.
  void LeaveHotSection() noexcept { hot_.Leave(); }

  // For the transport: Open before a batch, Close after it.
  void Open(Receiver& receiver, int reply_socket) noexcept;
  void Close() noexcept;

 private:
  void HandOn() noexcept;

  int source_;
  runtime::Counters& counters_;
  Receiver* receiver_ = nullptr;
  int reply_socket_ = -1;
  runtime::HotSection hot_{runtime::HotSection::kOutside};
  std::vector<FrameMemory> memories_;        // copies of the waiting frames
  std::array<SourceFrame, kBatch> waiting_;  // only the first count_ are in use
  std::size_t count_ = 0;
};

}  // namespace styled::source
