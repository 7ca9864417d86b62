#include "daemon/source/rigs/slimevr.h"

#include <algorithm>
#include <array>
#include <cstring>

#include "daemon/runtime/clock.h"
#include "daemon/source/rigs/tracker_rig.h"
#include "proto/rigs/slimevr/udp.h"

namespace styled::source {
namespace {

using runtime::Counter;

constexpr std::size_t kMaxDevices = 64;
constexpr std::int64_t kHeartbeat_ns = runtime::kSecond_ns / 2;
constexpr std::int64_t kSilent_ns = 5 * runtime::kSecond_ns;
// From this protocol on every sensor is announced before it counts; older firmware has one.
constexpr std::uint32_t kAnnouncesSensors = 9;

// A tracker's board with its sensors.
struct Device {
  static constexpr int kUnannounced = -2;

  Peer peer;
  std::uint64_t address = 0;
  std::int64_t heard_ns = 0;
  std::uint64_t number = 0;  // of the last datagram
  std::uint64_t number_before_greeting = 0;
  bool complained = false;
  std::array<std::int8_t, 256> parts{};  // by sensor: a joint, kUnassigned or kUnannounced
};

std::uint64_t AddressOf(const slimevr::Handshake& handshake, const Peer& peer) {
  std::uint64_t address = 0;
  for (const std::uint8_t byte : handshake.mac) address = address << 8U | byte;
  if (address != 0) return address;
  std::uint32_t ip = 0;
  if (peer.address.ss_family == AF_INET) {
    ip = ntohl(reinterpret_cast<const sockaddr_in&>(peer.address).sin_addr.s_addr);
  }
  return kIsIpv4 | ip;
}

class SlimeVr final : public Translator {
 public:
  explicit SlimeVr(const config::Source& config) : rig_(config) { devices_.reserve(kMaxDevices); }

  void Take(std::span<const std::byte> bytes, const Peer& peer, std::int64_t now_ns,
            Outbox& out) override {
    if (slimevr::Decode(bytes, datagram_) != slimevr::UdpResult::kOk) {
      return out.Refuse(Counter::kSourceMalformed);
    }
    const std::span packets(datagram_.packets.data(), datagram_.count);
    for (const slimevr::Packet& packet : packets) {
      const auto* handshake = std::get_if<slimevr::Handshake>(&packet);
      if (handshake != nullptr) return Greet(*handshake, peer, now_ns, out);
    }
    const auto device =
        std::ranges::find(devices_, peer.id, [](const Device& d) { return d.peer.id; });
    // Of a tracker that knew a daemon before us: it gives up after 3 s and greets us.
    if (device == devices_.end()) return out.Refuse(Counter::kSourceIgnored);
    if (!IsNext(*device, out)) return;
    device->heard_ns = now_ns;
    if (datagram_.unknown > 0) out.Refuse(Counter::kSourceIgnored);
    for (const slimevr::Packet& packet : packets) TakePacket(packet, *device, now_ns, out);
  }

  void Tick(std::int64_t now_ns, Outbox& out) override {
    rig_.Tick(now_ns, out);
    if (now_ns < next_heartbeat_ns_) return;
    next_heartbeat_ns_ = kNever;
    ++ping_;
    for (const Device& device : devices_) {
      if (now_ns - device.heard_ns > kSilent_ns) continue;
      next_heartbeat_ns_ = now_ns + kHeartbeat_ns;
      Answer(slimevr::Heartbeat{}, device.peer, out);
      Answer(slimevr::Ping{ping_}, device.peer, out);
    }
  }

  std::int64_t NextDeadline_ns() const override {
    return std::min(next_heartbeat_ns_, rig_.NextDeadline_ns());
  }

  bool has_sensors() const override { return true; }
  Status Calibrate(Calibration what, std::int64_t now_ns) override {
    return rig_.Calibrate(what, now_ns);
  }

 private:
  static void Answer(const slimevr::Answer& answer, const Peer& peer, Outbox& out) {
    std::array<std::byte, slimevr::kMaxAnswerSize> bytes;
    out.Reply(peer, std::span(bytes).first(slimevr::EncodeAnswer(answer, bytes)));
  }

  void Greet(const slimevr::Handshake& handshake, const Peer& peer, std::int64_t now_ns,
             Outbox& out) {
    const std::uint64_t address = AddressOf(handshake, peer);
    // A board that comes from another port is the same; another one at that port has taken its
    // place.
    auto device = std::ranges::find(devices_, address, &Device::address);
    if (device == devices_.end()) {
      device = std::ranges::find(devices_, peer.id, [](const Device& d) { return d.peer.id; });
    }
    if (device == devices_.end()) {
      device = FindRoom(now_ns);
      if (device == devices_.end()) return out.Refuse(Counter::kSourceIgnored);
    }
    if (device->address != address) {
      *device = Device();
      device->address = address;
      device->parts.fill(Device::kUnannounced);
    }
    for (Device& other : devices_) {
      if (other.peer.id == peer.id) other.peer.id = 0;
    }
    device->peer = peer;
    device->heard_ns = now_ns;
    device->number_before_greeting = device->number;
    device->number = 0;
    if (handshake.firmware.empty() || handshake.protocol < kAnnouncesSensors) {
      Announce(*device, 0, 0, out);
    }
    if (next_heartbeat_ns_ == kNever) next_heartbeat_ns_ = now_ns + kHeartbeat_ns;
    Answer(slimevr::Greeting{}, peer, out);
  }

  // A new device, or the one that was silent for longest; end() where all are live.
  std::vector<Device>::iterator FindRoom(std::int64_t now_ns) {
    if (devices_.size() < kMaxDevices) return devices_.emplace(devices_.end());  // reserved
    const auto oldest = std::ranges::min_element(devices_, {}, &Device::heard_ns);
    return now_ns - oldest->heard_ns > kSilent_ns ? oldest : devices_.end();
  }

  // As the server has it: 0 is always taken. Numbers that begin anew after a greeting are those of
  // a board that was switched on again, and has another heading since.
  bool IsNext(Device& device, Outbox& out) {
    const std::uint64_t number = datagram_.number;
    if (number == 0) return true;
    if (number <= device.number) {
      out.Refuse(number == device.number ? Counter::kPipelineDuplicate
                                         : Counter::kPipelineReordered);
      return false;
    }
    if (number < device.number_before_greeting) {
      out.LeaveHotSection();
      out.Note("tracker " + ToText({device.address, 0}) +
               " was switched on again: its heading is lost until the next reset");
    }
    device.number_before_greeting = 0;
    device.number = number;
    return true;
  }

  void Announce(Device& device, std::uint8_t sensor, int position, Outbox& out) {
    device.parts[sensor] =
        static_cast<std::int8_t>(rig_.PartOf({device.address, sensor}, position, out));
  }

  void TakePacket(const slimevr::Packet& packet, Device& device, std::int64_t now_ns, Outbox& out) {
    if (const auto* p = std::get_if<slimevr::Rotation>(&packet)) {
      if (p->kind == 1) TakeOrientation(device, p->sensor, p->orientation, now_ns, out);
    } else if (const auto* p = std::get_if<slimevr::RotationAndAcceleration>(&packet)) {
      TakeOrientation(device, p->sensor, p->motion.orientation, now_ns, out);
    } else if (const auto* p = std::get_if<slimevr::LegacyRotation>(&packet)) {
      TakeOrientation(device, p->sensor, p->orientation, now_ns, out);
    } else if (const auto* p = std::get_if<slimevr::SensorInfo>(&packet)) {
      Announce(device, p->sensor, p->position, out);
      Answer(slimevr::SensorInfoAck{p->sensor, p->status}, device.peer, out);
    } else if (std::holds_alternative<slimevr::FeatureFlags>(packet)) {
      Answer(slimevr::FeatureFlags{slimevr::kBundles | slimevr::kCompactBundles}, device.peer, out);
    } else if (const auto* p = std::get_if<slimevr::UserAction>(&packet)) {
      Act(p->action, now_ns, out);
    } else if (const auto* p = std::get_if<slimevr::Error>(&packet)) {
      Complain(device, *p, out);
    }
  }

  void TakeOrientation(Device& device, std::uint8_t sensor, const slimevr::Orientation& orientation,
                       std::int64_t now_ns, Outbox& out) {
    const int part = device.parts[sensor];
    if (part < 0) return out.Refuse(Counter::kSourceIgnored);
    rig_.Take(body::Joint(part), orientation, now_ns);
  }

  void Act(std::uint8_t action, std::int64_t now_ns, Outbox& out) {
    Calibration what = Calibration::kFull;
    switch (action) {
      case slimevr::UserAction::kFullReset:
        break;
      case slimevr::UserAction::kYawReset:
        what = Calibration::kYaw;
        break;
      case slimevr::UserAction::kMountingReset:
        what = Calibration::kMounting;
        break;
      default:
        return out.Refuse(Counter::kSourceIgnored);
    }
    out.LeaveHotSection();
    const Status status = rig_.Calibrate(what, now_ns);
    if (!status.ok()) out.Note("a tracker's button asked for a reset: " + status.message());
  }

  void Complain(Device& device, const slimevr::Error& error, Outbox& out) {
    if (device.complained) return;
    device.complained = true;
    out.LeaveHotSection();
    out.Note("tracker " + ToText({device.address, error.sensor}) + " reports error " +
             std::to_string(error.code));
  }

  TrackerRig rig_;
  std::vector<Device> devices_;
  slimevr::Datagram datagram_;
  std::int64_t next_heartbeat_ns_ = kNever;
  std::uint32_t ping_ = 0;
};

}  // namespace

std::unique_ptr<Translator> MakeSlimeVr(const config::Source& config) {
  return std::make_unique<SlimeVr>(config);
}

}  // namespace styled::source
