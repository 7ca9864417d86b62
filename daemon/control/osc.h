#pragma once

#include "model/base/status.h"
#include "proto/rigs/vmc/osc.h"
#include "proto/styled/v1/control.pb.h"

namespace styled::control {

// What an OSC message asks for; proto/styled/v1/OSC.md lists them. Errors name the address and what
// its arguments should be. Pure; allocates. Pinned by tests/unit/daemon/osc_test.cpp.
Result<v1::Request> ReadOsc(const vmc::osc::Message& message);

}  // namespace styled::control
