#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <vector>

#include "clients/cpp/curve.h"
#include "clients/cpp/doctor/facts.h"

// "Connected, but nothing arrives": looks at a daemon, its sources and this machine's network, and
// says at which step frames end and what to change.
namespace styled::doctor {

struct Options {
  std::string endpoint;         // of the daemon's control socket
  bool endpoint_given = false;  // else the configuration file's holds, where it has one
  std::chrono::milliseconds timeout{2000};
  std::optional<client::Curve> curve;  // for a daemon that asks for keys
  std::string config;                  // a styled.toml; "": none
  std::string source;                  // look at this one alone; "": all
  std::vector<std::string> listen;     // TYPE=HOST:PORT, looked at beside the sources
  double seconds = 3;                  // 0.2 to 60
  bool capture = true;                 // also look at the interfaces, where the rights allow it
};

// Finds out everything, which takes options.seconds and up to two timeouts. Errors: a file, a
// source or an address of the options that is none. Diagnose() (diagnose.h) judges it.
Result<Facts> Examine(const Options& options);

}  // namespace styled::doctor
