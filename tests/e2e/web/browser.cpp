#include "tests/e2e/web/browser.h"

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <chrono>

namespace styled::support {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = boost::beast::http;
using asio::ip::tcp;

constexpr std::chrono::seconds kPatience(10);

tcp::endpoint EndpointOf(const std::string& address) {
  const std::string host_port = address.substr(address.find("//") + 2);
  const std::size_t colon = host_port.rfind(':');
  return {asio::ip::make_address(host_port.substr(0, colon)),
          static_cast<std::uint16_t>(std::stoi(host_port.substr(colon + 1)))};
}

std::string HostOf(const std::string& address) { return address.substr(address.find("//") + 2); }

}  // namespace

HttpReply Ask(const std::string& address, const std::string& target, const Headers& headers,
              const std::string& method) {
  asio::io_context io;
  beast::tcp_stream stream(io);
  HttpReply reply;
  beast::error_code error;
  stream.socket().open(tcp::v4());
  stream.socket().connect(EndpointOf(address), error);
  if (error) return reply;
  http::request<http::string_body> request;
  request.method_string(method);
  request.target(target);
  request.version(11);
  request.set(http::field::host, HostOf(address));
  for (const auto& [name, value] : headers) request.set(name, value);
  http::write(stream, request, error);
  beast::flat_buffer buffer;
  http::response_parser<http::string_body> parser;
  if (method == "HEAD") parser.skip(true);
  stream.expires_after(kPatience);
  http::async_read(stream, buffer, parser,
                   [&error](beast::error_code result, std::size_t) { error = result; });
  io.run();
  if (error) return reply;
  reply.status = parser.get().result_int();
  reply.type = parser.get()[http::field::content_type];
  reply.body = parser.get().body();
  return reply;
}

struct BrowserLink::Impl {
  asio::io_context io;
  beast::websocket::stream<beast::tcp_stream> socket{io};
  beast::flat_buffer buffer;
  int status = 0;
  bool reading = false, arrived = false, closed = false;

  void Run(double seconds, const bool& done) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
    io.restart();
    while (!done && !closed && std::chrono::steady_clock::now() < end) {
      if (io.run_one_until(
              std::chrono::time_point_cast<std::chrono::steady_clock::duration>(end)) == 0) {
        break;
      }
    }
  }
};

BrowserLink::BrowserLink(const std::string& address, const std::string& target,
                         const Headers& headers, int receive_buffer_bytes)
    : impl_(std::make_unique<Impl>()) {
  Impl& impl = *impl_;
  tcp::socket& socket = beast::get_lowest_layer(impl.socket).socket();
  socket.open(tcp::v4());
  if (receive_buffer_bytes > 0) {
    socket.set_option(asio::socket_base::receive_buffer_size(receive_buffer_bytes));
  }
  beast::error_code error;
  socket.connect(EndpointOf(address), error);
  if (error) return;
  impl.socket.set_option(
      beast::websocket::stream_base::decorator([&headers](beast::websocket::request_type& request) {
        for (const auto& [name, value] : headers) request.set(name, value);
      }));
  beast::websocket::response_type response;
  bool done = false;
  const auto host = headers.find("Host");
  impl.socket.async_handshake(response, host == headers.end() ? HostOf(address) : host->second,
                              target, [&](beast::error_code result) {
                                error = result;
                                done = true;
                              });
  impl.Run(std::chrono::duration<double>(kPatience).count(), done);
  const bool answered = done && (!error || error == beast::websocket::error::upgrade_declined);
  impl.status = answered ? static_cast<int>(response.result_int()) : 0;
  impl.closed = impl.status != 101;
}

BrowserLink::~BrowserLink() = default;

int BrowserLink::status() const { return impl_->status; }
bool BrowserLink::closed() const { return impl_->closed; }

void BrowserLink::SendText(const std::string& text) {
  impl_->socket.text(true);
  beast::error_code error;
  impl_->socket.write(asio::buffer(text), error);
  impl_->closed = impl_->closed || error;
}

void BrowserLink::SendBinary(const std::string& bytes) {
  impl_->socket.binary(true);
  beast::error_code error;
  impl_->socket.write(asio::buffer(bytes), error);
  impl_->closed = impl_->closed || error;
}

std::optional<Received> BrowserLink::Receive(double seconds) {
  Impl& impl = *impl_;
  if (impl.closed) return std::nullopt;
  if (!impl.reading) {
    impl.reading = true;
    impl.arrived = false;
    impl.socket.async_read(impl.buffer, [&impl](beast::error_code error, std::size_t) {
      impl.reading = false;
      impl.arrived = !error;
      impl.closed = impl.closed || error;
    });
  }
  impl.Run(seconds, impl.arrived);
  if (!impl.arrived) return std::nullopt;
  impl.arrived = false;
  const std::string bytes = beast::buffers_to_string(impl.buffer.data());
  impl.buffer.consume(impl.buffer.size());
  if (impl.socket.got_text()) return Received{true, "", bytes};
  const auto length = static_cast<unsigned char>(bytes.at(0));
  return Received{false, bytes.substr(1, length), bytes.substr(1 + length)};
}

}  // namespace styled::support
