#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "daemon/pipeline/roster.h"
#include "daemon/source/transport.h"
#include "proto/styled/v1/control.pb.h"

namespace styled::pipeline {

// Answers a Calibrate request (control.proto): a rig of sensors is reset by its transport, another
// one's performer is bound anew by the pose it stands in. The performer whose bodies or sensors
// changed; null, and the reply says why, on an error. Pipeline thread; allocates.
Performer* Calibrate(const v1::Request& request,
                     const std::vector<std::unique_ptr<source::Transport>>& transports,
                     Roster& roster, std::int64_t now_ns, v1::Reply& reply);

}  // namespace styled::pipeline
