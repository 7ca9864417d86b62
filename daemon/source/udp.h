#pragma once

#include <memory>

#include "daemon/config/config.h"
#include "daemon/runtime/counters.h"
#include "daemon/source/transport.h"
#include "model/base/status.h"

namespace styled::source {

// Datagrams over UDP, received in batches with recvmmsg. Counts what the kernel dropped.
Result<std::unique_ptr<Transport>> MakeUdp(const config::Source& config, int source,
                                           runtime::Counters& counters);

}  // namespace styled::source
