#include "daemon/perform/event_log.h"

#include <cstdint>
#include <utility>

namespace styled::pipeline {

using runtime::Counter;

void EventLog::LogOf(LogLimit::Kind kind, const source::Machine& sender,
                     const std::string& performer, Event::Level level, std::string text) {
  std::uint64_t held_back = 0;
  if (!limit_.Admit(kind, sender, performer, clock_.Now_ns(), held_back)) {
    counters_.Add(Counter::kPipelineEventsHeldBack);
    return;
  }
  if (held_back > 0) text += " (and " + std::to_string(held_back) + " more like this before)";
  Log(level, performer + ": " + std::move(text));
}

void EventLog::Log(Event::Level level, std::string text) {
  // The text may quote a remote sender: replace line breaks and terminal escapes.
  for (char& c : text) {
    if (static_cast<unsigned char>(c) < ' ' || c == '\x7F') c = '?';
  }
  if (!mailboxes_.events.Push({level, std::move(text)})) {
    counters_.Add(Counter::kPipelineEventsDropped);
  }
}

}  // namespace styled::pipeline
