#pragma once

#include <memory>

#include "daemon/config/config.h"
#include "daemon/runtime/clock.h"
#include "daemon/runtime/counters.h"
#include "daemon/source/transport.h"
#include "model/base/status.h"

namespace styled::source {

// Opens a [[source]]: its transport, its rig's translator if there is one, and its delay. `config`
// is valid (config::Validate); `source` is its number for the receiver. Clock and counters outlive
// the transport. Errors name the address, or say why there is no USB. Start-up only; allocates and
// opens sockets.
Result<std::unique_ptr<Transport>> Open(const config::Source& config, int source,
                                        runtime::Clock& clock, runtime::Counters& counters);

}  // namespace styled::source
