#pragma once

#include <chrono>
#include <memory>
#include <set>
#include <string>

#include "daemon/looks/mailboxes.h"
#include "daemon/looks/runtime_config.h"
#include "daemon/styles/preview.h"
#include "model/base/status.h"

// Requests that are executed outside the pipeline: to make, exchange, rename, remove and show
// styles.
namespace styled::pipeline {

// Whether the request goes to the files thread first. Like.learn_s does not: the pipeline passes it
// on once the performer has shown the style.
bool IsStyleRequest(const v1::Request& request);

// Executes these requests in the order of arrival, on the files thread: reads clips, writes the
// library, computes. Blocks; allocates. Pinned by tests/e2e/style_library_test.cpp.
class StyleRequests {
 public:
  // Fills the exchange's reply. Returns the configuration to adopt before the reply is sent; null
  // after an error, or when nothing changes.
  std::shared_ptr<const RuntimeConfig> Do(const RuntimeConfig& running, Exchange& exchange);
  // Writes the styles whose sliders moved to the library: once all have rested for kRest or moved
  // for kLongest, or `now`. (A slider that moves would otherwise write at each of its places.)
  // Returns the configuration with the files; null if nothing was written.
  std::shared_ptr<const RuntimeConfig> KeepMoved(const RuntimeConfig& running, bool now);
  // The log line of the last Do(), or "".
  const std::string& log_line() const { return log_line_; }
  // Why the last Do() or KeepMoved() could not write a style to the library, or "". The reply to a
  // Like says it only of a write that does not wait.
  const std::string& error() const { return error_; }

  // A hand rests less on a slider while it looks for a place; a crash loses at most kLongest of its
  // work.
  static constexpr std::chrono::milliseconds kRest{1000}, kLongest{10000};

 private:
  using Outcome = Result<std::shared_ptr<const RuntimeConfig>>;
  // Each does one request, and fills its part of the reply.
  Outcome Execute(const RuntimeConfig& running, Exchange& exchange);
  Outcome Make(const RuntimeConfig& running, Exchange& exchange);
  Outcome Arrange(const RuntimeConfig& running, Exchange& exchange);
  Outcome Import(const RuntimeConfig& running, Exchange& exchange);
  Outcome Rename(const RuntimeConfig& running, Exchange& exchange);
  Outcome Remove(const RuntimeConfig& running, Exchange& exchange);

  void KeepLater(const std::string& name);
  void Keep(const std::string& name, const std::string& example, RuntimeConfig& config);

  Previews previews_;
  std::set<std::string> designed_;  // styles by hand that were written once, or could not be
  std::set<std::string> moved_;     // styles that the library does not have as they are
  std::chrono::steady_clock::time_point moved_at_, first_moved_at_;
  std::string log_line_, error_;
};

}  // namespace styled::pipeline
