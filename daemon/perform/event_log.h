#pragma once

#include <string>

#include "daemon/looks/mailboxes.h"
#include "daemon/perform/log_limit.h"
#include "daemon/runtime/clock.h"
#include "daemon/runtime/counters.h"
#include "daemon/source/transport.h"

namespace styled::pipeline {

// Passes the pipeline's log lines to the supervisor, which writes them. Never blocks: a line that
// finds the mailbox full is dropped and counted. Pipeline thread, outside the hot section;
// allocates.
class EventLog {
 public:
  // All arguments must outlive it.
  EventLog(const runtime::Clock& clock, runtime::Counters& counters, Mailboxes& mailboxes)
      : clock_(clock), counters_(counters), mailboxes_(mailboxes) {}

  void Log(Event::Level level, std::string text);
  // The same within the limit of the line's kind and performer. `sender`: the machine that caused
  // the line; all zeros: none.
  void LogOf(LogLimit::Kind kind, const source::Machine& sender, const std::string& performer,
             Event::Level level, std::string text);

 private:
  const runtime::Clock& clock_;
  runtime::Counters& counters_;
  Mailboxes& mailboxes_;
  LogLimit limit_;
};

}  // namespace styled::pipeline
