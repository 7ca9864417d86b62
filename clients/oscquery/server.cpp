#include "clients/oscquery/server.h"

#include <boost/asio/as_tuple.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <chrono>
#include <list>
#include <utility>

namespace styled::oscquery {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = boost::beast::http;
using asio::ip::tcp;
using Request = http::request<http::empty_body>;
using Response = http::response<http::string_body>;

constexpr std::size_t kMaxRequestBytes = 8 << 10;
constexpr std::chrono::milliseconds kAcceptRetry(200);  // out of descriptors
constexpr auto kAwait = asio::as_tuple(asio::use_awaitable);

// The address at which the client has reached us, as it can send OSC to it.
std::string OwnAddress(const beast::tcp_stream& stream) {
  boost::system::error_code error;
  const auto endpoint = stream.socket().local_endpoint(error);
  if (error) return "";
  const asio::ip::address address = endpoint.address();
  if (address.is_v6() && address.to_v6().is_v4_mapped()) {
    return asio::ip::make_address_v4(asio::ip::v4_mapped, address.to_v6()).to_string();
  }
  return address.to_string();
}

Response Plain(unsigned status, const std::string& text) {
  Response response(http::int_to_status(status), 11);
  response.set(http::field::content_type, "text/plain; charset=utf-8");
  if (status != 204) response.body() = text + "\n";
  return response;
}

Response Respond(const Request& request, const Description& description, const std::string& own) {
  if (request.method() != http::verb::get && request.method() != http::verb::head) {
    return Plain(405, "only GET and HEAD are answered");
  }
  const std::string_view target(request.target().data(), request.target().size());
  const Answer answer = AnswerTo(target, description, own);
  if (answer.status != 200) return Plain(answer.status, answer.text);
  Response response(http::status::ok, 11);
  response.set(http::field::content_type, "application/json");
  response.body() = answer.text;
  return response;
}

}  // namespace

struct Server::Impl {
  explicit Impl(asio::io_context& io_context) : io(io_context), acceptor(io) {}

  Status Listen(const tcp::endpoint& endpoint);
  static asio::awaitable<void> Accept(std::shared_ptr<Impl> self);
  static asio::awaitable<void> Converse(std::shared_ptr<Impl> self, tcp::socket socket);

  asio::io_context& io;
  tcp::acceptor acceptor;
  std::uint16_t port = 0;
  Description description;
  std::chrono::milliseconds request_time{};
  bool ended = false;
  std::list<beast::tcp_stream*> open;  // the oldest first
};

Status Server::Impl::Listen(const tcp::endpoint& endpoint) {
  boost::system::error_code error;
  const auto step = [&error](auto&& action) {
    if (!error) action();
  };
  if (acceptor.is_open()) acceptor.close(error);
  error = {};
  step([&] { acceptor.open(endpoint.protocol(), error); });
  step([&] { acceptor.set_option(tcp::acceptor::reuse_address(true), error); });
  step([&] { acceptor.bind(endpoint, error); });
  step([&] { acceptor.listen(asio::socket_base::max_listen_connections, error); });
  step([&] { port = acceptor.local_endpoint(error).port(); });
  return error ? Status::Error(error.message()) : Status::Ok();
}

asio::awaitable<void> Server::Impl::Accept(std::shared_ptr<Impl> self) {
  while (!self->ended) {
    auto [error, socket] = co_await self->acceptor.async_accept(kAwait);
    if (self->ended) co_return;
    if (error) {
      asio::steady_timer timer(self->io, kAcceptRetry);
      co_await timer.async_wait(kAwait);
      continue;
    }
    if (self->open.size() >= kMaxConnections) {
      self->open.front()->close();
      self->open.pop_front();
    }
    asio::co_spawn(self->io, Converse(self, std::move(socket)), asio::detached);
  }
}

// Its stream is in `open` until it ends, or is closed to make room.
asio::awaitable<void> Server::Impl::Converse(std::shared_ptr<Impl> self, tcp::socket socket) {
  beast::tcp_stream stream(std::move(socket));
  self->open.push_back(&stream);
  struct Leave {
    Impl& impl;
    beast::tcp_stream* stream;
    ~Leave() { impl.open.remove(stream); }
  } const leave{*self, &stream};

  stream.expires_after(self->request_time);  // for all of the request and its answer
  beast::flat_buffer buffer(kMaxRequestBytes);
  http::request_parser<http::empty_body> parser;
  parser.header_limit(kMaxRequestBytes);
  const auto [error, size] = co_await http::async_read(stream, buffer, parser, kAwait);
  // The client is gone, too slow, or was closed to make room.
  const bool http = error.category() == http::make_error_code(http::error{}).category();
  if (error && (!http || error == http::error::end_of_stream)) co_return;
  Response response = error ? Plain(400, error.message())
                            : Respond(parser.get(), self->description, OwnAddress(stream));
  response.keep_alive(false);
  response.prepare_payload();
  const bool head = !error && parser.get().method() == http::verb::head;
  if (head) {
    const auto length = response.body().size();
    response.body().clear();
    response.content_length(length);
  }
  http::response_serializer<http::string_body> serializer(response);
  const auto written = head ? co_await http::async_write_header(stream, serializer, kAwait)
                            : co_await http::async_write(stream, serializer, kAwait);
  if (std::get<0>(written)) co_return;
  boost::system::error_code ignored;
  stream.socket().shutdown(tcp::socket::shutdown_send, ignored);
}

Server::Server(std::shared_ptr<Impl> impl) : impl_(std::move(impl)) {}

Server::~Server() {
  impl_->ended = true;
  boost::system::error_code ignored;
  impl_->acceptor.close(ignored);
  for (beast::tcp_stream* stream : impl_->open) stream->close();
}

Result<std::unique_ptr<Server>> Server::Start(asio::io_context& io, const std::string& address,
                                              Description description,
                                              std::chrono::milliseconds request_time) {
  auto impl = std::make_shared<Impl>(io);
  boost::system::error_code error;
  const auto numeric = asio::ip::make_address(address, error);
  if (error) return Status::Error("'" + address + "' is not a numeric address");
  if (!impl->Listen({numeric, description.osc_port}).ok()) {
    const Status status = impl->Listen({numeric, 0});
    if (!status.ok()) return Status::Error("HTTP at " + address + ": " + status.message());
  }
  impl->description = std::move(description);
  impl->request_time = request_time;
  asio::co_spawn(io, Impl::Accept(impl), asio::detached);
  return std::unique_ptr<Server>(new Server(std::move(impl)));
}

std::uint16_t Server::port() const { return impl_->port; }
void Server::Rename(const std::string& name) { impl_->description.name = name; }

}  // namespace styled::oscquery
