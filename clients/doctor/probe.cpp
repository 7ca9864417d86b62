#include "clients/doctor/probe.h"

#include <netinet/in.h>
#include <poll.h>
#include <sys/epoll.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>

namespace styled::doctor {
namespace {

constexpr int kReceiveBuffer = 4 << 20;
constexpr std::size_t kMaxConnections = 16;
constexpr double kTick_s = 0.05;

class UdpListener final : public Listener {
 public:
  UdpListener(Descriptor fd, const std::vector<Interface>& interfaces)
      : fd_(std::move(fd)), interfaces_(interfaces) {
    const int one = 1;
    setsockopt(fd_.get(), IPPROTO_IP, IP_PKTINFO, &one, sizeof one);
    setsockopt(fd_.get(), IPPROTO_IPV6, IPV6_RECVPKTINFO, &one, sizeof one);
    setsockopt(fd_.get(), SOL_SOCKET, SO_RCVBUF, &kReceiveBuffer, sizeof kReceiveBuffer);
    sockaddr_storage bound{};
    socklen_t size = sizeof bound;
    getsockname(fd_.get(), reinterpret_cast<sockaddr*>(&bound), &size);
    local_ = FromSocket(bound);
  }

  int fd() const override { return fd_.get(); }

  void Listen(Notebook& notes) override {
    for (int i = 0; i < kBatch; ++i) {
      sockaddr_storage sender{};
      iovec vector{notes.buffer.data(), notes.buffer.size()};
      alignas(cmsghdr) std::array<char, 128> control{};
      msghdr header{};
      header.msg_name = &sender;
      header.msg_namelen = sizeof sender;
      header.msg_iov = &vector;
      header.msg_iovlen = 1;
      header.msg_control = control.data();
      header.msg_controllen = control.size();
      const ssize_t size = recvmsg(fd_.get(), &header, MSG_DONTWAIT);
      if (size < 0) return;
      const auto bytes = std::span(notes.buffer).first(static_cast<std::size_t>(size));
      Arrival arrival{false, local_, FromSocket(sender), "", notes.now_s, bytes.size()};
      ReadTarget(header, arrival);
      notes.heard.Add(arrival, notes.sniffer.Sniff(bytes));
    }
  }

 private:
  // Reads the destination address and the interface of a datagram.
  void ReadTarget(msghdr& header, Arrival& arrival) const {
    unsigned index = 0;
    sockaddr_storage target{};
    for (cmsghdr* c = CMSG_FIRSTHDR(&header); c != nullptr; c = CMSG_NXTHDR(&header, c)) {
      if (c->cmsg_level == IPPROTO_IP && c->cmsg_type == IP_PKTINFO) {
        in_pktinfo info{};
        std::memcpy(&info, CMSG_DATA(c), sizeof info);
        target.ss_family = AF_INET;
        reinterpret_cast<sockaddr_in&>(target).sin_addr = info.ipi_addr;
        index = static_cast<unsigned>(info.ipi_ifindex);
      } else if (c->cmsg_level == IPPROTO_IPV6 && c->cmsg_type == IPV6_PKTINFO) {
        in6_pktinfo info{};
        std::memcpy(&info, CMSG_DATA(c), sizeof info);
        target.ss_family = AF_INET6;
        reinterpret_cast<sockaddr_in6&>(target).sin6_addr = info.ipi6_addr;
        index = info.ipi6_ifindex;
      }
    }
    if (index == 0) return;
    arrival.to.host = FromSocket(target).host;
    if (const Interface* found = FindInterface(interfaces_, index)) arrival.interface = found->name;
  }

  Descriptor fd_;
  std::vector<Interface> interfaces_;
  Endpoint local_;
};

// A listening socket and its connections, all in one epoll instance.
class TcpListener final : public Listener {
 public:
  TcpListener(Descriptor listener, Descriptor epoll)
      : listener_(std::move(listener)), epoll_(std::move(epoll)) {
    Watch(listener_.get(), nullptr);
  }

  int fd() const override { return epoll_.get(); }

  void Listen(Notebook& notes) override {
    std::array<epoll_event, kMaxConnections> events;
    const int ready = epoll_wait(epoll_.get(), events.data(), events.size(), 0);
    for (int i = 0; i < ready; ++i) {
      auto* connection = static_cast<Connection*>(events[static_cast<std::size_t>(i)].data.ptr);
      if (connection == nullptr) {
        Accept();
      } else {
        Read(*connection, notes);
      }
    }
  }

 private:
  struct Connection {
    Descriptor fd;
    Endpoint to, from;
    std::vector<std::byte> received;
  };

  void Watch(int fd, Connection* connection) {
    epoll_event event{};
    event.events = EPOLLIN;
    event.data.ptr = connection;
    epoll_ctl(epoll_.get(), EPOLL_CTL_ADD, fd, &event);
  }

  void Accept() {
    sockaddr_storage address{};
    socklen_t size = sizeof address;
    Descriptor fd(accept4(listener_.get(), reinterpret_cast<sockaddr*>(&address), &size,
                          SOCK_NONBLOCK | SOCK_CLOEXEC));
    if (fd.get() < 0 || connections_.size() >= kMaxConnections) return;
    auto connection = std::make_unique<Connection>();
    connection->from = FromSocket(address);
    size = sizeof address;
    getsockname(fd.get(), reinterpret_cast<sockaddr*>(&address), &size);
    connection->to = FromSocket(address);
    connection->fd = std::move(fd);
    Watch(connection->fd.get(), connection.get());
    connections_.push_back(std::move(connection));
  }

  void Read(Connection& connection, Notebook& notes) {
    const ssize_t size = recv(connection.fd.get(), notes.buffer.data(), notes.buffer.size(), 0);
    if (size <= 0) {
      if (size < 0 && (errno == EAGAIN || errno == EINTR)) return;
      std::erase_if(connections_, [&](const auto& owned) { return owned.get() == &connection; });
      return;
    }
    auto& received = connection.received;
    received.insert(received.end(), notes.buffer.begin(), notes.buffer.begin() + size);
    std::span<const std::byte> rest(received);
    while (!rest.empty()) {
      const std::size_t record = RecordSize(rest);
      if (record == 0) break;
      notes.heard.Add({true, connection.to, connection.from, "", notes.now_s, record},
                      notes.sniffer.Sniff(rest.first(record)));
      rest = rest.subspan(record);
    }
    received.erase(received.begin(), received.end() - static_cast<std::ptrdiff_t>(rest.size()));
  }

  Descriptor listener_, epoll_;
  std::vector<std::unique_ptr<Connection>> connections_;
};

}  // namespace

Result<Descriptor> Probe::Bind(bool stream, const std::string& host, std::uint16_t port,
                               int* error) {
  sockaddr_storage address;
  const socklen_t size = ToSocket({host, port}, address);
  if (size == 0) return Status::Error(host + " is not a numeric address");
  const int type = stream ? SOCK_STREAM : SOCK_DGRAM;
  Descriptor fd(socket(address.ss_family, type | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  const auto refuse = [&] {
    *error = errno;
    return Status::Error(std::strerror(errno));
  };
  if (fd.get() < 0) return refuse();
  const int one = 1;
  if (stream) setsockopt(fd.get(), SOL_SOCKET, SO_REUSEADDR, &one, sizeof one);
  if (bind(fd.get(), reinterpret_cast<const sockaddr*>(&address), size) != 0) return refuse();
  if (stream && listen(fd.get(), static_cast<int>(kMaxConnections)) != 0) return refuse();
  return fd;
}

PortState Probe::Open(bool stream, std::uint16_t port, bool v6) {
  PortState state{stream, port, PortState::Kind::kHeard, {}, ""};
  const auto listen = [&](const std::string& host) {
    int error = 0;
    auto fd = Bind(stream, host, port, &error);
    if (!fd.ok()) {
      state.why = fd.status().message();
      return error;
    }
    if (stream) {
      Add(std::make_unique<TcpListener>(std::move(fd.value()),
                                        Descriptor(epoll_create1(EPOLL_CLOEXEC))));
    } else {
      Add(std::make_unique<UdpListener>(std::move(fd.value()), interfaces_));
    }
    return 0;
  };
  const int error = listen(v6 ? "::" : "0.0.0.0");
  if (error == 0) return state;
  if (error != EADDRINUSE) {
    state.kind = PortState::Kind::kRefused;
    return state;
  }
  for (const Interface& interface : interfaces_) {
    if (!interface.up) continue;
    std::vector<std::string> hosts = interface.addresses;
    if (!stream) {
      hosts.insert(hosts.end(), interface.broadcasts.begin(), interface.broadcasts.end());
    }
    for (const auto& host : hosts) {
      const bool other_family = !v6 && host.find(':') != std::string::npos;
      if (!other_family && listen(host) == 0) state.hosts.push_back(host);
    }
  }
  state.kind = state.hosts.empty() ? PortState::Kind::kInUse : PortState::Kind::kPartly;
  state.why.clear();
  return state;
}

std::vector<GroupState> Probe::Join(const std::string& group, std::uint16_t port) {
  std::vector<GroupState> out;
  for (const Interface& interface : interfaces_) {
    if (!interface.up || interface.addresses.empty()) continue;
    GroupState state{group, port, interface.name, ""};
    sockaddr_storage address;
    const socklen_t size = ToSocket({group, port}, address);
    Descriptor fd(socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
    const int one = 1, zero = 0;
    // Like the daemon: other programs of this machine may have joined as well.
    setsockopt(fd.get(), SOL_SOCKET, SO_REUSEADDR, &one, sizeof one);
    setsockopt(fd.get(), IPPROTO_IP, IP_MULTICAST_ALL, &zero, sizeof zero);
    ip_mreqn membership{};
    membership.imr_multiaddr = reinterpret_cast<const sockaddr_in&>(address).sin_addr;
    membership.imr_ifindex = static_cast<int>(interface.index);
    if (bind(fd.get(), reinterpret_cast<const sockaddr*>(&address), size) != 0 ||
        setsockopt(fd.get(), IPPROTO_IP, IP_ADD_MEMBERSHIP, &membership, sizeof membership) != 0) {
      state.why = std::strerror(errno);
    } else {
      Add(std::make_unique<UdpListener>(std::move(fd), interfaces_));
    }
    out.push_back(std::move(state));
  }
  return out;
}

void Probe::Run(double seconds) {
  using Clock = std::chrono::steady_clock;
  const auto start = Clock::now();
  double next_tick_s = 0;
  while (true) {
    notes_->now_s = std::chrono::duration<double>(Clock::now() - start).count();
    if (notes_->now_s >= seconds) return;
    if (notes_->now_s >= next_tick_s) {
      next_tick_s = notes_->now_s + kTick_s;
      for (const auto& listener : listeners_) listener->Tick(notes_->now_s);
    }
    std::vector<pollfd> polled;
    polled.reserve(listeners_.size());
    for (const auto& listener : listeners_) polled.push_back({listener->fd(), POLLIN, 0});
    const double wait_s = std::min(next_tick_s, seconds) - notes_->now_s;
    poll(polled.data(), polled.size(), std::max(1, static_cast<int>(wait_s * 1000)));
    notes_->now_s = std::chrono::duration<double>(Clock::now() - start).count();
    for (std::size_t i = 0; i < polled.size(); ++i) {
      if (polled[i].revents != 0) listeners_[i]->Listen(*notes_);
    }
  }
}

}  // namespace styled::doctor
