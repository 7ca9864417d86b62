#pragma once

#include <memory>

#include "daemon/config/config.h"
#include "daemon/runtime/clock.h"
#include "daemon/runtime/counters.h"
#include "daemon/source/translator.h"
#include "daemon/source/transport.h"
#include "model/base/status.h"

namespace styled::source {

// Opens a UDP transport that receives datagrams in batches with recvmmsg and counts those that the
// kernel dropped. With a translator the datagrams are a rig's, without one they are native.
Result<std::unique_ptr<Transport>> MakeUdp(const config::Source& config, int source,
                                           runtime::Clock& clock, runtime::Counters& counters,
                                           std::unique_ptr<Translator> translator);

}  // namespace styled::source
