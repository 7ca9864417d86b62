#include "sim/player/link.h"

#include <linux/errqueue.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <array>
#include <boost/asio/connect.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ip/udp.hpp>
#include <boost/asio/write.hpp>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <map>
#include <thread>

namespace styled::player {
namespace {

namespace asio = boost::asio;
using boost::system::error_code;

struct Address {
  std::string protocol, host, port;
};

Result<Address> ParseAddress(const std::string& url, int lowest_port) {
  const auto wrong = [&url](const std::string& found) {
    return Status::Error("'" + url + "': " + found +
                         ", expected udp://HOST:PORT or tcp://HOST:PORT");
  };
  const std::size_t scheme = url.find("://");
  if (scheme == std::string::npos) return wrong("no protocol");
  Address address;
  address.protocol = url.substr(0, scheme);
  if (address.protocol != "udp" && address.protocol != "tcp") {
    return wrong("protocol '" + address.protocol + "'");
  }
  const std::string rest = url.substr(scheme + 3);
  const std::size_t colon = rest.rfind(':');
  if (colon == std::string::npos || colon == 0) return wrong("no host or no port");
  address.host = rest.substr(0, colon);
  address.port = rest.substr(colon + 1);
  if (address.host.size() > 2 && address.host.front() == '[' && address.host.back() == ']') {
    address.host = address.host.substr(1, address.host.size() - 2);
  }
  const bool digits = address.port.find_first_not_of("0123456789") == std::string::npos;
  if (!digits || address.port.empty() || address.port.size() > 5 ||
      std::stoi(address.port) < lowest_port || std::stoi(address.port) > 65535) {
    return wrong("port '" + address.port + "'");
  }
  return address;
}

std::size_t ReceiveFrom(asio::ip::udp::socket& socket, std::span<std::byte> datagram,
                        asio::ip::udp::endpoint& sender) {
  error_code error;
  socket.non_blocking(true, error);
  const std::size_t size =
      socket.receive_from(asio::buffer(datagram.data(), datagram.size()), sender, 0, error);
  return error ? 0 : size;  // sends still wait for buffer space: Asio polls
}

class UdpLink final : public Link {
 public:
  Status Open(const Address& address) {
    error_code error;
    asio::ip::udp::resolver resolver(context_);
    const auto found = resolver.resolve(address.host, address.port, error);
    if (error) return Status::Error(error.message());
    receiver_ = found.begin()->endpoint();
    socket_.open(receiver_.protocol(), error);
    if (error) return Status::Error(error.message());
    // Oversized datagrams need this buffer; if it is refused, the default remains.
    socket_.set_option(asio::socket_base::send_buffer_size(1 << 20), error);
    RequestErrors();
    return Status::Ok();
  }

  // The socket is not connected, since rigs reply from other ports, too. ICMP errors (no listener)
  // are read from the socket's error queue. If such an error is returned instead of sending a
  // datagram, the datagram is sent again.
  Status Send(std::span<const std::byte> datagram) override {
    error_code error;
    for (int attempt = 0; attempt < kAttempts; ++attempt) {
      socket_.send_to(asio::buffer(datagram.data(), datagram.size()), receiver_, 0, error);
      if (!error) return Status::Ok();
      if (!ReadErrors()) break;
    }
    return Status::Error("sending by UDP: " + error.message());
  }

  std::size_t Receive(std::span<std::byte> datagram) override {
    return ReceiveFrom(socket_, datagram, sender_);
  }

  std::uint64_t refused() override {
    ReadErrors();
    return refused_;
  }

 private:
  static constexpr int kAttempts = 4;  // errors may arrive as fast as datagrams leave

  void RequestErrors() {
    const int on = 1;
    if (receiver_.address().is_v6()) {
      setsockopt(socket_.native_handle(), IPPROTO_IPV6, IPV6_RECVERR, &on, sizeof on);
    } else {
      setsockopt(socket_.native_handle(), IPPROTO_IP, IP_RECVERR, &on, sizeof on);
    }
  }

  // Empties the error queue. False: it was empty.
  bool ReadErrors() {
    bool any = false;
    alignas(cmsghdr) std::array<char, 512> control{};
    for (;;) {
      msghdr message{};
      message.msg_control = control.data();
      message.msg_controllen = control.size();
      if (recvmsg(socket_.native_handle(), &message, MSG_ERRQUEUE | MSG_DONTWAIT) < 0) return any;
      any = true;
      for (const cmsghdr* part = CMSG_FIRSTHDR(&message); part != nullptr;
           part = CMSG_NXTHDR(&message, const_cast<cmsghdr*>(part))) {
        const bool ours = (part->cmsg_level == IPPROTO_IP && part->cmsg_type == IP_RECVERR) ||
                          (part->cmsg_level == IPPROTO_IPV6 && part->cmsg_type == IPV6_RECVERR);
        if (!ours) continue;
        sock_extended_err what{};
        std::memcpy(&what, CMSG_DATA(part), sizeof what);
        if (what.ee_errno == ECONNREFUSED) ++refused_;
      }
    }
  }

  asio::io_context context_;
  asio::ip::udp::socket socket_{context_};
  asio::ip::udp::endpoint receiver_, sender_;
  std::uint64_t refused_ = 0;
};

class ServerLink final : public Link {
 public:
  explicit ServerLink(Audience audience) : newest_(audience == Audience::kNewest) {}
  Status Open(const Address& address, std::string* bound) {
    error_code error;
    const auto host = asio::ip::make_address(address.host, error);
    if (error) return Status::Error(error.message() + ", expected a numeric address");
    socket_.open(host.is_v6() ? asio::ip::udp::v6() : asio::ip::udp::v4(), error);
    if (!error) {
      socket_.bind({host, static_cast<std::uint16_t>(std::stoi(address.port))}, error);
    }
    if (error) return Status::Error(error.message());
    if (bound != nullptr) {
      *bound = "udp://" + address.host + ":" + std::to_string(socket_.local_endpoint().port());
    }
    return Status::Ok();
  }

  Status Send(std::span<const std::byte> datagram) override {
    const auto now = std::chrono::steady_clock::now();
    std::erase_if(clients_, [&](const auto& client) {
      return !newest_ && now - client.second > std::chrono::seconds(5);
    });
    for (const auto& [client, heard] : clients_) {
      error_code ignored;  // a client that has left is not a reason to stop
      socket_.send_to(asio::buffer(datagram.data(), datagram.size()), client, 0, ignored);
    }
    return Status::Ok();
  }

  std::size_t Receive(std::span<std::byte> datagram) override {
    const std::size_t size = ReceiveFrom(socket_, datagram, sender_);
    if (size == 0) return size;
    if (newest_) clients_.clear();
    clients_[sender_] = std::chrono::steady_clock::now();
    return size;
  }

  Status Answer(std::span<const std::byte> datagram) override {
    error_code error;
    socket_.send_to(asio::buffer(datagram.data(), datagram.size()), sender_, 0, error);
    return Status::Ok();
  }

 private:
  bool newest_;
  asio::io_context context_;
  asio::ip::udp::socket socket_{context_};
  asio::ip::udp::endpoint sender_;
  std::map<asio::ip::udp::endpoint, std::chrono::steady_clock::time_point> clients_;
};

// A lost target is reconnected once a second, without waiting for it: the next records are those of
// a rig that others receive, too.
class TcpLink final : public Link {
 public:
  Status Open(const Address& address, double wait_ms) {
    const auto deadline = Clock::now() + std::chrono::duration<double, std::milli>(wait_ms);
    error_code error;
    asio::ip::tcp::resolver resolver(context_);
    found_ = resolver.resolve(address.host, address.port, error);
    if (error) return Status::Error(error.message());
    while (true) {
      asio::connect(socket_, found_, error);
      if (!error) break;
      if (Clock::now() >= deadline) return Status::Error(error.message());
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    Connected();
    return Status::Ok();
  }

  Status Send(std::span<const std::byte> record) override {
    if (!connected_) Reconnect();
    if (!connected_) return Status::Error(lost_);
    error_code error;
    asio::write(socket_, asio::buffer(record.data(), record.size()), error);
    if (!error) return Status::Ok();
    lost_ = "sending by TCP: " + error.message();
    connected_ = false;
    again_at_ = Clock::now() + kAgain;
    return Status::Error(lost_);
  }

 private:
  using Clock = std::chrono::steady_clock;
  static constexpr std::chrono::seconds kAgain{1};

  void Connected() {
    error_code error;
    socket_.set_option(asio::ip::tcp::no_delay(true), error);
    connected_ = true;
  }
  void Reconnect() {
    if (connecting_) {
      context_.restart();
      context_.poll();
      return;
    }
    if (Clock::now() < again_at_) return;
    again_at_ = Clock::now() + kAgain;
    error_code error;
    socket_.close(error);
    connecting_ = true;
    asio::async_connect(socket_, found_,
                        [this](const error_code& failed, const asio::ip::tcp::endpoint&) {
                          connecting_ = false;
                          if (!failed) Connected();
                        });
  }

  asio::io_context context_;
  asio::ip::tcp::socket socket_{context_};
  asio::ip::tcp::resolver::results_type found_;
  bool connected_ = false, connecting_ = false;
  std::string lost_;              // why it is not connected any more
  Clock::time_point again_at_{};  // the next try
};

class AllLinks final : public Link {
 public:
  AllLinks(std::vector<NamedLink> links, OnFailure on_failure)
      : on_failure_(std::move(on_failure)) {
    for (NamedLink& link : links) links_.push_back({std::move(link), false});
  }
  Status Send(std::span<const std::byte> datagram) override {
    Status failure = Status::Ok();
    std::size_t sent = 0;
    for (Target& target : links_) {
      const Status status = target.named.link->Send(datagram);
      sent += status.ok() ? 1 : 0;
      if (!status.ok() && !target.fails) on_failure_(target.named.url, status.message());
      target.fails = !status.ok();
      if (!status.ok()) failure = Status::Error(target.named.url + ": " + status.message());
    }
    return sent > 0 ? Status::Ok() : failure;
  }
  std::size_t Receive(std::span<std::byte> datagram) override {
    for (const Target& target : links_) {
      if (const std::size_t size = target.named.link->Receive(datagram); size > 0) return size;
    }
    return 0;
  }
  std::uint64_t refused() override {
    std::uint64_t sum = 0;
    for (const Target& target : links_) sum += target.named.link->refused();
    return sum;
  }

 private:
  struct Target {
    NamedLink named;
    bool fails = false;  // the last datagram was not sent
  };
  std::vector<Target> links_;
  OnFailure on_failure_;
};

}  // namespace

bool IsStream(const std::string& url) { return url.starts_with("tcp://"); }

Status CheckAddress(const std::string& url, int lowest_port) {
  const Result<Address> address = ParseAddress(url, lowest_port);
  return address.ok() ? Status::Ok() : address.status();
}

std::unique_ptr<Link> ToAll(std::vector<NamedLink> links, OnFailure on_failure) {
  return std::make_unique<AllLinks>(std::move(links), std::move(on_failure));
}

Result<std::unique_ptr<Link>> Connect(const std::string& url, double start_wait_ms) {
  const Result<Address> address = ParseAddress(url, 1);
  if (!address.ok()) return address.status();
  Status status = Status::Ok();
  std::unique_ptr<Link> link;
  if (IsStream(url)) {
    auto tcp = std::make_unique<TcpLink>();
    status = tcp->Open(address.value(), start_wait_ms);
    link = std::move(tcp);
  } else {
    auto udp = std::make_unique<UdpLink>();
    status = udp->Open(address.value());
    link = std::move(udp);
  }
  if (!status.ok()) return Status::Error(url + ": " + status.message());
  return link;
}

Result<std::unique_ptr<Link>> Listen(const std::string& url, std::string* bound,
                                     Audience audience) {
  const Result<Address> address = ParseAddress(url, 0);
  if (!address.ok()) return address.status();
  if (IsStream(url)) return Status::Error(url + ": expected udp://HOST:PORT");
  auto server = std::make_unique<ServerLink>(audience);
  const Status status = server->Open(address.value(), bound);
  if (!status.ok()) return Status::Error(url + ": " + status.message());
  return std::unique_ptr<Link>(std::move(server));
}

}  // namespace styled::player
