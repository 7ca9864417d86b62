#pragma once

#include <memory>
#include <string>

#include "model/base/status.h"
#include "sim/player/link.h"
#include "sim/rigs/rig.h"

namespace styled::rigs {

// The socket of a rig that is a server: player::Listen for "udp://HOST:PORT". For "tcp://HOST:PORT"
// a listener that accepts clients and keeps a Session of `server` for each, while Receive is
// called; Send passes data to all sessions, which forward it. A client that does not read its data
// is disconnected when 8 MiB wait for it. `server` must outlive the link. `bound` as there.
Result<std::unique_ptr<player::Link>> Listen(Rig& server, const std::string& url,
                                             std::string* bound = nullptr);

}  // namespace styled::rigs
