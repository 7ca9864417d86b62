#pragma once

#include <libusb-1.0/libusb.h>

#include <cstdint>
#include <optional>

#include "daemon/config/address.h"

namespace styled::source::usb {

// The protocol of a device.
enum class Protocol : std::uint8_t {
  kSlimeVr,  // HID input reports of 64 bytes: SlimeVR's receiver, or its tracker on a cable
  kNative    // native records on a bulk endpoint: proto/rigs/native/USB.md
};

// The interface and endpoint that deliver a device's data.
struct Interface {
  int number = 0;
  std::uint8_t endpoint = 0;  // its address, bit 7 set: IN
  bool bulk = false;          // else interrupt
  friend bool operator==(const Interface&, const Interface&) = default;
};

// Whether a device should be opened: it has the id `id`, or, without an id, it is known to speak
// SlimeVR's HID protocol (1209:7690, 1209:7692, 4E76:D2D0 to D2DF; the ids are those of SlimeVR's
// server). Devices with native records have no well-known ids.
bool IsWanted(Protocol protocol, const std::optional<config::UsbId>& id,
              const config::UsbId& device) noexcept;

// The first interface of a configuration that speaks the protocol, found by class, not by number;
// only its alternate setting 0 is considered. Empty if there is none. Pure. Pinned by
// tests/unit/usb/descriptors_test.cpp.
std::optional<Interface> FindInterface(Protocol protocol,
                                       const libusb_config_descriptor& config) noexcept;

}  // namespace styled::source::usb
