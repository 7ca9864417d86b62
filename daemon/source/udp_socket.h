#pragma once

#include <array>
#include <cstddef>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "daemon/runtime/clock.h"
#include "daemon/runtime/counters.h"
#include "daemon/runtime/sockets.h"
#include "daemon/source/arrival_clock.h"
#include "daemon/source/outbox.h"
#include "daemon/source/rate_limiter.h"

namespace styled::source {

// A bound UDP socket that receives datagrams in batches, with the sender and the kernel's time of
// arrival of each. Pipeline thread.
class UdpSocket {
 public:
  // `source`: number of the source that it belongs to. `sender_limit_hz`: most datagrams per second
  // of one address; 0 = no limit.
  UdpSocket(Descriptor socket, int source, runtime::Clock& clock, runtime::Counters& counters,
            int sender_limit_hz);

  // Receives the waiting datagrams, up to kBatch; never blocks. Datagrams over the limit are
  // counted and left out. The bytes are valid until the next call.
  std::span<const std::span<const std::byte>> Receive();
  // Passes every datagram of the last batch to `receiver`.OnArrival, as source number `source`.
  STYLED_REALTIME void Announce(int source, Receiver& receiver) const noexcept;
  // The machines that sent the last batch, in its order.
  std::span<const Machine> machines() const noexcept { return {machines_.data(), batch_}; }
  // The sender of datagram `i` of the last batch.
  Peer Sender(std::size_t i) const noexcept;
  // The time of arrival on the clock's Now_ns(), by the kernel's timestamp: datagrams that waited
  // while the loop was delayed keep their distances in time. Never goes back.
  std::int64_t arrived_ns(std::size_t i) const noexcept { return arrived_ns_[i]; }
  std::span<const std::int64_t> arrivals_ns() const noexcept {
    return {arrived_ns_.data(), batch_};
  }
  // The time up to which all data that arrived has been passed on. While more datagrams wait in the
  // socket, it is the arrival time of the last one passed on: an unread datagram must not be
  // mistaken for silence.
  std::int64_t read_until_ns() const noexcept { return read_until_ns_; }
  // Counts the datagrams that the kernel has dropped since the last count; otherwise the count
  // would only be known with the next datagram that arrives. One system call.
  void ReadDrops() noexcept;
  std::uint64_t kernel_dropped() const noexcept { return kernel_dropped_; }

  int fd() const { return socket_.get(); }
  const std::string& endpoint() const { return endpoint_; }
  std::uint64_t received() const { return received_; }

 private:
  // Larger than any datagram, so that none is ever truncated.
  static constexpr std::size_t kSlot = 65536;
  static constexpr std::size_t kControl =
      CMSG_SPACE(sizeof(std::uint32_t)) + CMSG_SPACE(sizeof(timespec));
  // Reads when message `i` arrived, and counts the datagrams that the kernel dropped before it.
  std::int64_t ReadControl(std::size_t i) noexcept;
  void NoteDropped(std::uint32_t total) noexcept;

  Descriptor socket_;
  int source_;
  runtime::Clock& clock_;
  runtime::Counters& counters_;
  std::string endpoint_;
  RateLimiter limiter_;
  ArrivalClock arrival_clock_;
  std::int64_t read_until_ns_ = 0;
  std::uint32_t dropped_ = 0;  // the kernel's count, which wraps
  std::uint64_t kernel_dropped_ = 0;
  std::uint64_t received_ = 0;
  std::size_t batch_ = 0;  // number of datagrams passed on last
  std::vector<std::byte> buffer_;
  std::array<iovec, kBatch> vectors_{};
  std::array<mmsghdr, kBatch> messages_{};
  std::array<sockaddr_storage, kBatch> senders_{};
  alignas(cmsghdr) std::array<std::array<char, kControl>, kBatch> controls_{};
  // For each datagram passed on: its index among the messages, its time of arrival, its sender.
  std::array<std::size_t, kBatch> places_{};
  std::array<std::int64_t, kBatch> arrived_ns_{};
  std::array<Machine, kBatch> machines_{};
  std::int64_t last_ns_ = std::numeric_limits<std::int64_t>::min();
  std::array<std::span<const std::byte>, kBatch> datagrams_;
};

}  // namespace styled::source
