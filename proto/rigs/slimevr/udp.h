#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <variant>

#include "model/base/realtime.h"
#include "proto/rigs/slimevr/hid.h"

// SlimeVR's trackers over UDP (port 6969): big-endian packets, each a type and a body, one or a
// bundle of them per datagram. Facts from SlimeVR's ESP firmware (what is written: connection.cpp,
// packets.h) and its server (what is read and answered: UDPPacket.kt, UDPProtocolParser.kt), both
// MIT/Apache. Pure functions, any thread, no allocation. Pinned by tests/unit/slimevr, fuzzed by
// tests/fuzz/slimevr.
namespace styled::slimevr {

inline constexpr std::size_t kMaxUdpSize = 1472;  // of Ethernet; trackers send no larger ones
inline constexpr std::size_t kMaxPackets = 128;   // in one datagram
inline constexpr int kMaxBundleDepth = 2;         // real trackers: 1

// Every packet's type on the wire is said beside it. Texts point into the bytes decoded.
struct Heartbeat {};  // 0
// 1 (sensor 0) and 16 (sensor 1), from the time before 17. Axes as Orientation says, always.
struct LegacyRotation {
  std::uint8_t sensor = 0;
  Orientation orientation;
};
struct Handshake {  // 3; a tracker seeks a server with it
  std::uint32_t board = 0, imu = 0, mcu = 0;
  std::uint32_t protocol = 0;
  std::string_view firmware;          // up to 255
  std::array<std::uint8_t, 6> mac{};  // all zero: none told
  std::uint8_t tracker_type = 0;
};
struct Acceleration {  // 4
  std::array<float, 3> acceleration_mps2{};
  std::uint8_t sensor = 0;
};
struct Ping {  // 10; comes back as the server sent it
  std::uint32_t id = 0;
};
struct Text {  // 11
  std::string_view text;
};
struct BatteryLevel {  // 12
  float volts = 0;     // 0: none told
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
  std::uint8_t position = 0;  // where it says it is worn, a TrackerPosition; 0: not told
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
  std::uint32_t bits = 0;  // bit 0 of the first byte lowest; what lies beyond 32 is left out
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

// What a tracker says.
using Packet = std::variant<Heartbeat, LegacyRotation, Handshake, Acceleration, Ping, Text,
                            BatteryLevel, Tap, Error, SensorInfo, Rotation, MagnetometerAccuracy,
                            SignalStrength, Temperature, UserAction, FeatureFlags,
                            RotationAndAcceleration, ConfigAck, Flex, Position, ProtocolChange>;

struct Datagram {
  // Counts up over a tracker's datagrams; 0 is always to be taken. One for a whole bundle.
  std::uint64_t number = 0;
  std::size_t count = 0;
  std::array<Packet, kMaxPackets> packets{};
  std::size_t unknown = 0;  // packets of a type not listed, left out
};

enum class [[nodiscard]] UdpResult : std::uint8_t {
  kOk,
  kTooShort,  // less than a header, or than a packet needs
  kTooDeep,   // bundles in bundles beyond kMaxBundleDepth
  kTooMany,   // packets beyond kMaxPackets
  kNoAnswer,  // DecodeAnswer: nothing that a server says
  kCount
};
std::string_view Name(UdpResult result) noexcept;

// As lenient as the server: what old trackers leave out at a packet's end has its default, what
// new ones add there is passed over, a length in a bundle that leaves it is cut, numbers that are
// not finite are 0, rotations that are not usable are identity and say so. As strict as it in that
// one packet cut short refuses its whole datagram. `datagram` is unspecified unless kOk.
STYLED_REALTIME UdpResult Decode(std::span<const std::byte> bytes, Datagram& datagram) noexcept;

// Encoders write to the front of `out` and return the size; 0 where it does not fit.
std::size_t Encode(std::uint64_t number, const Packet& packet, std::span<std::byte> out) noexcept;
// Type 100, or compact: 101, whose packets are shorter than 256.
std::size_t EncodeBundle(std::uint64_t number, std::span<const Packet> packets, bool compact,
                         std::span<std::byte> out) noexcept;

// What the server says: the answer to a handshake (which has neither type nor number), heartbeat
// (1), ping (10), its features (22), an acknowledgement of SensorInfo (15, without a number), a
// switch (25).
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

// Features of a server: both kinds of bundles are understood.
inline constexpr std::uint32_t kBundles = 1, kCompactBundles = 2;
inline constexpr std::size_t kMaxAnswerSize = 16;

STYLED_REALTIME UdpResult DecodeAnswer(std::span<const std::byte> bytes, Answer& answer) noexcept;
STYLED_REALTIME std::size_t EncodeAnswer(const Answer& answer, std::span<std::byte> out) noexcept;

}  // namespace styled::slimevr
