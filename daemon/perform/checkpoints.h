#pragma once

#include <cstdint>
#include <string>

#include "daemon/perform/merge/layers.h"
#include "daemon/perform/roster.h"
#include "model/base/status.h"
#include "proto/styled/v1/checkpoint.pb.h"
#include "proto/styled/v1/control.pb.h"

namespace styled::pipeline {

// Execute TakeCheckpoint and RestoreCheckpoint (control.proto) between two frames. Errors have a
// code. Pipeline thread; allocate. Pinned by tests/unit/daemon/perform/checkpoints_test.cpp.

// `now_ns`: monotonic; `wall_ns`: since 1970. The performer continues undisturbed.
Result<v1::Checkpoint> TakeCheckpoint(const std::string& performer, Roster& roster,
                                      std::int64_t now_ns, std::int64_t wall_ns);

// Gives the state to `performer`, or, where that is "", to the performer that the checkpoint names,
// who is returned. After an error nothing is changed.
Result<Performer*> RestoreCheckpoint(const std::string& performer, const v1::Checkpoint& checkpoint,
                                     Roster& roster, Layers& layers, std::int64_t now_ns);

}  // namespace styled::pipeline
