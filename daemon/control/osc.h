#pragma once

#include "model/base/status.h"
#include "proto/rigs/vmc/osc.h"
#include "proto/styled/v1/control.pb.h"

namespace styled::control {

// Translates an OSC message into a request; proto/styled/v1/OSC.md lists the messages. A message
// that needs no action (a button's release, another daemon's /styled/error) gives a request without
// a command. Errors name the address and the expected arguments. Pure; allocates. Pinned by
// tests/unit/daemon/control/osc_test.cpp.
Result<v1::Request> ReadOsc(const vmc::osc::Message& message);

}  // namespace styled::control
