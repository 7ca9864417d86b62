#pragma once

#include <libusb-1.0/libusb.h>

#include <cstdint>
#include <optional>

#include "daemon/config/address.h"

namespace styled::source::usb {

// What speaks at the other end.
enum class Protocol : std::uint8_t {
  kSlimeVr,  // HID input reports of 64 bytes: SlimeVR's receiver, its tracker on a cable
  kNative    // our own records on a bulk endpoint: proto/rigs/native/USB.md
};

// Where a device's data comes from.
struct Interface {
  int number = 0;
  std::uint8_t endpoint = 0;  // its address, bit 7 set: IN
  bool bulk = false;          // else interrupt
  friend bool operator==(const Interface&, const Interface&) = default;
};

// Whether a device is one to open: of `id`, or, without it, any that is known to speak SlimeVR's
// HID protocol (1209:7690, 1209:7692, 4E76:D2D0 to D2DF; the ids are SlimeVR's server's). Our own
// records have no ids that everybody knows.
bool IsWanted(Protocol protocol, const std::optional<config::UsbId>& id,
              const config::UsbId& device) noexcept;

// The first interface of a configuration that speaks the protocol, by class, not by number; its
// alternate setting 0 counts. Nothing where there is none. Pure. Pinned by
// tests/unit/usb/descriptors_test.cpp.
std::optional<Interface> FindInterface(Protocol protocol,
                                       const libusb_config_descriptor& config) noexcept;

}  // namespace styled::source::usb
