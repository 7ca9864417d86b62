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
  std::vector<body::Pose> take;  // the performer's motion while it showed a style, for Like.learn_s
  std::optional<Places> places;  // instead of a request: the leader's list of places
  bool followed = false;         // performed by the leader and repeated here; no client waits
  bool designs = false;          // a design of OSC, which others wait for
};

// A log line of the pipeline, which does not log itself.
struct Event {
  enum class Level : std::uint8_t { kInfo, kWarning };
  Level level = Level::kInfo;
  std::string text;
};

// A message of the files thread to the pipeline: a configuration to adopt, a request that it has
// executed, or both. The request is answered under the new configuration.
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
  runtime::Ring<std::unique_ptr<std::vector<Profile>>, 4> profiles;  // pipeline -> files: to store
  // This daemon is a standby and refuses requests. Set by the pipeline.
  std::atomic<bool> stands_by{false};
  runtime::Wakeup wake_pipeline, wake_control, wake_files;
};

}  // namespace styled::pipeline
