#pragma once

#include <boost/asio/awaitable.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/message.hpp>

namespace styled::web {

class Gateway;

// Accepts the upgrade `request` and serves one browser (clients/web/WIRE.md) until it disconnects.
// A browser that does not answer pings for 30 s is disconnected.
boost::asio::awaitable<void> RunSession(
    boost::beast::tcp_stream stream,
    boost::beast::http::request<boost::beast::http::empty_body> request, Gateway& gateway);

}  // namespace styled::web
