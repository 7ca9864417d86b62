#pragma once

#include <memory>

#include "daemon/config/config.h"
#include "daemon/runtime/clock.h"
#include "daemon/runtime/counters.h"
#include "daemon/source/transport.h"
#include "model/base/status.h"

namespace styled::source {

// OptiTrack's NatNet, a dialogue with `config.server` (IPv4 HOST[:PORT], by default port 1510).
// Commands go out from `config.listen`, by default any port; frames come back to that socket, or to
// the group that the server names (config.group of servers before 3.0), joined on
// `config.interface`: an IPv4 address of this machine or an interface's name, "" = as the routing
// table has it. What the packets mean: rigs/natnet.h. Pinned by
// tests/unit/natnet/transport_test.cpp.
Result<std::unique_ptr<Transport>> MakeNatNet(const config::Source& config, int source,
                                              runtime::Clock& clock, runtime::Counters& counters);

}  // namespace styled::source
