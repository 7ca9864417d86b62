#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "clients/doctor/listener.h"
#include "model/base/status.h"
#include "proto/rigs/natnet/packet.h"

namespace styled::doctor {

// The replies of a NatNet server.
struct NatNetAnswers {
  Endpoint server;
  std::string error;  // set if the server did not get the request
  bool answered = false;
  std::string name;  // of the server's application
  natnet::Version version;
  bool multicast = true;  // frames are sent to `group`; else to the client that connected
  std::string group;      // "" if the server does not report it (before 3.0)
  std::uint16_t data_port = natnet::kDataPort;
  bool model_answered = false, model_read = false;
  std::size_t skeletons = 0, rigid_bodies = 0;
  Tally frames;  // received by unicast
};

// Sends the requests that the daemon would send: connect, model definition, keep-alive. The
// listener writes `answers` while it runs; `answers` must outlive it. Errors: `server` is not an
// IPv4 address.
Result<std::unique_ptr<Listener>> MakeNatNetCall(const std::string& server, NatNetAnswers& answers);

}  // namespace styled::doctor
