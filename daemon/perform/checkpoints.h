#pragma once

#include <cstdint>

#include "daemon/perform/merge/layers.h"
#include "daemon/perform/roster.h"
#include "proto/styled/v1/checkpoint.pb.h"
#include "proto/styled/v1/control.pb.h"

namespace styled::pipeline {

// Execute TakeCheckpoint and RestoreCheckpoint (control.proto) between two frames: fill the reply's
// code and reason. Pipeline thread; allocate. Pinned by tests/unit/daemon/checkpoints_test.cpp.

// `now_ns`: monotonic; `wall_ns`: since 1970. The performer continues undisturbed.
void TakeCheckpoint(const v1::Request& request, Roster& roster, std::int64_t now_ns,
                    std::int64_t wall_ns, v1::Reply& reply);

// Returns the performer that now has the state. Returns null if the request was refused; everything
// is then as before.
Performer* RestoreCheckpoint(const v1::Request& request, Roster& roster, Layers& layers,
                             std::int64_t now_ns, v1::Reply& reply);

}  // namespace styled::pipeline
