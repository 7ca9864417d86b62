#pragma once

#include <memory>

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
  // The log line of the last Do(); "" if there is none. A library that could not be written for a
  // Like is an error that its reply does not contain.
  const std::string& log_line() const { return log_line_; }
  const std::string& error() const { return error_; }

 private:
  using Outcome = Result<std::shared_ptr<const RuntimeConfig>>;
  // Each does one request, and fills its part of the reply.
  Outcome Execute(const RuntimeConfig& running, Exchange& exchange);
  Outcome Make(const RuntimeConfig& running, Exchange& exchange);
  Outcome Arrange(const RuntimeConfig& running, Exchange& exchange);
  Outcome Import(const RuntimeConfig& running, Exchange& exchange);
  Outcome Rename(const RuntimeConfig& running, Exchange& exchange);
  Outcome Remove(const RuntimeConfig& running, Exchange& exchange);

  Previews previews_;
  std::string log_line_, error_;
};

}  // namespace styled::pipeline
