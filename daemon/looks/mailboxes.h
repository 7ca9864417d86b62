#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "daemon/looks/places.h"
#include "daemon/looks/profile.h"
#include "daemon/looks/runtime_config.h"
#include "daemon/runtime/ring.h"
#include "daemon/runtime/wakeup.h"
#include "model/body/pose.h"
#include "proto/styled/v1/control.pb.h"

namespace styled::pipeline {

// A request on its way from the control thread to the pipeline and, with its reply, back. The
// control thread allocates and frees it.
struct Exchange {
  std::vector<std::vector<std::byte>> envelope;  // routing parts, for the control thread
  std::string osc;  // address of the OSC message that the request came from, or ""
  v1::Request request;
  v1::Reply reply;
  std::vector<body::Pose> take;  // what a performer showed of a style, for Like.learn_s
  std::optional<Places> places;  // in place of a request: the leader's, to be this daemon's
  bool followed = false;  // nobody waits for the reply: the leader did this, and its standby does
};

// A log line of the pipeline, which does not log itself.
struct Event {
  enum class Level : std::uint8_t { kInfo, kWarning };
  Level level = Level::kInfo;
  std::string text;
};

// What the files thread hands to the pipeline: a configuration to take over, or a request whose
// work it did, or both. The request is answered under the configuration.
struct Reload {
  std::shared_ptr<const RuntimeConfig> config;
  std::unique_ptr<Exchange> exchange;
};

// Everything that crosses threads: bounded rings, emptied between frames.
struct Mailboxes {
  runtime::Ring<std::unique_ptr<Exchange>, 64> commands;  // control -> pipeline
  runtime::Ring<std::unique_ptr<Exchange>, 64> replies;   // pipeline -> control
  runtime::Ring<std::unique_ptr<Exchange>, 4> examples;   // control -> files (style_requests.h)
  runtime::Ring<std::unique_ptr<Exchange>, 4> takes;      // pipeline -> files
  runtime::Ring<Reload, 4> reloads;                       // files -> pipeline
  runtime::Ring<Event, 256> events;                       // pipeline -> supervisor
  runtime::Ring<std::unique_ptr<std::vector<Profile>>, 4> profiles;  // pipeline -> files: to keep
  // This daemon is another one's standby: it takes no orders. Set by the pipeline.
  std::atomic<bool> stands_by{false};
  runtime::Wakeup wake_pipeline, wake_control, wake_files;
};

}  // namespace styled::pipeline
