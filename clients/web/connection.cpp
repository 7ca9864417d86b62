#include "clients/web/connection.h"

#include <boost/asio/as_tuple.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket/rfc6455.hpp>
#include <chrono>
#include <utility>

#include "clients/web/gateway.h"
#include "clients/web/session.h"

namespace styled::web {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = boost::beast::http;
using Request = http::request<http::empty_body>;
using Response = http::response<http::string_body>;

constexpr std::size_t kMaxHeaderBytes = 16 << 10;
constexpr std::chrono::seconds kRequestTimeout(15);
// Limits how stale the data is that a stalled browser receives later.
constexpr int kSendBufferBytes = 64 << 10;
// worker-src: the page splits colour and alpha of a transparent video in a worker that it makes
// itself.
constexpr std::string_view kPolicy =
    "default-src 'self'; script-src 'self'; worker-src 'self' blob:; style-src 'self' "
    "'unsafe-inline'; "
    "img-src 'self' blob: data:; connect-src 'self' blob: data: ws: wss:; object-src 'none'; "
    "base-uri 'none'; form-action 'none'; frame-ancestors 'none'";
constexpr std::string_view kNoPage =
    "styleweb runs, but has no page to show: it was built without node and npm, or --page is "
    "missing. Its WebSocket is at /ws, metrics at /metrics, health at /healthz.\n";

std::string_view View(beast::string_view text) { return {text.data(), text.size()}; }

Verdict JudgeRequest(const Gateway& gateway, const Request& request, bool needs_token) {
  return Judge(gateway.access,
               {.host = View(request[http::field::host]),
                .origin = View(request[http::field::origin]),
                .hosts = request.count(http::field::host),
                .origins = request.count(http::field::origin),
                .authorization = View(request[http::field::authorization]),
                .target = View(request.target())},
               needs_token);
}

Response Plain(http::status status, std::string_view text) {
  Response response(status, 11);
  response.set(http::field::content_type, "text/plain; charset=utf-8");
  response.set(http::field::cache_control, "no-store");
  response.body() = text;
  return response;
}

Response Refuse(Gateway& gateway, Verdict verdict) {
  ++gateway.counters.refused_access;
  const bool token = verdict == Verdict::kToken;
  Response response = Plain(token                        ? http::status::unauthorized
                            : verdict == Verdict::kTwice ? http::status::bad_request
                                                         : http::status::forbidden,
                            std::string(Explain(verdict)) + "\n");
  if (token) response.set(http::field::www_authenticate, "Bearer");
  return response;
}

Response Health(const Gateway& gateway) {
  if (gateway.hub->daemon_up()) return Plain(http::status::ok, "ok\n");
  return Plain(http::status::service_unavailable, gateway.hub->Reason(Hub::Clock::now()) + "\n");
}

Response Metrics(Gateway& gateway) {
  Counters counters = gateway.counters;
  counters.upstream_malformed += gateway.upstream->malformed();
  Response response = Plain(http::status::ok,
                            PrometheusText(counters, gateway.gauges(), gateway.hub->statistics()));
  response.set(http::field::content_type, "text/plain; version=0.0.4; charset=utf-8");
  return response;
}

Response FromPage(const Gateway& gateway, std::string_view target) {
  if (gateway.page.empty() && target.substr(0, target.find('?')) == "/") {
    return Plain(http::status::ok, kNoPage);
  }
  const PageFile* file = gateway.page.Find(target);
  if (file == nullptr) return Plain(http::status::not_found, "there is nothing here\n");
  Response response(http::status::ok, 11);
  response.set(http::field::content_type, file->type);
  response.set(http::field::cache_control,
               file->forever ? "public, max-age=31536000, immutable" : "no-cache");
  response.set("Content-Security-Policy", kPolicy);
  response.set("Referrer-Policy", "no-referrer");
  response.body() = file->bytes;
  return response;
}

Response Respond(Gateway& gateway, const Request& request) {
  const std::string_view target = View(request.target());
  const std::string_view path = target.substr(0, target.find('?'));
  const bool guarded = path == "/metrics" || path == "/ws";
  if (const Verdict verdict = JudgeRequest(gateway, request, guarded);
      verdict != Verdict::kAllowed) {
    return Refuse(gateway, verdict);
  }
  if (request.method() != http::verb::get && request.method() != http::verb::head) {
    return Plain(http::status::method_not_allowed, "only GET and HEAD are answered\n");
  }
  if (path == "/healthz") return Health(gateway);
  if (path == "/metrics") return Metrics(gateway);
  if (path == "/ws") return Plain(http::status::upgrade_required, "a WebSocket is spoken here\n");
  return FromPage(gateway, target);
}

bool IsSocketRequest(const Gateway& gateway, const Request& request) {
  const std::string_view target = View(request.target());
  return beast::websocket::is_upgrade(request) && target.substr(0, target.find('?')) == "/ws" &&
         JudgeRequest(gateway, request, true) == Verdict::kAllowed;
}

asio::awaitable<void> Converse(beast::tcp_stream stream, Gateway& gateway) {
  constexpr auto kAwait = asio::as_tuple(asio::use_awaitable);
  Crowd::Member member(gateway.crowd, [&stream] { stream.close(); });
  beast::flat_buffer buffer(kMaxHeaderBytes);
  for (;;) {
    http::request_parser<http::empty_body> parser;
    parser.header_limit(kMaxHeaderBytes);
    stream.expires_after(kRequestTimeout);
    member.Now(Crowd::State::kReading);
    const auto [error, size] = co_await http::async_read(stream, buffer, parser, kAwait);
    const bool understood = !error;
    // The peer is gone or too slow, or the connection was closed to make room: no reply is
    // possible.
    const bool http = error.category() == http::make_error_code(http::error{}).category();
    if (!understood && (!http || error == http::error::end_of_stream)) co_return;
    if (understood && IsSocketRequest(gateway, parser.get())) {
      member.Now(Crowd::State::kBrowser);
      stream.expires_never();
      co_await RunSession(std::move(stream), parser.release(), gateway);
      co_return;
    }
    Response response = understood ? Respond(gateway, parser.get())
                                   : Plain(http::status::bad_request, error.message() + "\n");
    response.set("X-Content-Type-Options", "nosniff");
    response.keep_alive(understood && parser.get().keep_alive());
    response.prepare_payload();
    if (understood && parser.get().method() == http::verb::head) {
      const auto length = response.body().size();
      response.body().clear();
      response.content_length(length);
    }
    stream.expires_after(kRequestTimeout);
    member.Now(Crowd::State::kWriting);
    const bool head = understood && parser.get().method() == http::verb::head;
    http::response_serializer<http::string_body> serializer(response);
    const auto written = head ? co_await http::async_write_header(stream, serializer, kAwait)
                              : co_await http::async_write(stream, serializer, kAwait);
    if (std::get<0>(written) || !response.keep_alive()) co_return;
  }
}

}  // namespace

void Serve(asio::ip::tcp::socket socket, Gateway& gateway) {
  boost::system::error_code ignored;
  socket.set_option(asio::ip::tcp::no_delay(true), ignored);
  socket.set_option(asio::socket_base::send_buffer_size(kSendBufferBytes), ignored);
  asio::co_spawn(gateway.io, Converse(beast::tcp_stream(std::move(socket)), gateway),
                 asio::detached);
}

}  // namespace styled::web
