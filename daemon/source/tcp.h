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
// stream that falls out of step is closed and counted with its reason. With a translator they are
// MVN's, the one rig that streams over TCP.
Result<std::unique_ptr<Transport>> MakeTcp(const config::Source& config, int source,
                                           runtime::Clock& clock, runtime::Counters& counters,
                                           std::unique_ptr<Translator> translator);

}  // namespace styled::source
