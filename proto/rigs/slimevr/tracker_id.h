#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace styled::slimevr {

// A sensor: the address of its device (a MAC, or what a receiver calls a tracker's address, 48
// bits) and its number there. In text "A848FAC01D42" or "A8:48:FA:C0:1D:42", and "/1" behind it for
// sensor 1; devices without an address go by their IPv4 address, "192.168.1.7/1".
struct TrackerId {
  std::uint64_t address = 0;
  std::uint8_t sensor = 0;
  friend bool operator==(const TrackerId&, const TrackerId&) = default;
};
inline constexpr std::uint64_t kIsIpv4 = 1ULL << 48U;  // in `address`, above its 32 bits
// Nothing where the text is neither form. Pinned by tests/unit/slimevr/tracker_rig_test.cpp.
std::optional<TrackerId> ParseTrackerId(std::string_view text);
std::string ToText(const TrackerId& id);

}  // namespace styled::slimevr
