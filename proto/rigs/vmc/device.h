#pragma once

#include <cstdint>
#include <string_view>

#include "proto/rigs/vmc/vmc.h"

// VMC's tracking devices: sent by assistants instead of bones, and the form in which props are sent
// to clients. Space and rules as in vmc.h. Pinned by tests/unit/vmc/device_test.cpp, fuzzed by
// tests/fuzz/vmc.
namespace styled::vmc {

// /VMC/Ext/{Hmd,Con,Tra}/Pos: a head-mounted display, a controller, a tracker. Only the serial
// identifies it; no message states its part of the body. The same addresses with /Local (in the
// device's own space) and /VMC/Ext/Con (a button) are different messages.
struct Device {
  enum class Kind : std::uint8_t { kHmd, kController, kTracker };
  Kind kind = Kind::kTracker;
  std::string_view serial;  // points into the bytes that were read, or the sender's
  Transform transform;      // in the world
};

// `device` is written only on kOk. kUnknownAddress for all other messages.
STYLED_REALTIME DecodeResult Decode(const osc::Message& bytes, Device& device) noexcept;
STYLED_REALTIME void Put(const Device& device, osc::Writer& writer) noexcept;

}  // namespace styled::vmc
