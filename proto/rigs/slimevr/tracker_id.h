#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace styled::slimevr {

// A sensor: the address of its device (a MAC, or the address that a receiver gives a tracker, 48
// bits) and its number on the device. Text form: "A848FAC01D42" or "A8:48:FA:C0:1D:42", with "/1"
// behind it for sensor 1. Devices without an address use their IPv4 address, "192.168.1.7/1".
struct TrackerId {
  std::uint64_t address = 0;
  std::uint8_t sensor = 0;
  friend bool operator==(const TrackerId&, const TrackerId&) = default;
};
inline constexpr std::uint64_t kIsIpv4 = 1ULL << 48U;  // in `address`, above its 32 bits
// Empty if the text has neither form. Pinned by tests/unit/slimevr/tracker_rig_test.cpp.
std::optional<TrackerId> ParseTrackerId(std::string_view text);
std::string ToText(const TrackerId& id);

}  // namespace styled::slimevr
