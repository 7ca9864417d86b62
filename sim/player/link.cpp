#include "sim/player/link.h"

#include <boost/asio/connect.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ip/udp.hpp>
#include <boost/asio/write.hpp>
#include <chrono>
#include <thread>

namespace styled::player {
namespace {

namespace asio = boost::asio;
using boost::system::error_code;

struct Address {
  std::string protocol, host, port;
};

Result<Address> ParseAddress(const std::string& url) {
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
  if (!digits || address.port.empty() || address.port.size() > 5 || std::stoi(address.port) < 1 ||
      std::stoi(address.port) > 65535) {
    return wrong("port '" + address.port + "'");
  }
  return address;
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
    // Oversized datagrams need the room; where it is refused, the default is what there is.
    socket_.set_option(asio::socket_base::send_buffer_size(1 << 20), error);
    return Status::Ok();
  }

  // Not connect()ed: an absent receiver's ICMP answers would take the place of datagrams.
  Status Send(std::span<const std::byte> datagram) override {
    error_code error;
    socket_.send_to(asio::buffer(datagram.data(), datagram.size()), receiver_, 0, error);
    return error ? Status::Error("sending by UDP: " + error.message()) : Status::Ok();
  }

 private:
  asio::io_context context_;
  asio::ip::udp::socket socket_{context_};
  asio::ip::udp::endpoint receiver_;
};

class TcpLink final : public Link {
 public:
  Status Open(const Address& address, double wait_ms) {
    using Clock = std::chrono::steady_clock;
    const auto deadline = Clock::now() + std::chrono::duration<double, std::milli>(wait_ms);
    error_code error;
    asio::ip::tcp::resolver resolver(context_);
    const auto found = resolver.resolve(address.host, address.port, error);
    if (error) return Status::Error(error.message());
    while (true) {
      asio::connect(socket_, found, error);
      if (!error) break;
      if (Clock::now() >= deadline) return Status::Error(error.message());
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    socket_.set_option(asio::ip::tcp::no_delay(true), error);
    return Status::Ok();
  }

  Status Send(std::span<const std::byte> record) override {
    error_code error;
    asio::write(socket_, asio::buffer(record.data(), record.size()), error);
    return error ? Status::Error("sending by TCP: " + error.message()) : Status::Ok();
  }

 private:
  asio::io_context context_;
  asio::ip::tcp::socket socket_{context_};
};

}  // namespace

bool IsStream(const std::string& url) { return url.starts_with("tcp://"); }

Result<std::unique_ptr<Link>> Connect(const std::string& url, double start_wait_ms) {
  const Result<Address> address = ParseAddress(url);
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

}  // namespace styled::player
