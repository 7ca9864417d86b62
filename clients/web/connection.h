#pragma once

#include <boost/asio/ip/tcp.hpp>

namespace styled::web {

class Gateway;

// Answers what comes over one connection: the page, /metrics, /healthz; at /ws it becomes a
// browser's WebSocket (session.h). Requests are small, and slow ones are given up. The loop's
// thread.
void Serve(boost::asio::ip::tcp::socket socket, Gateway& gateway);

}  // namespace styled::web
