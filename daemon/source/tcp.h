#pragma once

#include <memory>

#include "daemon/config/config.h"
#include "daemon/runtime/clock.h"
#include "daemon/runtime/counters.h"
#include "daemon/source/translator.h"
#include "daemon/source/transport.h"
#include "model/base/status.h"

namespace styled::source {

// The same datagrams as records of TCP connections, each connection with a buffer of its own. A
// stream that falls out of step is closed and counted with its reason, and so is a connection that
// brings no whole record within 5 s. Where all max_connections are taken, a new one gets the place
// of the oldest that never brought a record, else of the one that was silent for longest, beyond
// 5 s; where all of them send it is refused. Each of this is counted, and said at most once a
// second. With a translator the records are MVN's, the one rig that streams over TCP.
// Pinned by tests/unit/daemon/tcp_test.cpp.
Result<std::unique_ptr<Transport>> MakeTcp(const config::Source& config, int source,
                                           runtime::Clock& clock, runtime::Counters& counters,
                                           std::unique_ptr<Translator> translator);

}  // namespace styled::source
