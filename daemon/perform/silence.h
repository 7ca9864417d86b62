#pragma once

#include <cstdint>

#include "daemon/perform/performance.h"
#include "proto/styled/v1/journal.pb.h"

namespace styled::pipeline {

// Sends the last pose of a performer that has fallen silent again, flagged stale, at `now_ns`.
// Returns whether there was one; its sequence is the performer's last. Pipeline thread.
bool SendStale(Performance& performance, Performer& performer, std::int64_t now_ns);

// Sends a frame of a performer whose rig is silent and whose body moves by itself (Look.idle), at
// `elapsed_ns` of the session. Returns whether there was one; its sequence is the performer's last.
bool SendIdle(Performance& performance, Performer& performer, std::int64_t elapsed_ns,
              std::int64_t now_ns);

// Performs a silence that was decided elsewhere: by the leader of a pair, or the daemon that made a
// recording. Sends stale and idle frames under their numbers, and forgets performers.
void PerformSilence(Performance& performance, const v1::Silence& silence, std::int64_t now_ns);

}  // namespace styled::pipeline
