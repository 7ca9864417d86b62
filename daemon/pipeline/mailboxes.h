#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "daemon/pipeline/profile.h"
#include "daemon/pipeline/runtime_config.h"
#include "daemon/runtime/ring.h"
#include "daemon/runtime/wakeup.h"
#include "proto/styled/v1/control.pb.h"

namespace styled::pipeline {

// A request on its way from the control thread to the pipeline and, with its reply, back. Allocated
// and freed by the control thread.
struct Exchange {
  std::vector<std::vector<std::byte>> envelope;  // routing parts; the control thread's
  std::string osc;  // address of the OSC message that it came as, or ""
  v1::Request request;
  v1::Reply reply;
};

// A line for the log, from the pipeline, which does not log.
struct Event {
  enum class Level : std::uint8_t { kInfo, kWarning };
  Level level = Level::kInfo;
  std::string text;
};

// All that crosses threads: bounded rings, emptied between frames.
struct Mailboxes {
  runtime::Ring<std::unique_ptr<Exchange>, 64> commands;           // control -> pipeline
  runtime::Ring<std::unique_ptr<Exchange>, 64> replies;            // pipeline -> control
  runtime::Ring<std::shared_ptr<const RuntimeConfig>, 4> reloads;  // supervisor -> pipeline
  runtime::Ring<Event, 256> events;                                // pipeline -> supervisor
  runtime::Ring<std::unique_ptr<std::vector<Profile>>, 4>
      profiles;  // pipeline -> supervisor: to keep
  runtime::Wakeup wake_pipeline, wake_control;
};

}  // namespace styled::pipeline
