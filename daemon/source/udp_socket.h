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
#include "daemon/source/outbox.h"
#include "daemon/source/rate_limiter.h"

namespace styled::source {

// A bound UDP socket that receives a batch of datagrams, who sent each and when the kernel had it.
// Pipeline thread.
class UdpSocket {
 public:
  // `sender_limit_hz`: of datagrams of one address; 0 = any number.
  UdpSocket(runtime::Descriptor socket, runtime::Clock& clock, runtime::Counters& counters,
            int sender_limit_hz);

  // What has arrived, up to kBatch; never blocks. What is over the limit is counted and left out.
  // The bytes are valid until the next call.
  std::span<const std::span<const std::byte>> Receive();
  // Tells `receiver` of all the datagrams of the last batch, as source number `source`.
  STYLED_REALTIME void Announce(int source, Receiver& receiver) const noexcept;
  // The machines that sent the last batch, in its order.
  std::span<const Machine> machines() const noexcept { return {machines_.data(), batch_}; }
  // The sender of datagram `i` of the last batch.
  Peer Sender(std::size_t i) const noexcept;
  // When it arrived, on the clock's Now_ns(): by the kernel's stamp, so that what waited while the
  // loop was held up keeps its distance from what waited with it. Never goes back.
  std::int64_t arrived_ns(std::size_t i) const noexcept { return arrived_ns_[i]; }

  int fd() const { return socket_.get(); }
  const std::string& endpoint() const { return endpoint_; }
  std::uint64_t received() const { return received_; }

 private:
  // Larger than any datagram: none is ever cut.
  static constexpr std::size_t kSlot = 65536;
  static constexpr std::size_t kControl =
      CMSG_SPACE(sizeof(std::uint32_t)) + CMSG_SPACE(sizeof(timespec));
  // When message `i` arrived; what the kernel dropped before it is counted.
  std::int64_t ReadControl(std::size_t i, std::int64_t now_ns, std::int64_t wall_ns) noexcept;

  runtime::Descriptor socket_;
  runtime::Clock& clock_;
  runtime::Counters& counters_;
  std::string endpoint_;
  RateLimiter limiter_;
  std::uint32_t dropped_ = 0;
  std::uint64_t received_ = 0;
  std::size_t batch_ = 0;  // datagrams handed out last
  std::vector<std::byte> buffer_;
  std::array<iovec, kBatch> vectors_{};
  std::array<mmsghdr, kBatch> messages_{};
  std::array<sockaddr_storage, kBatch> senders_{};
  alignas(cmsghdr) std::array<std::array<char, kControl>, kBatch> controls_{};
  // Of the datagrams handed out: their places among the messages, when they arrived, who sent them.
  std::array<std::size_t, kBatch> places_{};
  std::array<std::int64_t, kBatch> arrived_ns_{};
  std::array<Machine, kBatch> machines_{};
  std::int64_t last_ns_ = std::numeric_limits<std::int64_t>::min();
  std::array<std::span<const std::byte>, kBatch> datagrams_;
};

}  // namespace styled::source
