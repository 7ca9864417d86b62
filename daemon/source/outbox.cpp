#include "daemon/source/outbox.h"

#include <sys/socket.h>

namespace styled::source {

Outbox::Outbox(int source, runtime::Counters& counters)
    : source_(source), counters_(counters), buffer_(kBatch * native::kMaxDatagramSize) {}

void Outbox::Open(Receiver& receiver, int reply_socket) noexcept {
  receiver_ = &receiver;
  reply_socket_ = reply_socket;
  hot_.Enter();
}

void Outbox::Close() noexcept {
  HandOn();
  hot_.Leave();
}

std::span<std::byte> Outbox::Slot() noexcept {
  if (count_ == kBatch) {
    HandOn();
    hot_.Enter();
  }
  return std::span(buffer_).subspan(count_ * native::kMaxDatagramSize, native::kMaxDatagramSize);
}

void Outbox::Put(std::size_t size) noexcept {
  waiting_[count_] = std::span(buffer_).subspan(count_ * native::kMaxDatagramSize, size);
  ++count_;
}

void Outbox::HandOn() noexcept {
  if (count_ == 0) return;
  hot_.Leave();  // the pipeline has a section of its own
  receiver_->OnDatagrams(source_, {waiting_.data(), count_});
  count_ = 0;
}

void Outbox::Reply(const Peer& peer, std::span<const std::byte> datagram) noexcept {
  if (reply_socket_ < 0 || peer.address_size == 0) return;
  sendto(reply_socket_, datagram.data(), datagram.size(), MSG_DONTWAIT | MSG_NOSIGNAL,
         reinterpret_cast<const sockaddr*>(&peer.address), peer.address_size);
}

}  // namespace styled::source
