#include "clients/vmc/target.h"

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/udp.hpp>
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
  return std::unique_ptr<Target>(new Target(std::move(impl)));
}

// The socket is not connected. On a connected one, the ICMP reply of an absent application would
// make the next send fail.
std::string Target::Send(std::span<const std::byte> datagram) {
  error_code error;
  impl_->socket.send_to(asio::buffer(datagram.data(), datagram.size()), impl_->endpoint, 0, error);
  return error ? error.message() : std::string();
}

const std::string& Target::text() const { return impl_->text; }

}  // namespace styled::stylevmc
