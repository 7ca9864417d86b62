#include "daemon/source/natnet.h"

#include <arpa/inet.h>
#include <net/if.h>
#include <sys/epoll.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <optional>

#include "daemon/config/sources.h"
#include "daemon/runtime/sockets.h"
#include "daemon/source/rigs/natnet.h"
#include "daemon/source/udp_socket.h"

namespace styled::source {
namespace {

using runtime::BindSocket;
using runtime::BoundAddress;

constexpr std::int64_t kRetry_ns = 5 * runtime::kSecond_ns;

// The network interface on which a group is joined, given by IPv4 address or by name.
struct Interface {
  in_addr address{};
  int index = 0;
};

Result<Interface> ParseInterface(const std::string& text) {
  Interface found;
  if (text.empty() || inet_pton(AF_INET, text.c_str(), &found.address) == 1) return found;
  found.index = static_cast<int>(if_nametoindex(text.c_str()));
  if (found.index != 0) return found;
  return Status::Error("interface: \"" + text +
                       "\"; expected an IPv4 address of this machine or an interface's name");
}

std::string ToString(const NatNet::Stream& stream) {
  std::array<char, INET_ADDRSTRLEN> text{};
  inet_ntop(AF_INET, &stream.group, text.data(), text.size());
  return std::string(text.data()) + ":" + std::to_string(stream.port);
}

// Binds to the group's address, so that no other traffic to the port arrives.
Result<Descriptor> JoinGroup(const NatNet::Stream& stream, const Interface& interface,
                             int receive_buffer_bytes) {
  Descriptor joined(socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  const int fd = joined.get(), one = 1, zero = 0;
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr = stream.group;
  address.sin_port = htons(stream.port);
  ip_mreqn membership{stream.group, interface.address, interface.index};
  // Other programs on this machine may listen to the group as well.
  setsockopt(fd, SOL_SOCKET, SO_REUSEADDR, &one, sizeof one);
  setsockopt(fd, IPPROTO_IP, IP_MULTICAST_ALL, &zero, sizeof zero);
  if (setsockopt(fd, SOL_SOCKET, SO_RCVBUFFORCE, &receive_buffer_bytes,
                 sizeof receive_buffer_bytes) != 0) {
    setsockopt(fd, SOL_SOCKET, SO_RCVBUF, &receive_buffer_bytes, sizeof receive_buffer_bytes);
  }
  if (bind(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0 ||
      setsockopt(fd, IPPROTO_IP, IP_ADD_MEMBERSHIP, &membership, sizeof membership) != 0) {
    return Status::Error("group " + ToString(stream) + ": " + std::strerror(errno));
  }
  return joined;
}

class NatNetTransport final : public Transport {
 public:
  NatNetTransport(Descriptor command, Descriptor epoll, const Interface& interface,
                  const config::Source& config, int source, runtime::Clock& clock,
                  runtime::Counters& counters, const sockaddr_in& server, in_addr group)
      : command_(std::move(command), source, clock, counters, config.sender_limit_hz),
        epoll_(std::move(epoll)),
        interface_(interface),
        receive_buffer_bytes_(config.receive_buffer_bytes),
        sender_limit_hz_(config.sender_limit_hz),
        source_(source),
        clock_(clock),
        counters_(counters),
        translator_(config, server, group),
        outbox_(source, counters) {
    sockaddr_storage address{};
    std::memcpy(&address, &server, sizeof server);
    endpoint_ = runtime::AddressText(address, sizeof server);
    Watch(command_.fd());
  }

  int DoWork(Receiver& receiver) override {
    int work = Drain(command_, receiver);
    if (data_) work += Drain(*data_, receiver);
    const std::int64_t now_ns = clock_.Now_ns();
    if (now_ns >= NextDeadline_ns()) ++work;
    outbox_.Open(receiver, command_.fd());
    translator_.Tick(now_ns, outbox_);
    outbox_.Close();
    Follow(now_ns, receiver);
    return work;
  }

  std::int64_t NextDeadline_ns() const override {
    return std::min(translator_.NextDeadline_ns(), next_try_ns_);
  }
  // One epoll instance holds both sockets; the pipeline polls that instance.
  int fd() const override { return epoll_.get(); }
  // The server's address; the kernel chooses our own ports.
  const std::string& endpoint() const override { return endpoint_; }
  std::uint64_t received() const override {
    return command_.received() + earlier_ + (data_ ? data_->received() : 0);
  }
  void Sample() override {
    command_.ReadDrops();
    if (data_) data_->ReadDrops();
  }
  std::uint64_t kernel_dropped() const override {
    return command_.kernel_dropped() + earlier_dropped_ + (data_ ? data_->kernel_dropped() : 0);
  }

 private:
  void Watch(int fd) {
    epoll_event event{};
    event.events = EPOLLIN;
    epoll_ctl(epoll_.get(), EPOLL_CTL_ADD, fd, &event);
  }

  int Drain(UdpSocket& socket, Receiver& receiver) {
    const auto datagrams = socket.Receive();
    if (datagrams.empty()) return 0;
    socket.Announce(source_, receiver);
    outbox_.Open(receiver, command_.fd());
    for (std::size_t i = 0; i < datagrams.size(); ++i) {
      translator_.Handle(datagrams[i], socket.Sender(i), socket.arrived_ns(i), outbox_);
    }
    outbox_.Close();
    return static_cast<int>(datagrams.size());
  }

  // Joins the group that the server streams to whenever it changes. Retries if a group cannot be
  // joined, e.g. because the interface is not up yet.
  void Follow(std::int64_t now_ns, Receiver& receiver) {
    if (translator_.stream() == joined_ && now_ns < next_try_ns_) return;
    joined_ = translator_.stream();
    next_try_ns_ = Translator::kNever;
    if (data_) {
      data_->ReadDrops();
      earlier_ += data_->received();
      earlier_dropped_ += data_->kernel_dropped();
    }
    data_.reset();
    if (!joined_) return;
    auto socket = JoinGroup(*joined_, interface_, receive_buffer_bytes_);
    if (socket.ok()) {
      data_.emplace(std::move(socket.value()), source_, clock_, counters_, sender_limit_hz_);
      Watch(data_->fd());
      return;
    }
    next_try_ns_ = now_ns + kRetry_ns;
    if (complaint_ == socket.status().message()) return;
    complaint_ = socket.status().message();
    receiver.OnNote(source_, complaint_);
  }

  UdpSocket command_;
  std::string endpoint_;
  Descriptor epoll_;
  Interface interface_;
  int receive_buffer_bytes_, sender_limit_hz_, source_;
  runtime::Clock& clock_;
  runtime::Counters& counters_;
  NatNet translator_;
  Outbox outbox_;
  std::optional<UdpSocket> data_;
  // Datagrams received from former groups, and datagrams that the kernel dropped there.
  std::uint64_t earlier_ = 0, earlier_dropped_ = 0;
  std::optional<NatNet::Stream> joined_;  // the group that was joined, or tried last
  std::int64_t next_try_ns_ = Translator::kNever;
  std::string complaint_;
};

}  // namespace

Result<std::unique_ptr<Transport>> MakeNatNetTransport(const config::Source& config, int source,
                                                       runtime::Clock& clock,
                                                       runtime::Counters& counters) {
  const auto server = config::ParseServer(config.server, natnet::kCommandPort);
  if (!server.ok()) return server.status();
  const auto group = config::ParseGroup(config.group);
  if (!group.ok()) return group.status();
  const auto interface = ParseInterface(config.interface);
  if (!interface.ok()) return interface.status();
  auto command = BindSocket(SOCK_DGRAM, config.listen, config.receive_buffer_bytes);
  if (!command.ok()) return command.status();
  if (BoundAddress(command.value().get()).starts_with('[')) {
    return Status::Error("udp " + config.listen + ": expected an IPv4 address, like the server's");
  }
  Descriptor epoll(epoll_create1(EPOLL_CLOEXEC));
  if (epoll.get() < 0) return Status::Error("udp " + config.listen + ": no file descriptor left");
  return std::unique_ptr<Transport>(std::make_unique<NatNetTransport>(
      std::move(command.value()), std::move(epoll), interface.value(), config, source, clock,
      counters, server.value(), group.value()));
}

}  // namespace styled::source
