#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "clients/cpp/doctor/listener.h"
#include "model/base/status.h"
#include "proto/rigs/natnet/packet.h"

namespace styled::doctor {

// What a NatNet server said of itself.
struct NatNetAnswers {
  Endpoint server;
  std::string error;  // the call could not be made
  bool answered = false;
  std::string name;  // of the application
  natnet::Version version;
  bool multicast = true;  // frames go to `group`, else to who asked
  std::string group;      // "" where the server does not say (before 3.0)
  std::uint16_t data_port = natnet::kDataPort;
  bool model_answered = false, model_read = false;
  std::size_t skeletons = 0, rigid_bodies = 0;
  Tally frames;  // that came to who asked
};

// Asks a server, as the daemon would: who it is, what it tracks; keeps it sending. `answers` is
// written while the listener listens and must outlive it. Errors: no IPv4 address.
Result<std::unique_ptr<Listener>> MakeNatNetCall(const std::string& server, NatNetAnswers& answers);

}  // namespace styled::doctor
