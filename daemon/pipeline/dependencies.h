#pragma once

#include "daemon/log/recorder.h"
#include "daemon/looks/mailboxes.h"
#include "daemon/publish/publisher.h"
#include "daemon/runtime/clock.h"
#include "daemon/runtime/clock_watch.h"
#include "daemon/runtime/counters.h"
#include "daemon/standby/standby.h"

namespace styled::pipeline {

// The objects that the pipeline uses; each must outlive it.
struct Dependencies {
  runtime::Clock& clock;
  runtime::Counters& counters;
  publish::Publisher& publisher;
  Mailboxes& mailboxes;
  log::Recorder* recorder = nullptr;           // null: nothing is recorded
  bool anticipate = true;                      // predicts each frame and wakes shortly before
  bool prewarm = true;                         // and then brings its data into the caches
  bool polls = false;                          // the loop is awake around that time in any case
  runtime::ClockWatch* clock_watch = nullptr;  // null: statistics say nothing of the clock
  // Null: this daemon is alone. Else `clock` and `publisher` are its own.
  standby::Standby* standby = nullptr;
  // Fades styles out where the machine cannot keep up (overload.h). It depends on the time that
  // styling takes, so a replay does without.
  bool relieves = false;

  bool leads() const { return standby == nullptr || standby->leads(); }
};

}  // namespace styled::pipeline
