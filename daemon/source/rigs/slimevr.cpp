#include "daemon/source/rigs/slimevr.h"

#include <algorithm>
#include <array>
#include <random>

#include "daemon/runtime/clock.h"
#include "daemon/runtime/sockets.h"
#include "daemon/source/note_limit.h"
#include "daemon/source/rigs/slimevr_hid.h"
#include "daemon/source/rigs/tracker_rig.h"
#include "proto/rigs/slimevr/udp.h"
#include "proto/rigs/types.h"

namespace styled::source {
namespace {

using runtime::AddressText;
using runtime::Counter;

// Includes the devices that the configuration names, each of which has a reserved place.
constexpr std::size_t kMaxDevices = 64;
constexpr std::int64_t kHeartbeat_ns = runtime::kSecond_ns / 2;
constexpr std::int64_t kDeviceSilent_ns = 5 * runtime::kSecond_ns;
// A tracker is live, and bound to its address, until it was silent for this long. It replies to a
// heartbeat and a ping every kHeartbeat_ns, so silence means that four of each were lost, more than
// in Wi-Fi's bursts. A tracker that appears at another address either searched for a server after 3
// s without this one, or was switched off.
constexpr std::int64_t kTakeover_ns = 2 * runtime::kSecond_ns;
// From this protocol on every sensor is announced before use; older firmware has one sensor.
constexpr std::uint32_t kAnnouncesSensors = 9;

// A tracker's board with its sensors.
struct Device {
  static constexpr int kUnannounced = -2;

  Device() {
    peer.id = 0;
    parts.fill(kUnannounced);
  }

  Peer peer;  // id 0: none
  std::uint64_t address = 0;
  bool configured = false;
  std::int64_t heard_ns = 0;
  std::int64_t since_ns = 0;  // since when it is at `peer`
  std::uint32_t ping = 0;     // the id of the last ping to `peer`
  bool answers = false;       // `peer` returned a ping, so its address is real
  std::uint64_t number = 0;   // of the last datagram
  std::int64_t number_ns = 0;
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
  return slimevr::kIsIpv4 | ip;
}

class SlimeVr final : public Translator {
 public:
  explicit SlimeVr(const config::Source& config) : rig_(config), random_(std::random_device()()) {
    devices_.reserve(kMaxDevices);
    for (const std::uint64_t address : rig_.ConfiguredDevices()) {
      Device& device = devices_.emplace_back();
      device.address = address;
      device.configured = true;
    }
    has_table_ = !devices_.empty();
  }

  void Handle(std::span<const std::byte> bytes, const Peer& peer, std::int64_t now_ns,
              Outbox& out) override {
    if (slimevr::Decode(bytes, datagram_) != slimevr::UdpResult::kOk) {
      return out.Refuse(Counter::kSourceMalformed);
    }
    const std::span packets(datagram_.packets.data(), datagram_.count);
    for (const slimevr::Packet& packet : packets) {
      const auto* handshake = std::get_if<slimevr::Handshake>(&packet);
      if (handshake != nullptr) return Greet(*handshake, peer, now_ns, out);
    }
    Device* device = At(peer);
    // A tracker that is bound to another server: it gives up after 3 s and sends a handshake.
    if (device == nullptr) return out.Refuse(Counter::kSourceIgnored);
    if (!IsNext(*device, now_ns, out)) return;
    device->heard_ns = now_ns;
    if (datagram_.unknown > 0) out.Refuse(Counter::kSourceIgnored);
    for (const slimevr::Packet& packet : packets) HandlePacket(packet, *device, now_ns, out);
  }

  void Tick(std::int64_t now_ns, Outbox& out) override {
    rig_.Tick(now_ns, out);
    if (now_ns < next_heartbeat_ns_) return;
    next_heartbeat_ns_ = kNever;
    for (Device& device : devices_) {
      if (device.peer.id == 0 || now_ns - device.heard_ns > kDeviceSilent_ns) continue;
      next_heartbeat_ns_ = now_ns + kHeartbeat_ns;
      Answer(slimevr::Heartbeat{}, device.peer, out);
      device.ping = static_cast<std::uint32_t>(random_()) | 1U;
      Answer(slimevr::Ping{device.ping}, device.peer, out);
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

  Device* At(const Peer& peer) {
    const auto found =
        std::ranges::find(devices_, peer.id, [](const Device& d) { return d.peer.id; });
    return found == devices_.end() ? nullptr : &*found;
  }

  // Whether the device is protected against takeover: it is live, and its address has returned a
  // ping or is new. A forged address never receives the ping.
  static bool Holds(const Device& device, std::int64_t now_ns) {
    return device.peer.id != 0 && now_ns - device.heard_ns <= kTakeover_ns &&
           (device.answers || now_ns - device.since_ns <= kTakeover_ns);
  }

  // Only an admitted tracker gets a reply, at the address of its handshake.
  void Greet(const slimevr::Handshake& handshake, const Peer& peer, std::int64_t now_ns,
             Outbox& out) {
    const std::uint64_t address = AddressOf(handshake, peer);
    const auto found = std::ranges::find(devices_, address, &Device::address);
    Device* device = found == devices_.end() ? nullptr : &*found;
    Device* here = At(peer);
    if (here != nullptr && here != device && Holds(*here, now_ns)) {
      return RefuseTakeover(*here, address, peer, now_ns, out);
    }
    if (device != nullptr && device != here && Holds(*device, now_ns)) {
      return RefuseTakeover(*device, address, peer, now_ns, out);
    }
    if (device == nullptr) {
      device = here != nullptr && !here->configured ? here : FindRoom(now_ns);
      if (device == nullptr) return ReportFull(address, peer, now_ns, out);
      *device = Device();
      device->address = address;
    }
    if (here != nullptr && here != device) here->peer.id = 0;
    if (device->peer.id != peer.id) {
      device->since_ns = now_ns;
      device->answers = false;
      device->ping = 0;
    }
    device->peer = peer;
    device->heard_ns = now_ns;
    device->number_before_greeting = device->number;
    device->number = 0;
    if (handshake.firmware.empty() || handshake.protocol < kAnnouncesSensors) {
      Announce(*device, 0, 0, now_ns, out);
    }
    if (next_heartbeat_ns_ == kNever) next_heartbeat_ns_ = now_ns + kHeartbeat_ns;
    Answer(slimevr::Greeting{}, peer, out);
  }

  void RefuseTakeover(const Device& live, std::uint64_t address, const Peer& peer,
                      std::int64_t now_ns, Outbox& out) {
    out.Refuse(Counter::kSourceTakeovers);
    const std::uint64_t times = takeover_notes_.Count(now_ns);
    if (times == 0) return;
    out.Note([&] {
      return "tracker " + slimevr::ToText({live.address, 0}) + " is live at " +
             AddressText(live.peer.address, live.peer.address_size) + ": a greeting " +
             (live.address == address ? "" : "of " + slimevr::ToText({address, 0}) + " ") +
             "from " + AddressText(peer.address, peer.address_size) +
             " is refused until that was silent for " +
             std::to_string(kTakeover_ns / runtime::kSecond_ns) + " s" + Times(times);
    });
  }

  // A place for a new device: a free one, or that of the device that was silent for longest. Null
  // if all devices are live or reserved by the configuration.
  Device* FindRoom(std::int64_t now_ns) {
    // Never reallocates, because the capacity is reserved.
    if (devices_.size() < kMaxDevices) return &devices_.emplace_back();
    Device* oldest = nullptr;
    for (Device& device : devices_) {
      const bool silent = now_ns - device.heard_ns > kDeviceSilent_ns;
      const bool made_up = !device.answers && now_ns - device.since_ns > kTakeover_ns;
      if (device.configured || (device.peer.id != 0 && !silent && !made_up)) continue;
      if (oldest == nullptr || device.heard_ns < oldest->heard_ns) oldest = &device;
    }
    return oldest;
  }

  void ReportFull(std::uint64_t address, const Peer& peer, std::int64_t now_ns, Outbox& out) {
    out.Refuse(Counter::kSourceTableFull);
    const std::uint64_t times = full_notes_.Count(now_ns);
    if (times == 0) return;
    out.Note([&] {
      return "there is room for " + std::to_string(kMaxDevices) +
             " trackers, all of it taken: " + slimevr::ToText({address, 0}) + " from " +
             AddressText(peer.address, peer.address_size) +
             " is refused; those named in `trackers` have a reserved place" + Times(times);
    });
  }

  // Checks the packet number as SlimeVR's server does: 0 is always accepted. Numbers that start
  // again after a handshake mean that the board was switched on again and has another heading. If
  // no number was accepted for kTakeover_ns, the last one was wrong, and numbering starts again,
  // too.
  bool IsNext(Device& device, std::int64_t now_ns, Outbox& out) {
    const std::uint64_t number = datagram_.number;
    if (number == 0) return true;
    if (number <= device.number && now_ns - device.number_ns <= kTakeover_ns) {
      out.Refuse(number == device.number ? Counter::kPipelineDuplicate
                                         : Counter::kPipelineReordered);
      return false;
    }
    if (number < device.number_before_greeting) {
      if (const std::uint64_t times = restart_notes_.Count(now_ns)) {
        out.Note([&] {
          return "tracker " + slimevr::ToText({device.address, 0}) +
                 " was switched on again: its heading is lost until the next reset" + Times(times);
        });
      }
    }
    device.number_before_greeting = 0;
    device.number = number;
    device.number_ns = now_ns;
    return true;
  }

  void Announce(Device& device, std::uint8_t sensor, int position, std::int64_t now_ns,
                Outbox& out) {
    device.parts[sensor] =
        static_cast<std::int8_t>(rig_.PartOf({device.address, sensor}, position, now_ns, out));
  }

  void HandlePacket(const slimevr::Packet& packet, Device& device, std::int64_t now_ns,
                    Outbox& out) {
    if (const auto* p = std::get_if<slimevr::Rotation>(&packet)) {
      if (p->kind == 1) HandleOrientation(device, p->sensor, p->orientation, now_ns, out);
    } else if (const auto* p = std::get_if<slimevr::RotationAndAcceleration>(&packet)) {
      HandleOrientation(device, p->sensor, p->motion.orientation, now_ns, out);
    } else if (const auto* p = std::get_if<slimevr::LegacyRotation>(&packet)) {
      HandleOrientation(device, p->sensor, p->orientation, now_ns, out);
    } else if (const auto* p = std::get_if<slimevr::SensorInfo>(&packet)) {
      Announce(device, p->sensor, p->position, now_ns, out);
      Answer(slimevr::SensorInfoAck{p->sensor, p->status}, device.peer, out);
    } else if (std::holds_alternative<slimevr::FeatureFlags>(packet)) {
      Answer(slimevr::FeatureFlags{slimevr::kBundles | slimevr::kCompactBundles}, device.peer, out);
    } else if (const auto* p = std::get_if<slimevr::Ping>(&packet)) {
      if (device.ping != 0 && p->id == device.ping) device.answers = true;
    } else if (const auto* p = std::get_if<slimevr::UserAction>(&packet)) {
      Act(device, p->action, now_ns, out);
    } else if (const auto* p = std::get_if<slimevr::Error>(&packet)) {
      Complain(device, *p, now_ns, out);
    }
  }

  void HandleOrientation(Device& device, std::uint8_t sensor,
                         const slimevr::Orientation& orientation, std::int64_t now_ns,
                         Outbox& out) {
    const int part = device.parts[sensor];
    if (part < 0) return out.Refuse(Counter::kSourceIgnored);
    rig_.Accept(body::Joint(part), orientation, now_ns);
  }

  // If the configuration names trackers, buttons of all others are ignored.
  void Act(const Device& device, std::uint8_t action, std::int64_t now_ns, Outbox& out) {
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
    if ((has_table_ && !device.configured) || buttons_.Count(now_ns) == 0) {
      return out.Refuse(Counter::kSourceIgnored);
    }
    out.LeaveHotSection();
    const Status status = rig_.Calibrate(what, now_ns);
    if (!status.ok()) {
      out.Note([&] { return "a tracker's button asked for a reset: " + status.message(); });
    }
  }

  void Complain(Device& device, const slimevr::Error& error, std::int64_t now_ns, Outbox& out) {
    if (device.complained) return;
    device.complained = true;
    const std::uint64_t times = error_notes_.Count(now_ns);
    if (times == 0) return;
    out.Note([&] {
      return "tracker " + slimevr::ToText({device.address, error.sensor}) + " reports error " +
             std::to_string(error.code) + Times(times);
    });
  }

  TrackerRig rig_;
  std::vector<Device> devices_;
  slimevr::Datagram datagram_;
  std::int64_t next_heartbeat_ns_ = kNever;
  std::mt19937 random_;     // ids of pings, which only their receiver can know
  bool has_table_ = false;  // the configuration names trackers
  NoteLimit takeover_notes_, full_notes_;
  NoteLimit restart_notes_{kMaxDevices}, error_notes_{kMaxDevices};  // all devices at once
  NoteLimit buttons_{8};  // limits resets; an operator does not press a button more often
};

}  // namespace

std::unique_ptr<Translator> MakeSlimeVr(const config::Source& config) {
  if (config.type == rigs::kSlimeVr.usb) return MakeSlimeVrHid(config);
  return std::make_unique<SlimeVr>(config);
}

}  // namespace styled::source
