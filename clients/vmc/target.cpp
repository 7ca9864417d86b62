#include "clients/vmc/target.h"

#include <netinet/in.h>
#include <sys/socket.h>

#include <array>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/udp.hpp>
#include <optional>
#include <utility>

#include "clients/cpp/subscriber.h"

namespace styled::stylevmc {
namespace {

namespace asio = boost::asio;
using asio::ip::udp;
using boost::system::error_code;

bool IsPort(const std::string& text) {
  if (text.empty() || text.size() > 5) return false;
  if (text.find_first_not_of("0123456789") != std::string::npos) return false;
  const int port = std::stoi(text);
  return port >= 1 && port <= 65535;
}

}  // namespace

Result<TargetSpec> ParseTarget(const std::string& text) {
  const auto wrong = [&text](const std::string& found) {
    return Status::Error("--to '" + text + "': " + found +
                         "; expected [PERFORMER=]HOST:PORT, e.g. 127.0.0.1:39539");
  };
  TargetSpec spec;
  const std::size_t sign = text.find('=');
  if (sign != std::string::npos) {
    spec.performer = text.substr(0, sign);
    if (!client::IsPerformerId(spec.performer)) {
      return wrong("'" + spec.performer + "' is not SOURCE.NAME");
    }
  }
  spec.text = sign == std::string::npos ? text : text.substr(sign + 1);
  const std::size_t colon = spec.text.rfind(':');
  if (colon == std::string::npos || colon == 0) return wrong("no host or no port");
  spec.host = spec.text.substr(0, colon);
  spec.port = spec.text.substr(colon + 1);
  if (!IsPort(spec.port)) return wrong("port '" + spec.port + "' is not 1 to 65535");
  if (spec.host.front() == '[' && spec.host.back() == ']') {
    spec.host = spec.host.substr(1, spec.host.size() - 2);
  } else if (spec.host.find(':') != std::string::npos) {
    return wrong("an IPv6 address stands in brackets");
  }
  if (spec.host.empty()) return wrong("no host");
  return spec;
}

struct Target::Impl {
  std::string text;
  asio::io_context context;
  udp::socket socket{context};
  udp::endpoint endpoint;
  std::optional<std::chrono::steady_clock::time_point> refused;  // when it was last answered so
  std::chrono::steady_clock::time_point sent;                    // the newest datagram
};

Target::Target(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Target::~Target() = default;

Result<std::unique_ptr<Target>> Target::Open(const TargetSpec& spec) {
  auto impl = std::make_unique<Impl>();
  impl->text = spec.text;
  const auto failed = [&spec](const error_code& error) {
    return Status::Error("--to " + spec.text + ": " + error.message());
  };
  error_code error;
  udp::resolver resolver(impl->context);
  const auto found = resolver.resolve(spec.host, spec.port, error);
  if (error) return failed(error);
  impl->endpoint = found.begin()->endpoint();
  for (const auto& entry : found) {
    if (!entry.endpoint().address().is_v4()) continue;
    impl->endpoint = entry.endpoint();
    break;
  }
  impl->socket.open(impl->endpoint.protocol(), error);
  if (error) return failed(error);
  impl->socket.non_blocking(true, error);
  if (error) return failed(error);
  impl->socket.set_option(asio::socket_base::broadcast(true), error);  // IPv6 has no broadcast
  // Where this fails, the answers of absent applications are not seen, and frames go out all the
  // same.
  const int on = 1;
  const bool v4 = impl->endpoint.address().is_v4();
  (void)setsockopt(impl->socket.native_handle(), v4 ? IPPROTO_IP : IPPROTO_IPV6,
                   v4 ? IP_RECVERR : IPV6_RECVERR, &on, sizeof on);
  return std::unique_ptr<Target>(new Target(std::move(impl)));
}

// The ICMP answer to an earlier datagram makes a send fail, and this datagram is not sent: it is
// sent again. The answers are taken out, else they fill the socket's buffer.
std::string Target::Send(std::span<const std::byte> datagram) {
  error_code error;
  const auto send = [&] {
    impl_->socket.send_to(asio::buffer(datagram.data(), datagram.size()), impl_->endpoint, 0,
                          error);
  };
  impl_->sent = std::chrono::steady_clock::now();
  send();
  if (!error) return {};
  const error_code first = error;
  bool answered = false;
  std::array<std::byte, 1> none{};
  // A limit, since qemu's emulation of Linux gives 0 where there is no answer.
  for (int i = 0; i < 64 && recv(impl_->socket.native_handle(), none.data(), none.size(),
                                 MSG_ERRQUEUE | MSG_DONTWAIT) >= 0;
       ++i) {
    answered = true;
  }
  if (!answered) return error.message();
  if (first == asio::error::connection_refused) impl_->refused = impl_->sent;
  send();
  if (!error) error = first;  // no route to the machine is an error, too
  return error == asio::error::connection_refused ? std::string() : error.message();
}

bool Target::NoListener() const {
  return impl_->refused && impl_->sent - *impl_->refused < kTellsFor;
}

const std::string& Target::text() const { return impl_->text; }

}  // namespace styled::stylevmc
