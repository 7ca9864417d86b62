#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <vector>

#include "clients/cpp/curve.h"
#include "clients/doctor/facts.h"

// Answers "connected, but nothing arrives": examines a daemon, its sources and this machine's
// network, finds the stage at which frames stop, and proposes what to change.
namespace styled::doctor {

struct Options {
  std::string endpoint;  // of the daemon's control socket
  // False: the endpoint of the configuration file, if it has one, replaces `endpoint`.
  bool endpoint_given = false;
  std::chrono::milliseconds timeout{2000};
  std::optional<client::Curve> curve;  // for a daemon that requires keys
  std::string config;                  // a styled.toml; "": none
  std::string source;                  // examine only this source; "": all
  std::vector<std::string> listen;     // TYPE=HOST:PORT, examined in addition to the sources
  double seconds = 3;                  // 0.2 to 60
  bool capture = true;  // also capture at the interfaces, if the process has the rights
};

// Collects all facts; Diagnose() (diagnose.h) evaluates them. Takes options.seconds and up to two
// timeouts. Errors: an unreadable file, an unknown source, or an invalid address in the options.
Result<Facts> Examine(const Options& options);

}  // namespace styled::doctor
