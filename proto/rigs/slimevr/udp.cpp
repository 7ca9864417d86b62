#include "proto/rigs/slimevr/udp.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "proto/rigs/big_endian.h"
#include "proto/rigs/result_name.h"

namespace styled::slimevr {
namespace {

constexpr std::uint32_t kBundleType = 100, kCompactBundleType = 101;
constexpr float kQ15 = 32768, kQ7 = 128;

class Reader : public rigs::BigEndianReader {
 public:
  using BigEndianReader::BigEndianReader;

  // Returns `otherwise` if fewer bytes are left than the number has.
  template <typename T>
  T NumberOr(T otherwise) noexcept {
    return left() < sizeof(T) ? otherwise : Number<T>();
  }
  float FiniteFloat() noexcept {
    const float value = Float();
    return std::isfinite(value) ? value : 0.0F;
  }
  std::array<float, 3> Float3() noexcept {
    const float x = FiniteFloat(), y = FiniteFloat(), z = FiniteFloat();
    return {x, y, z};
  }
  Orientation Quaternion() noexcept {
    const float x = Float(), y = Float(), z = Float(), w = Float();
    return MakeOrientation(x, y, z, w);
  }
  float Fixed(float one) noexcept { return static_cast<float>(Number<std::int16_t>()) / one; }
};

Handshake ReadHandshake(Reader& in) noexcept {
  Handshake h;
  h.board = in.NumberOr<std::uint32_t>(0);
  h.imu = in.NumberOr<std::uint32_t>(0);
  h.mcu = in.NumberOr<std::uint32_t>(0);
  if (in.left() >= 12) in.Bytes(12);  // IMU fields that are not used any more
  h.protocol = in.NumberOr<std::uint32_t>(0);
  h.firmware = in.Text(in.NumberOr<std::uint8_t>(0));
  if (in.left() >= h.mac.size()) {
    const auto mac = in.Bytes(h.mac.size());
    std::memcpy(h.mac.data(), mac.data(), mac.size());
  }
  h.tracker_type = in.NumberOr<std::uint8_t>(0);
  return h;
}

SensorInfo ReadSensorInfo(Reader& in) noexcept {
  SensorInfo s;
  s.sensor = in.U8();
  s.status = in.U8();
  s.imu = in.NumberOr<std::uint8_t>(0);
  s.config = in.NumberOr<std::uint16_t>(0);
  s.calibrated = in.NumberOr<std::uint8_t>(0);
  s.position = in.NumberOr<std::uint8_t>(0);
  s.data = in.NumberOr<std::uint8_t>(0);
  return s;
}

FeatureFlags ReadFlags(Reader& in) noexcept {
  FeatureFlags flags;
  for (unsigned shift = 0; shift < 32 && in.left() > 0; shift += 8) {
    flags.bits |= std::uint32_t{in.U8()} << shift;
  }
  return flags;
}

RotationAndAcceleration ReadMotion(Reader& in) noexcept {
  RotationAndAcceleration r;
  r.sensor = in.U8();
  const float x = in.Fixed(kQ15), y = in.Fixed(kQ15), z = in.Fixed(kQ15), w = in.Fixed(kQ15);
  r.motion.orientation = MakeOrientation(x, y, z, w);
  for (float& a : r.motion.acceleration_mps2) a = in.Fixed(kQ7);
  return r;
}

// Relies on the order of braced initializers, left to right. Returns false for an unknown type.
bool ReadPacket(std::uint32_t type, Reader& in, Packet& packet) noexcept {
  switch (type) {
    case 0:
      packet = Heartbeat{};
      return true;
    case 1:
    case 16:
      packet = LegacyRotation{static_cast<std::uint8_t>(type == 16 ? 1 : 0), in.Quaternion()};
      return true;
    case 3:
      packet = ReadHandshake(in);
      return true;
    case 4:
      packet = Acceleration{in.Float3(), in.NumberOr<std::uint8_t>(0)};
      return true;
    case 10:
      packet = Ping{in.U32()};
      return true;
    case 11:
      packet = Text{in.Text(in.U32())};
      return true;
    // Old firmware sends the level only, new firmware the voltage before it.
    case 12: {
      const bool both = in.left() >= 8;
      packet = BatteryLevel{both ? in.FiniteFloat() : 0.0F, in.FiniteFloat()};
      return true;
    }
    case 13:
      packet = Tap{in.U8(), in.U8()};
      return true;
    case 14:
      packet = Error{in.U8(), in.U8()};
      return true;
    case 15:
      packet = ReadSensorInfo(in);
      return true;
    case 17:
      packet = Rotation{in.U8(), in.U8(), in.Quaternion(), in.NumberOr<std::uint8_t>(0)};
      return true;
    case 18:
      packet = MagnetometerAccuracy{in.U8(), in.FiniteFloat()};
      return true;
    case 19:
      packet = SignalStrength{in.U8(), in.Number<std::int8_t>()};
      return true;
    case 20:
      packet = Temperature{in.U8(), in.left() >= 4 ? in.FiniteFloat() : 0.0F};
      return true;
    case 21:
      packet = UserAction{in.U8()};
      return true;
    case 22:
      packet = ReadFlags(in);
      return true;
    case 23:
      packet = ReadMotion(in);
      return true;
    case 24:
      packet = ConfigAck{in.U8(), in.Number<std::uint16_t>()};
      return true;
    case 26:
      packet = Flex{in.U8(), in.FiniteFloat()};
      return true;
    case 27:
      packet = Position{in.U8(), in.Float3()};
      return true;
    case 200:
      packet = ProtocolChange{in.U8(), in.U8()};
      return true;
    default:
      return false;
  }
}

UdpResult ReadPackets(std::uint32_t type, Reader& in, int depth, Datagram& datagram) noexcept {
  if (type != kBundleType && type != kCompactBundleType) {
    if (datagram.count == kMaxPackets) return UdpResult::kTooMany;
    if (ReadPacket(type, in, datagram.packets[datagram.count])) {
      ++datagram.count;
    } else {
      ++datagram.unknown;
    }
    return in.ok() ? UdpResult::kOk : UdpResult::kTooShort;
  }
  if (depth == kMaxBundleDepth) return UdpResult::kTooDeep;
  const bool compact = type == kCompactBundleType;
  while (in.left() > 0) {
    const std::size_t length = compact ? in.U8() : in.Number<std::uint16_t>();
    if (!in.ok()) return UdpResult::kTooShort;
    if (length == 0) continue;
    // A length that exceeds the bundle is cut, as the server does.
    Reader inner(in.Bytes(std::min(length, in.left())));
    const std::uint32_t inner_type = compact ? inner.U8() : inner.U32();
    if (!inner.ok()) return UdpResult::kTooShort;
    const UdpResult result = ReadPackets(inner_type, inner, depth + 1, datagram);
    if (result != UdpResult::kOk) return result;
  }
  return UdpResult::kOk;
}

}  // namespace

std::string_view Name(UdpResult result) noexcept {
  return rigs::ResultName(result, {"ok", "too_short", "too_deep", "too_many", "no_answer"});
}

UdpResult Decode(std::span<const std::byte> bytes, Datagram& datagram) noexcept {
  Reader in(bytes);
  const auto type = in.U32();
  datagram.number = in.Number<std::uint64_t>();
  datagram.count = datagram.unknown = 0;
  if (!in.ok()) return UdpResult::kTooShort;
  return ReadPackets(type, in, 0, datagram);
}

UdpResult DecodeAnswer(std::span<const std::byte> bytes, Answer& answer) noexcept {
  if (bytes.size() >= kGreeting.size() &&
      std::memcmp(bytes.data(), kGreeting.data(), kGreeting.size()) == 0) {
    answer = Greeting{};
    return UdpResult::kOk;
  }
  Reader in(bytes);
  const auto type = in.U32();
  if (in.ok() && type == 15) {
    const SensorInfoAck ack{in.U8(), in.U8()};
    if (!in.ok()) return UdpResult::kTooShort;
    answer = ack;
    return UdpResult::kOk;
  }
  in.Bytes(8);
  if (!in.ok()) return UdpResult::kTooShort;
  Answer read;
  switch (type) {
    case 1:
      read = Heartbeat{};
      break;
    case 10:
      read = Ping{in.U32()};
      break;
    case 22:
      read = ReadFlags(in);
      break;
    case 25:
      read = SetConfig{in.U8(), in.Number<std::uint16_t>(), in.U8()};
      break;
    default:
      return UdpResult::kNoAnswer;
  }
  if (!in.ok()) return UdpResult::kTooShort;
  answer = read;
  return UdpResult::kOk;
}

}  // namespace styled::slimevr
