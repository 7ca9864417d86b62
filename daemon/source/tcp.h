#pragma once

#include <memory>

#include "daemon/config/config.h"
#include "daemon/runtime/clock.h"
#include "daemon/runtime/counters.h"
#include "daemon/source/translator.h"
#include "daemon/source/transport.h"
#include "model/base/status.h"

namespace styled::source {

// Opens a TCP transport. It carries the native datagrams as records; each connection has a buffer
// of its own. A stream that loses its framing is closed and counted with its reason, and so is a
// connection that sends no whole record within 5 s. When all max_connections are in use, a new
// connection replaces the oldest one that never sent a record, otherwise the one that was silent
// for longest, if for more than 5 s; when all of them send, the new one is refused. Each of these
// events is counted, and logged at most once a second. With a translator the records are MVN's, the
// only rig that streams over TCP. Pinned by tests/unit/daemon/source/tcp_test.cpp.
Result<std::unique_ptr<Transport>> MakeTcp(const config::Source& config, int source,
                                           runtime::Clock& clock, runtime::Counters& counters,
                                           std::unique_ptr<Translator> translator);

}  // namespace styled::source
