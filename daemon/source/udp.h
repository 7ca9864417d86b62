#pragma once

#include <memory>

#include "daemon/config/config.h"
#include "daemon/runtime/clock.h"
#include "daemon/runtime/counters.h"
#include "daemon/source/translator.h"
#include "daemon/source/transport.h"
#include "model/base/status.h"

namespace styled::source {

// Datagrams over UDP, received in batches with recvmmsg. Counts what the kernel dropped. With a
// translator they are a rig's own, and what it makes of them is handed on; without, they are ours.
Result<std::unique_ptr<Transport>> MakeUdp(const config::Source& config, int source,
                                           runtime::Clock& clock, runtime::Counters& counters,
                                           std::unique_ptr<Translator> translator);

}  // namespace styled::source
