#pragma once

#include <cstdint>

#include "daemon/perform/performance.h"

namespace styled::pipeline {

// A performer has fallen silent: their last pose is sent again, flagged stale, at `now_ns`. Returns
// whether there was one; its sequence is the performer's last. Pipeline thread.
bool SendStale(Performance& performance, Performer& performer, std::int64_t now_ns);

}  // namespace styled::pipeline
