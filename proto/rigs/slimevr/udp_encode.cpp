#include <algorithm>
#include <cmath>
#include <initializer_list>

#include "proto/rigs/big_endian.h"
#include "proto/rigs/slimevr/udp.h"

namespace styled::slimevr {
namespace {

constexpr std::uint32_t kBundleType = 100, kCompactBundleType = 101;
constexpr float kQ15 = 32768, kQ7 = 128;

class Writer : public rigs::BigEndianWriter {
 public:
  using BigEndianWriter::BigEndianWriter;

  void Fixed(std::span<const float> values, float one) noexcept {
    for (const float value : values) {
      const float scaled = std::isfinite(value) ? std::round(value * one) : 0.0F;
      const auto fixed = static_cast<std::int16_t>(std::clamp(scaled, -32768.0F, 32767.0F));
      Number(static_cast<std::uint16_t>(fixed));
    }
  }
};

// A packet's type on the wire. WriteBody below writes its body.
struct TypeOf {
  std::uint8_t operator()(const Heartbeat&) const noexcept { return 0; }
  std::uint8_t operator()(const LegacyRotation& p) const noexcept { return p.sensor == 0 ? 1 : 16; }
  std::uint8_t operator()(const Handshake&) const noexcept { return 3; }
  std::uint8_t operator()(const Acceleration&) const noexcept { return 4; }
  std::uint8_t operator()(const Ping&) const noexcept { return 10; }
  std::uint8_t operator()(const Text&) const noexcept { return 11; }
  std::uint8_t operator()(const BatteryLevel&) const noexcept { return 12; }
  std::uint8_t operator()(const Tap&) const noexcept { return 13; }
  std::uint8_t operator()(const Error&) const noexcept { return 14; }
  std::uint8_t operator()(const SensorInfo&) const noexcept { return 15; }
  std::uint8_t operator()(const Rotation&) const noexcept { return 17; }
  std::uint8_t operator()(const MagnetometerAccuracy&) const noexcept { return 18; }
  std::uint8_t operator()(const SignalStrength&) const noexcept { return 19; }
  std::uint8_t operator()(const Temperature&) const noexcept { return 20; }
  std::uint8_t operator()(const UserAction&) const noexcept { return 21; }
  std::uint8_t operator()(const FeatureFlags&) const noexcept { return 22; }
  std::uint8_t operator()(const RotationAndAcceleration&) const noexcept { return 23; }
  std::uint8_t operator()(const ConfigAck&) const noexcept { return 24; }
  std::uint8_t operator()(const Flex&) const noexcept { return 26; }
  std::uint8_t operator()(const Position&) const noexcept { return 27; }
  std::uint8_t operator()(const ProtocolChange&) const noexcept { return 200; }
};

struct WriteBody {
  Writer& out;

  void operator()(const Heartbeat&) const noexcept {}
  void operator()(const LegacyRotation& p) const noexcept { out.Floats(p.orientation.rotation); }
  void operator()(const Handshake& p) const noexcept {
    for (const std::uint32_t value : {p.board, p.imu, p.mcu, 0U, 0U, 0U, p.protocol}) {
      out.Number(value);
    }
    const std::string_view firmware = p.firmware.substr(0, 255);
    out.U8(static_cast<std::uint8_t>(firmware.size()));
    out.Text(firmware);
    for (const std::uint8_t value : p.mac) out.U8(value);
    out.U8(p.tracker_type);
  }
  void operator()(const Acceleration& p) const noexcept {
    out.Floats(p.acceleration_mps2);
    out.U8(p.sensor);
  }
  void operator()(const Ping& p) const noexcept { out.Number(p.id); }
  void operator()(const Text& p) const noexcept {
    out.Number(static_cast<std::uint32_t>(p.text.size()));
    out.Text(p.text);
  }
  void operator()(const BatteryLevel& p) const noexcept {
    out.Float(p.volts);
    out.Float(p.level);
  }
  void operator()(const Tap& p) const noexcept { Bytes({p.sensor, p.value}); }
  void operator()(const Error& p) const noexcept { Bytes({p.sensor, p.code}); }
  void operator()(const SensorInfo& p) const noexcept {
    Bytes({p.sensor, p.status, p.imu});
    out.Number(p.config);
    Bytes({p.calibrated, p.position, p.data});
  }
  void operator()(const Rotation& p) const noexcept {
    Bytes({p.sensor, p.kind});
    out.Floats(p.orientation.rotation);
    out.U8(p.accuracy);
  }
  void operator()(const MagnetometerAccuracy& p) const noexcept { Scalar(p.sensor, p.accuracy); }
  void operator()(const SignalStrength& p) const noexcept {
    Bytes({p.sensor, static_cast<std::uint8_t>(p.dbm)});
  }
  void operator()(const Temperature& p) const noexcept { Scalar(p.sensor, p.celsius); }
  void operator()(const UserAction& p) const noexcept { out.U8(p.action); }
  void operator()(const FeatureFlags& p) const noexcept {
    out.U8(static_cast<std::uint8_t>(p.bits & 0xFFU));
    for (std::uint32_t rest = p.bits >> 8U; rest != 0; rest >>= 8U) {
      out.U8(static_cast<std::uint8_t>(rest & 0xFFU));
    }
  }
  void operator()(const RotationAndAcceleration& p) const noexcept {
    out.U8(p.sensor);
    out.Fixed(p.motion.orientation.rotation, kQ15);
    out.Fixed(p.motion.acceleration_mps2, kQ7);
  }
  void operator()(const ConfigAck& p) const noexcept {
    out.U8(p.sensor);
    out.Number(p.what);
  }
  void operator()(const Flex& p) const noexcept { Scalar(p.sensor, p.value); }
  void operator()(const Position& p) const noexcept {
    out.U8(p.sensor);
    out.Floats(p.position_m);
  }
  void operator()(const ProtocolChange& p) const noexcept { Bytes({p.protocol, p.version}); }

  void Bytes(std::initializer_list<std::uint8_t> values) const noexcept {
    for (const std::uint8_t value : values) out.U8(value);
  }
  void Scalar(std::uint8_t sensor, float value) const noexcept {
    out.U8(sensor);
    out.Float(value);
  }
};

void WriteHeader(Writer& out, std::uint32_t type, std::uint64_t number) noexcept {
  out.Number(type);
  out.Number(number);
}

}  // namespace

std::size_t Encode(std::uint64_t number, const Packet& packet, std::span<std::byte> out) noexcept {
  Writer writer(out);
  WriteHeader(writer, std::visit(TypeOf{}, packet), number);
  std::visit(WriteBody{writer}, packet);
  return writer.size();
}

std::size_t EncodeBundle(std::uint64_t number, std::span<const Packet> packets, bool compact,
                         std::span<std::byte> out) noexcept {
  Writer writer(out);
  WriteHeader(writer, compact ? kCompactBundleType : kBundleType, number);
  for (const Packet& packet : packets) {
    std::array<std::byte, 1024> body;
    Writer inner(body);
    const std::uint8_t type = std::visit(TypeOf{}, packet);
    compact ? inner.U8(type) : inner.Number(std::uint32_t{type});
    std::visit(WriteBody{inner}, packet);
    const std::size_t size = inner.size();
    if (size == 0 || (compact && size > 255)) return 0;
    compact ? writer.U8(static_cast<std::uint8_t>(size))
            : writer.Number(static_cast<std::uint16_t>(size));
    for (std::size_t i = 0; i < size; ++i) writer.U8(std::to_integer<std::uint8_t>(body[i]));
  }
  return writer.size();
}

std::size_t EncodeAnswer(const Answer& answer, std::span<std::byte> out) noexcept {
  Writer writer(out);
  if (std::holds_alternative<Greeting>(answer)) {
    writer.Text(kGreeting);
  } else if (const auto* ack = std::get_if<SensorInfoAck>(&answer)) {
    writer.Number(std::uint32_t{15});
    writer.U8(ack->sensor);
    writer.U8(ack->status);
  } else if (std::holds_alternative<Heartbeat>(answer)) {
    WriteHeader(writer, 1, 0);
  } else if (const auto* ping = std::get_if<Ping>(&answer)) {
    WriteHeader(writer, 10, 0);
    writer.Number(ping->id);
  } else if (const auto* flags = std::get_if<FeatureFlags>(&answer)) {
    WriteHeader(writer, 22, 0);
    WriteBody{writer}(*flags);
  } else if (const auto* config = std::get_if<SetConfig>(&answer)) {
    WriteHeader(writer, 25, 0);
    writer.U8(config->sensor);
    writer.Number(config->what);
    writer.U8(config->state);
  }
  return writer.size();
}

}  // namespace styled::slimevr
