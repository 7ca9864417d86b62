#pragma once

#include <boost/asio/ip/tcp.hpp>

namespace styled::web {

class Gateway;

// Serves one HTTP connection: the page, /metrics and /healthz; a request for /ws becomes a
// browser's WebSocket (session.h). Request size and duration are limited. Call on the loop's
// thread.
void Serve(boost::asio::ip::tcp::socket socket, Gateway& gateway);

}  // namespace styled::web
