#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <variant>

#include "model/base/realtime.h"
#include "proto/rigs/slimevr/hid.h"

// SlimeVR's trackers over UDP (port 6969): big-endian packets of a type and a body; a datagram
// holds one packet or a bundle. Facts from SlimeVR's ESP firmware (which writes them:
// connection.cpp, packets.h) and its server (which reads and answers them: UDPPacket.kt,
// UDPProtocolParser.kt), both MIT/Apache. Pure functions, any thread, no allocation. Pinned by
// tests/unit/slimevr, fuzzed by tests/fuzz/slimevr.
namespace styled::slimevr {

// An Ethernet frame's; trackers send no larger datagrams.
inline constexpr std::size_t kMaxUdpSize = 1472;
inline constexpr std::size_t kMaxPackets = 128;  // in one datagram
inline constexpr int kMaxBundleDepth = 2;        // real trackers: 1

// The number beside each struct is the packet's type on the wire. Texts point into the decoded
// bytes.
struct Heartbeat {};  // 0
// 1 (sensor 0) and 16 (sensor 1), the predecessors of 17. Axes are always those of Orientation.
struct LegacyRotation {
  std::uint8_t sensor = 0;
  Orientation orientation;
};
struct Handshake {  // 3; searches for a server
  std::uint32_t board = 0, imu = 0, mcu = 0;
  std::uint32_t protocol = 0;
  std::string_view firmware;          // up to 255
  std::array<std::uint8_t, 6> mac{};  // all zero: not sent
  std::uint8_t tracker_type = 0;
};
struct Acceleration {  // 4
  std::array<float, 3> acceleration_mps2{};
  std::uint8_t sensor = 0;
};
struct Ping {  // 10; the tracker returns what the server sent
  std::uint32_t id = 0;
};
struct Text {  // 11
  std::string_view text;
};
struct BatteryLevel {  // 12
  float volts = 0;     // 0: not sent
  float level = 0;     // 0 .. 1
};
struct Tap {  // 13
  std::uint8_t sensor = 0, value = 0;
};
struct Error {  // 14
  std::uint8_t sensor = 0, code = 0;
};
struct SensorInfo {  // 15; repeated each second until it is acknowledged
  std::uint8_t sensor = 0;
  std::uint8_t status = 1;  // 0 off, 1 ok, 2 error
  std::uint8_t imu = 0;
  std::uint16_t config = 0;  // bit 0: magnetometer in use
  std::uint8_t calibrated = 0;
  std::uint8_t position = 0;  // a TrackerPosition, as the tracker reports it; 0: not sent
  std::uint8_t data = 0;      // 0 rotation, else flex sensors
};
struct Rotation {  // 17
  std::uint8_t sensor = 0;
  std::uint8_t kind = 1;  // 1 normal; 2 correction by the magnetometer: the server ignores it
  Orientation orientation;
  std::uint8_t accuracy = 0;
};
struct MagnetometerAccuracy {  // 18
  std::uint8_t sensor = 0;
  float accuracy = 0;
};
struct SignalStrength {  // 19
  std::uint8_t sensor = 0;
  std::int8_t dbm = 0;
};
struct Temperature {  // 20
  std::uint8_t sensor = 0;
  float celsius = 0;
};
struct UserAction {  // 21
  std::uint8_t action = 0;
  static constexpr std::uint8_t kFullReset = 2, kYawReset = 3, kMountingReset = 4, kPause = 5;
};
struct FeatureFlags {      // 22
  std::uint32_t bits = 0;  // bit 0 of the first byte lowest; bits beyond 32 are left out
};
struct RotationAndAcceleration {  // 23
  std::uint8_t sensor = 0;
  Motion motion;
};
struct ConfigAck {  // 24
  std::uint8_t sensor = 0;
  std::uint16_t what = 0;
};
struct Flex {  // 26
  std::uint8_t sensor = 0;
  float value = 0;
};
struct Position {  // 27
  std::uint8_t sensor = 0;
  std::array<float, 3> position_m{};
};
struct ProtocolChange {  // 200
  std::uint8_t protocol = 0, version = 0;
};

// A packet of a tracker.
using Packet = std::variant<Heartbeat, LegacyRotation, Handshake, Acceleration, Ping, Text,
                            BatteryLevel, Tap, Error, SensorInfo, Rotation, MagnetometerAccuracy,
                            SignalStrength, Temperature, UserAction, FeatureFlags,
                            RotationAndAcceleration, ConfigAck, Flex, Position, ProtocolChange>;

struct Datagram {
  // Counts the tracker's datagrams; 0 is always accepted. A bundle has one number.
  std::uint64_t number = 0;
  std::size_t count = 0;
  std::array<Packet, kMaxPackets> packets{};
  std::size_t unknown = 0;  // packets of unlisted types, left out
};

enum class [[nodiscard]] UdpResult : std::uint8_t {
  kOk,
  kTooShort,  // shorter than a header or than a packet's fields
  kTooDeep,   // bundles in bundles beyond kMaxBundleDepth
  kTooMany,   // packets beyond kMaxPackets
  kNoAnswer,  // DecodeAnswer: not a packet of a server
  kCount
};
std::string_view Name(UdpResult result) noexcept;

// As lenient as the server: fields that old trackers leave out at a packet's end keep their
// defaults; fields that new ones add there are skipped; a length in a bundle that exceeds the
// bundle is cut; numbers that are not finite become 0; rotations that are not usable become
// identity and are marked. As strict as the server, too: one packet that is cut short refuses the
// whole datagram. `datagram` is unspecified unless kOk.
STYLED_REALTIME UdpResult Decode(std::span<const std::byte> bytes, Datagram& datagram) noexcept;

// Encoders write to the front of `out` and return the size; 0 if it does not fit.
std::size_t Encode(std::uint64_t number, const Packet& packet, std::span<std::byte> out) noexcept;
// Type 100; with `compact` type 101, whose packets must be shorter than 256 bytes.
std::size_t EncodeBundle(std::uint64_t number, std::span<const Packet> packets, bool compact,
                         std::span<std::byte> out) noexcept;

// A packet of the server: the reply to a handshake (without type and number), heartbeat (1), ping
// (10), its features (22), the acknowledgement of SensorInfo (15, without a number), a setting
// (25).
inline constexpr std::string_view kGreeting = "\x03Hey OVR =D 5";
struct Greeting {};
struct SensorInfoAck {
  std::uint8_t sensor = 0, status = 0;
};
struct SetConfig {
  std::uint8_t sensor = 255;  // 255: the whole device
  std::uint16_t what = 1;     // 1: magnetometer
  std::uint8_t state = 0;
};
using Answer = std::variant<Greeting, Heartbeat, Ping, FeatureFlags, SensorInfoAck, SetConfig>;

// Features of a server: it understands both kinds of bundles.
inline constexpr std::uint32_t kBundles = 1, kCompactBundles = 2;
inline constexpr std::size_t kMaxAnswerSize = 16;

STYLED_REALTIME UdpResult DecodeAnswer(std::span<const std::byte> bytes, Answer& answer) noexcept;
STYLED_REALTIME std::size_t EncodeAnswer(const Answer& answer, std::span<std::byte> out) noexcept;

}  // namespace styled::slimevr
