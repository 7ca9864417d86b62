#pragma once

#include <atomic>

namespace styled::client {

// For a subscribing program, once, at the start of main: the flag that SIGINT and SIGTERM set. A
// signal also ends a wait for messages. SIGPIPE is ignored, and protobuf does not log messages that
// it cannot parse: the clients count them.
const std::atomic<bool>& StopOnSignals();

}  // namespace styled::client
