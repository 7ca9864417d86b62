#include "daemon/source/udp.h"

#include <array>
#include <cstring>
#include <vector>

#include "daemon/source/sockets.h"

namespace styled::source {
namespace {

class Udp final : public Transport {
 public:
  Udp(Descriptor socket, int source, runtime::Counters& counters)
      : socket_(std::move(socket)),
        source_(source),
        counters_(counters),
        endpoint_(BoundAddress(socket_.get())),
        buffer_(kBatch * kSlot) {
    for (std::size_t i = 0; i < kBatch; ++i) {
      vectors_[i] = {&buffer_[i * kSlot], kSlot};
      messages_[i].msg_hdr.msg_iov = &vectors_[i];
      messages_[i].msg_hdr.msg_iovlen = 1;
      messages_[i].msg_hdr.msg_control = controls_[i].data();
    }
  }

  int DoWork(Receiver& receiver) override {
    for (auto& message : messages_) message.msg_hdr.msg_controllen = sizeof controls_[0];
    const int count = recvmmsg(socket_.get(), messages_.data(), kBatch, MSG_DONTWAIT, nullptr);
    if (count <= 0) return 0;
    for (int i = 0; i < count; ++i) {
      datagrams_[static_cast<std::size_t>(i)] = {&buffer_[static_cast<std::size_t>(i) * kSlot],
                                                 messages_[static_cast<std::size_t>(i)].msg_len};
    }
    CountDropped(messages_[static_cast<std::size_t>(count) - 1].msg_hdr);
    receiver.OnDatagrams(source_, {datagrams_.data(), static_cast<std::size_t>(count)});
    return count;
  }

  int fd() const override { return socket_.get(); }
  const std::string& endpoint() const override { return endpoint_; }

 private:
  // Larger than any datagram: none is ever cut.
  static constexpr std::size_t kSlot = 65536;

  // SO_RXQ_OVFL: the socket's total of dropped datagrams, with each that was not.
  void CountDropped(msghdr& header) noexcept {
    for (cmsghdr* c = CMSG_FIRSTHDR(&header); c != nullptr; c = CMSG_NXTHDR(&header, c)) {
      if (c->cmsg_level != SOL_SOCKET || c->cmsg_type != SO_RXQ_OVFL) continue;
      std::uint32_t dropped = 0;
      std::memcpy(&dropped, CMSG_DATA(c), sizeof dropped);
      counters_.Add(runtime::Counter::kSourceKernelDropped, dropped - dropped_);
      dropped_ = dropped;
    }
  }

  Descriptor socket_;
  int source_;
  runtime::Counters& counters_;
  std::string endpoint_;
  std::uint32_t dropped_ = 0;
  std::vector<std::byte> buffer_;
  std::array<iovec, kBatch> vectors_{};
  std::array<mmsghdr, kBatch> messages_{};
  alignas(
      cmsghdr) std::array<std::array<char, CMSG_SPACE(sizeof(std::uint32_t))>, kBatch> controls_{};
  std::array<std::span<const std::byte>, kBatch> datagrams_;
};

}  // namespace

Result<std::unique_ptr<Transport>> MakeUdp(const config::Source& config, int source,
                                           runtime::Counters& counters) {
  auto socket = BindSocket(SOCK_DGRAM, config.listen, config.receive_buffer_bytes);
  if (!socket.ok()) return socket.status();
  const int one = 1;
  setsockopt(socket.value().get(), SOL_SOCKET, SO_RXQ_OVFL, &one, sizeof one);
  return std::unique_ptr<Transport>(
      std::make_unique<Udp>(std::move(socket.value()), source, counters));
}

}  // namespace styled::source
