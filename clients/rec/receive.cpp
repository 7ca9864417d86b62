#include "clients/rec/receive.h"

#include <arpa/inet.h>
#include <netdb.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "proto/recording/recording_thread.h"
#include "proto/recording/writer.h"

namespace styled::rec {
namespace {

using recording::AddressText;
using recording::MonotonicNow_ns;

constexpr std::size_t kMaxPeers = 64;
constexpr int kDatagrams = 256, kReceiveBuffer = 4 << 20;
constexpr std::int64_t kLongestPoll_ns = 100'000'000;

struct Address {
  sockaddr_storage storage{};
  socklen_t size = sizeof storage;
  sockaddr* get() { return reinterpret_cast<sockaddr*>(&storage); }
  const sockaddr* get() const { return reinterpret_cast<const sockaddr*>(&storage); }
  std::string text() const { return AddressText(get(), size); }
};

// "HOST:PORT", IPv6 hosts in brackets; `what` is for messages.
Result<Address> Resolve(const std::string& what, const std::string& text, bool numeric) {
  const std::size_t colon = text.rfind(':');
  const auto wrong = [&](const std::string& found) {
    return Status::Error(what + " " + text + ": " + found + "; expected HOST:PORT");
  };
  if (colon == std::string::npos || colon == 0) return wrong("no host or no port");
  std::string host = text.substr(0, colon);
  const std::string port = text.substr(colon + 1);
  if (host.size() > 2 && host.front() == '[' && host.back() == ']') {
    host = host.substr(1, host.size() - 2);
  }
  if (port.empty() || port.size() > 5 ||
      port.find_first_not_of("0123456789") != std::string::npos || std::stoi(port) > 65535) {
    return wrong("port '" + port + "'");
  }
  addrinfo hints{};
  hints.ai_socktype = SOCK_DGRAM;
  hints.ai_flags = AI_NUMERICSERV | (numeric ? AI_NUMERICHOST : 0);
  addrinfo* found = nullptr;
  const int error = getaddrinfo(host.c_str(), port.c_str(), &hints, &found);
  if (error != 0) return wrong(gai_strerror(error));
  Address address;
  address.size = found->ai_addrlen;
  std::memcpy(&address.storage, found->ai_addr, found->ai_addrlen);
  freeaddrinfo(found);
  return address;
}

}  // namespace

struct Receiver::Socket {
  ~Socket() {
    if (fd >= 0) close(fd);
  }
  Port port;
  int fd = -1;
  std::string endpoint;
  bool forwards = false;
  Address to;
  Address from;                  // of the current datagram
  std::uint32_t overflowed = 0;  // last value of the kernel's drop counter
};

struct Receiver::Peer {
  ~Peer() {
    if (fd >= 0) close(fd);
  }
  Socket* socket = nullptr;
  Address rig;
  int fd = -1;  // connected to the socket's `to`
};

Receiver::~Receiver() = default;

Result<std::unique_ptr<Receiver>> Receiver::Open(std::vector<Port> ports) {
  std::unique_ptr<Receiver> receiver(new Receiver());
  for (Port& port : ports) {
    Status status = receiver->Bind(std::move(port));
    if (!status.ok()) return status;
  }
  return receiver;
}

Status Receiver::Bind(Port port) {
  auto socket = std::make_unique<Socket>();
  const auto address = Resolve("--listen", port.listen, true);
  if (!address.ok()) return address.status();
  if (!port.forward.empty()) {
    const auto to = Resolve("--forward", port.forward, false);
    if (!to.ok()) return to.status();
    socket->to = to.value();
    socket->forwards = true;
  }
  const int family = address.value().get()->sa_family;
  socket->fd = ::socket(family, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (socket->fd < 0 || bind(socket->fd, address.value().get(), address.value().size) != 0) {
    return Status::Error("--listen " + port.listen + ": " + std::strerror(errno));
  }
  // A refused buffer size is not an error: a quiet machine does not need it.
  (void)setsockopt(socket->fd, SOL_SOCKET, SO_RCVBUF, &kReceiveBuffer, sizeof kReceiveBuffer);
  constexpr int kOn = 1;
  (void)setsockopt(socket->fd, SOL_SOCKET, SO_RXQ_OVFL, &kOn, sizeof kOn);
  Address bound;
  (void)getsockname(socket->fd, bound.get(), &bound.size);
  socket->endpoint = "udp://" + bound.text();
  socket->port = std::move(port);
  sockets_.push_back(std::move(socket));
  return Status::Ok();
}

std::vector<std::string> Receiver::endpoints() const {
  std::vector<std::string> endpoints;
  endpoints.reserve(sockets_.size());
  for (const auto& socket : sockets_) endpoints.push_back(socket->endpoint);
  return endpoints;
}

Status Receiver::Run(recording::FileWriter& writer, double seconds, const std::atomic<bool>& stop) {
  recording::PreferThisThread();
  const std::int64_t begin_ns = MonotonicNow_ns();
  std::vector<pollfd> waiting;
  Status status = Status::Ok();
  while (status.ok() && !stop) {
    const std::int64_t now_ns = MonotonicNow_ns();
    if (seconds > 0 && static_cast<double>(now_ns - begin_ns) * 1e-9 >= seconds) break;
    const std::int64_t wait_ns =
        std::clamp<std::int64_t>(writer.NextDeadline_ns() - now_ns, 0, kLongestPoll_ns);
    waiting.clear();
    for (const auto& socket : sockets_) waiting.push_back({socket->fd, POLLIN, 0});
    for (const auto& peer : peers_) waiting.push_back({peer->fd, POLLIN, 0});
    (void)poll(waiting.data(), waiting.size(), static_cast<int>((wait_ns + 999'999) / 1'000'000));
    for (const auto& peer : peers_) PassBack(*peer);
    for (const auto& socket : sockets_) {
      if (status.ok()) status = Drain(*socket, writer);
    }
    if (status.ok()) status = writer.Poll(MonotonicNow_ns());
  }
  const Status flushed = writer.Flush();
  return status.ok() ? flushed : status;
}

Status Receiver::Drain(Socket& socket, recording::FileWriter& writer) {
  for (int i = 0; i < kDatagrams; ++i) {
    iovec piece{buffer_.data(), buffer_.size()};
    alignas(cmsghdr) char control[64];
    msghdr message{};
    message.msg_name = &socket.from.storage;
    message.msg_namelen = sizeof socket.from.storage;
    message.msg_iov = &piece;
    message.msg_iovlen = 1;
    message.msg_control = control;
    message.msg_controllen = sizeof control;
    const ssize_t size = recvmsg(socket.fd, &message, 0);
    // No more data; or an ICMP reply to a datagram that was passed back.
    if (size < 0) return Status::Ok();
    const std::int64_t now_ns = MonotonicNow_ns();
    socket.from.size = message.msg_namelen;
    for (cmsghdr* c = CMSG_FIRSTHDR(&message); c != nullptr; c = CMSG_NXTHDR(&message, c)) {
      if (c->cmsg_level != SOL_SOCKET || c->cmsg_type != SO_RXQ_OVFL) continue;
      std::uint32_t count = 0;
      std::memcpy(&count, CMSG_DATA(c), sizeof count);
      counts_.dropped += count - socket.overflowed;
      socket.overflowed = count;
    }
    if (socket.forwards) Forward(socket, static_cast<std::size_t>(size));
    ++counts_.datagrams;
    counts_.bytes += static_cast<std::uint64_t>(size);
    record_.set_time_ns(now_ns);
    recording::Arrival& arrival = *record_.mutable_arrival();
    arrival.set_source(socket.port.name);
    arrival.set_type(socket.port.type);
    arrival.set_listen(socket.endpoint);
    arrival.set_peer(socket.from.text());
    arrival.set_datagram(buffer_.data(), static_cast<std::size_t>(size));
    Status status = writer.Add(record_, now_ns);
    if (!status.ok()) return status;
  }
  return Status::Ok();
}

void Receiver::Forward(Socket& socket, std::size_t size) {
  const auto same = [&](const std::unique_ptr<Peer>& peer) {
    return peer->socket == &socket && peer->rig.size == socket.from.size &&
           std::memcmp(&peer->rig.storage, &socket.from.storage, socket.from.size) == 0;
  };
  auto found = std::find_if(peers_.begin(), peers_.end(), same);
  if (found == peers_.end()) {
    if (peers_.size() == kMaxPeers) return;
    auto peer = std::make_unique<Peer>();
    peer->socket = &socket;
    peer->rig = socket.from;
    peer->fd = ::socket(socket.to.get()->sa_family, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    if (peer->fd < 0 || connect(peer->fd, socket.to.get(), socket.to.size) != 0) return;
    peers_.push_back(std::move(peer));
    found = peers_.end() - 1;
  }
  // The first send may only return the ICMP refusal of the previous datagram, so it is retried
  // once.
  for (int attempt = 0; attempt < 2; ++attempt) {
    if (send((*found)->fd, buffer_.data(), size, 0) < 0) continue;
    ++counts_.forwarded;
    return;
  }
}

void Receiver::PassBack(Peer& peer) {
  for (int i = 0; i < kDatagrams; ++i) {
    const ssize_t size = recv(peer.fd, buffer_.data(), buffer_.size(), 0);
    if (size < 0) return;
    ++counts_.answered;
    (void)sendto(peer.socket->fd, buffer_.data(), static_cast<std::size_t>(size), 0, peer.rig.get(),
                 peer.rig.size);
  }
}

}  // namespace styled::rec
