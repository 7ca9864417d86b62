#pragma once

#include "daemon/log/recorder.h"
#include "daemon/looks/mailboxes.h"
#include "daemon/perform/frame_processor.h"
#include "daemon/publish/publisher.h"
#include "daemon/runtime/clock.h"
#include "daemon/runtime/clock_watch.h"
#include "daemon/runtime/counters.h"
#include "daemon/runtime/helpers.h"
#include "daemon/standby/standby.h"

namespace styled::pipeline {

// The objects that the pipeline uses; each must outlive it.
struct Dependencies {
  runtime::Clock& clock;
  runtime::Counters& counters;
  publish::Publisher& publisher;
  Mailboxes& mailboxes;
  log::Recorder* recorder = nullptr;           // null: nothing is recorded
  bool anticipate = true;                      // predict each frame and wake shortly before it
  bool prewarm = true;                         // then bring its data into the caches
  bool polls = false;                          // the loop is awake at that time in any case
  runtime::ClockWatch* clock_watch = nullptr;  // null: no statistics of the clock
  // Null: no pair. Otherwise `clock` and `publisher` are the standby's.
  standby::Standby* standby = nullptr;
  // Fades styles out while the machine is overloaded (overload.h). Off in a replay, because it
  // depends on the measured time of styling.
  bool relieves = false;

  runtime::Helpers* helpers = nullptr;     // null: the pipeline thread styles alone
  RecordedDecisions* decisions = nullptr;  // null: frames are decided here

  bool leads() const { return standby == nullptr || standby->leads(); }
  // Whether this daemon decides which performers are silent.
  bool decides_silence() const { return leads() && decisions == nullptr; }
};

}  // namespace styled::pipeline
