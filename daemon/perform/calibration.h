#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "daemon/perform/roster.h"
#include "daemon/source/transport.h"
#include "proto/styled/v1/control.pb.h"

namespace styled::pipeline {

// Executes a Calibrate request (control.proto). A rig of sensors is reset by its transport; any
// other rig's performer is bound again by its current pose. With `neutral`, the performer's own
// posture and walk are learned again instead, for any rig. Returns the performer whose bodies or
// sensors changed; on an error returns null and fills the reply's code and reason. Pipeline thread;
// allocates.
Performer* Calibrate(const v1::Request& request,
                     const std::vector<std::unique_ptr<source::Transport>>& transports,
                     Roster& roster, std::int64_t now_ns, v1::Reply& reply);

}  // namespace styled::pipeline
