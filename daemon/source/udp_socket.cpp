#include "daemon/source/udp_socket.h"

#include <linux/sock_diag.h>

#include <algorithm>
#include <cstring>

#include "model/base/hash.h"

namespace styled::source {

UdpSocket::UdpSocket(Descriptor socket, int source, runtime::Clock& clock,
                     runtime::Counters& counters, int sender_limit_hz)
    : socket_(std::move(socket)),
      source_(source),
      clock_(clock),
      counters_(counters),
      endpoint_(runtime::BoundAddress(socket_.get())),
      limiter_(sender_limit_hz),
      buffer_(kBatch * kSlot) {
  const int one = 1;
  setsockopt(socket_.get(), SOL_SOCKET, SO_RXQ_OVFL, &one, sizeof one);
  setsockopt(socket_.get(), SOL_SOCKET, SO_TIMESTAMPNS, &one, sizeof one);
  for (std::size_t i = 0; i < kBatch; ++i) {
    vectors_[i] = {&buffer_[i * kSlot], kSlot};
    msghdr& header = messages_[i].msg_hdr;
    header.msg_iov = &vectors_[i];
    header.msg_iovlen = 1;
    header.msg_control = controls_[i].data();
    header.msg_name = &senders_[i];
  }
}

std::span<const std::span<const std::byte>> UdpSocket::Receive() {
  for (auto& message : messages_) {
    message.msg_hdr.msg_controllen = sizeof controls_[0];
    message.msg_hdr.msg_namelen = sizeof senders_[0];
  }
  const std::int64_t began_ns = clock_.Now_ns();
  arrival_clock_.Begin(began_ns);
  const int received = recvmmsg(socket_.get(), messages_.data(), kBatch, MSG_DONTWAIT, nullptr);
  batch_ = 0;
  if (received <= 0) {
    arrival_clock_.End(true);
    read_until_ns_ = began_ns;
    return {};
  }
  const auto count = static_cast<std::size_t>(received);
  received_ += count;
  arrival_clock_.Received(clock_);
  for (std::size_t i = 0; i < count; ++i) {
    const std::int64_t arrived_ns = ReadControl(i);
    if (!limiter_.Admit(senders_[i], arrived_ns)) continue;
    datagrams_[batch_] = {&buffer_[i * kSlot], messages_[i].msg_len};
    arrived_ns_[batch_] = arrived_ns;
    machines_[batch_] = MachineOf(senders_[i]);
    places_[batch_] = i;
    ++batch_;
  }
  const bool drained = count < kBatch;
  arrival_clock_.End(drained);
  read_until_ns_ = drained ? began_ns : last_ns_;
  if (batch_ < count) {
    counters_.AddOf(source_, runtime::Counter::kSourceRateLimited, count - batch_);
  }
  return {datagrams_.data(), batch_};
}

void UdpSocket::Announce(int source, Receiver& receiver) const noexcept {
  const runtime::HotSection hot;
  for (std::size_t i = 0; i < batch_; ++i) {
    const std::size_t place = places_[i];
    receiver.OnArrival({source, arrived_ns_[i], datagrams_[i],
                        reinterpret_cast<const sockaddr*>(&senders_[place]),
                        messages_[place].msg_hdr.msg_namelen});
  }
}

Peer UdpSocket::Sender(std::size_t i) const noexcept {
  Peer peer;
  const std::size_t place = places_[i];
  peer.address_size = messages_[place].msg_hdr.msg_namelen;
  peer.address = senders_[place];
  // Hashes address and port only, because padding and flow labels may differ.
  Fnv1a hash;
  if (peer.address.ss_family == AF_INET) {
    const auto& v4 = reinterpret_cast<const sockaddr_in&>(peer.address);
    hash.Bytes(&v4.sin_addr, sizeof v4.sin_addr);
    hash.Bytes(&v4.sin_port, sizeof v4.sin_port);
  } else {
    const auto& v6 = reinterpret_cast<const sockaddr_in6&>(peer.address);
    hash.Bytes(&v6.sin6_addr, sizeof v6.sin6_addr);
    hash.Bytes(&v6.sin6_port, sizeof v6.sin6_port);
  }
  peer.id = hash.value() | 1U;
  return peer;
}

// SO_RXQ_OVFL delivers the socket's total of dropped datagrams with each received one.
std::int64_t UdpSocket::ReadControl(std::size_t i) noexcept {
  msghdr& header = messages_[i].msg_hdr;
  std::int64_t arrived_ns = arrival_clock_.now_ns();
  for (cmsghdr* c = CMSG_FIRSTHDR(&header); c != nullptr; c = CMSG_NXTHDR(&header, c)) {
    if (c->cmsg_level != SOL_SOCKET) continue;
    if (c->cmsg_type == SO_RXQ_OVFL) {
      std::uint32_t dropped = 0;
      std::memcpy(&dropped, CMSG_DATA(c), sizeof dropped);
      NoteDropped(dropped);
    } else if (c->cmsg_type == SCM_TIMESTAMPNS) {
      timespec stamp{};
      std::memcpy(&stamp, CMSG_DATA(c), sizeof stamp);
      arrived_ns = arrival_clock_.Arrival_ns(stamp.tv_sec * runtime::kSecond_ns + stamp.tv_nsec);
    }
  }
  last_ns_ = std::max(last_ns_, arrived_ns);
  return last_ns_;
}

void UdpSocket::NoteDropped(std::uint32_t total) noexcept {
  // A datagram carries the total at the time when it was queued, which may be known already. The
  // kernel's count wraps.
  const auto more = static_cast<std::int32_t>(total - dropped_);
  if (more <= 0) return;
  dropped_ = total;
  kernel_dropped_ += static_cast<std::uint64_t>(more);
  counters_.AddOf(source_, runtime::Counter::kSourceKernelDropped,
                  static_cast<std::uint64_t>(more));
}

void UdpSocket::ReadDrops() noexcept {
  std::array<std::uint32_t, SK_MEMINFO_VARS> info{};
  socklen_t size = sizeof info;
  if (getsockopt(socket_.get(), SOL_SOCKET, SO_MEMINFO, info.data(), &size) != 0) return;
  if (size > SK_MEMINFO_DROPS * sizeof info[0]) NoteDropped(info[SK_MEMINFO_DROPS]);
}

}  // namespace styled::source
