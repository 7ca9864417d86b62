#include "daemon/source/outbox.h"

#include <sys/socket.h>

namespace styled::source {

Outbox::Outbox(int source, runtime::Counters& counters) : source_(source), counters_(counters) {
  memories_.reserve(kBatch);
  for (std::size_t i = 0; i < kBatch; ++i) memories_.emplace_back(kMostFrameBytes);
}

void Outbox::Open(Receiver& receiver, int reply_socket) noexcept {
  receiver_ = &receiver;
  reply_socket_ = reply_socket;
  hot_.Enter();
}

void Outbox::Close() noexcept {
  HandOn();
  hot_.Leave();
}

void Outbox::Put(const SourceFrame& frame) noexcept {
  if (count_ == kBatch) {
    HandOn();
    hot_.Enter();
  }
  waiting_[count_] = memories_[count_].Keep(frame);
  ++count_;
}

void Outbox::HandOn() noexcept {
  if (count_ == 0) return;
  hot_.Leave();  // the pipeline enters a section of its own
  receiver_->OnFrames(source_, std::span(waiting_).first(count_), count_ == kBatch);
  // Released here and not with the next frame, because the last owner of a body frees memory.
  for (std::size_t i = 0; i < count_; ++i) waiting_[i].body.reset();
  count_ = 0;
}

void Outbox::Reply(const Peer& peer, std::span<const std::byte> datagram) noexcept {
  if (reply_socket_ < 0 || peer.address_size == 0) return;
  sendto(reply_socket_, datagram.data(), datagram.size(), MSG_DONTWAIT | MSG_NOSIGNAL,
         reinterpret_cast<const sockaddr*>(&peer.address), peer.address_size);
}

}  // namespace styled::source
