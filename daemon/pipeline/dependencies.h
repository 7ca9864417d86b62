#pragma once

#include "daemon/pipeline/mailboxes.h"
#include "daemon/publish/publisher.h"
#include "daemon/record/recorder.h"
#include "daemon/runtime/clock.h"
#include "daemon/runtime/counters.h"

namespace styled::pipeline {

// What the pipeline works with; each outlives it.
struct Dependencies {
  runtime::Clock& clock;
  runtime::Counters& counters;
  publish::Publisher& publisher;
  Mailboxes& mailboxes;
  record::Recorder* recorder = nullptr;  // null: nothing is recorded
  bool anticipate = true;                // knows when each frame is due, and wakes shortly before
  bool prewarm = true;                   // and then brings what it needs into the caches
};

}  // namespace styled::pipeline
