#pragma once

#include <memory>

#include "daemon/config/config.h"
#include "daemon/runtime/clock.h"
#include "daemon/runtime/counters.h"
#include "daemon/source/transport.h"
#include "model/base/status.h"

namespace styled::source {

// Opens what a [[source]] names: its transport, the rig's translator in it where it has one, and
// the delay before it. `config` is valid (config::Validate); `source` numbers it for the receiver.
// Clock and counters outlive the transport. Errors name the address, or say why there is no USB.
// Start-up only; allocates and opens sockets.
Result<std::unique_ptr<Transport>> Open(const config::Source& config, int source,
                                        runtime::Clock& clock, runtime::Counters& counters);

}  // namespace styled::source
