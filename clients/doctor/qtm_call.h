#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "clients/doctor/listener.h"
#include "model/base/status.h"

namespace styled::doctor {

// The replies of Qualisys Track Manager, or of another program at its port.
struct QtmAnswers {
  Endpoint server;
  std::string error;       // set if the server did not get the request
  bool connected = false;  // TCP
  std::string refused;     // why not, or why the connection ended
  bool greeted = false;
  std::string text;  // first text that is not a greeting: an error's text, or another program's
  int minor = 0;     // of version 1.x; 0: none of the requested ones
  bool skeletons_answered = false;
  std::size_t skeletons = 0;
  std::uint64_t frames = 0, seen_frames = 0;  // data packets, and those in which a skeleton is seen
  bool no_measurement = false;                // it reported that there is no data
};

// Connects and sends the daemon's requests: version, skeletons, a stream of ten frames a second.
// The listener writes `answers` while it runs; `answers` must outlive it. Errors: `server` is not
// an IPv4 address.
Result<std::unique_ptr<Listener>> MakeQtmCall(const Endpoint& server, QtmAnswers& answers);

}  // namespace styled::doctor
