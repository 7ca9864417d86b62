#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "daemon/perform/roster.h"
#include "daemon/source/transport.h"
#include "model/base/status.h"
#include "proto/styled/v1/control.pb.h"

namespace styled::pipeline {

// Executes a Calibrate request (control.proto). A rig of sensors is reset by its transport; for any
// other rig the performer is bound again by its current pose. With `neutral`, the performer's own
// posture and walk are learned again instead, for any rig. Returns the performer whose bodies
// or sensors changed, and fills `calibrate` of the reply; an error has a code. Pipeline thread;
// allocates.
Result<Performer*> Calibrate(const v1::Request& request,
                             const std::vector<std::unique_ptr<source::Transport>>& transports,
                             Roster& roster, std::int64_t now_ns, v1::Reply& reply);

}  // namespace styled::pipeline
