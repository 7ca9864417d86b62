#pragma once

#include <memory>

#include "daemon/config/config.h"
#include "daemon/runtime/clock.h"
#include "daemon/runtime/counters.h"
#include "daemon/source/transport.h"
#include "model/base/status.h"

namespace styled::source {

// Opens the transport for OptiTrack's NatNet, a dialogue with `config.server` (IPv4 HOST[:PORT],
// default port 1510). Commands leave from `config.listen` (default: any port). Frames arrive at the
// same socket, or at the multicast group that the server names (config.group for servers before
// 3.0). The group is joined on `config.interface`: an IPv4 address of this machine or an
// interface's name; "" follows the routing table. rigs/natnet.h interprets the packets. Pinned by
// tests/unit/natnet/transport_test.cpp.
Result<std::unique_ptr<Transport>> MakeNatNetTransport(const config::Source& config, int source,
                                                       runtime::Clock& clock,
                                                       runtime::Counters& counters);

}  // namespace styled::source
