#include "daemon/source/rigs/vrchat.h"

#include <array>
#include <cmath>
#include <limits>

#include "daemon/source/rigs/device_rig.h"
#include "proto/rigs/vrchat/vrchat.h"

namespace styled::source {
namespace {

using devices::Seen;
using runtime::Counter;

constexpr float kNoNumber = std::numeric_limits<float>::quiet_NaN();
constexpr float kRadians = 0.017453293F;
constexpr float kMostDegrees = 1e6F;

// By index; SlimeVR's order, which other senders follow.
constexpr std::array<DeviceRig::Device, vrchat::kTrackers + 1> kNumbered{
    {{.name = "head", .usual_part = body::kHead, .at_joint = true},
     {.name = "1", .usual_part = body::kHips},
     {.name = "2", .usual_part = body::kLeftFoot},
     {.name = "3", .usual_part = body::kRightFoot},
     {.name = "4", .usual_part = body::kLeftUpperLeg},
     {.name = "5", .usual_part = body::kRightUpperLeg},
     {.name = "6", .usual_part = body::kChest},
     {.name = "7", .usual_part = body::kLeftUpperArm},
     {.name = "8", .usual_part = body::kRightUpperArm}}};
// By vrchat::System.
constexpr std::array<DeviceRig::Device, 3> kSystem{
    {{.name = "vrsystem/head", .usual_part = body::kHead, .is_head = true},
     {.name = "vrsystem/leftwrist", .usual_part = body::kLeftHand},
     {.name = "vrsystem/rightwrist", .usual_part = body::kRightHand}}};

// Mirrored in x = 0, from Unity's axes. NaN and angles without end become a rotation that the rig
// refuses.
body::Quat RotationOf(const std::array<float, 3>& euler) {
  for (const float angle : euler) {
    if (!(std::abs(angle) <= kMostDegrees)) return {0, 0, 0, 0};
  }
  const auto q = vrchat::QuaternionOf(euler);
  return {q[3], q[0], -q[1], -q[2]};
}
body::Vec3 PositionOf(const std::array<float, 3>& position) {
  // NaN would mean "not measured"; infinity is refused.
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  body::Vec3 p(-position[0], position[1], position[2]);
  if (!p.allFinite()) p.setConstant(kInfinity);
  return p;
}

class VrChat final : public Translator {
 public:
  explicit VrChat(const config::Source& config) : rig_(config) {}

  void Handle(std::span<const std::byte> datagram, const Peer& peer, std::int64_t now_ns,
              Outbox& out) override {
    if (vrchat::osc::Check(datagram) != vrchat::osc::Result::kOk) {
      return out.Refuse(Counter::kSourceMalformed);
    }
    vrchat::osc::Reader reader(datagram);
    vrchat::osc::Message bytes;
    while (reader.Next(bytes) == vrchat::osc::Reader::Step::kMessage) {
      vrchat::Message message;
      const auto result = vrchat::Decode(bytes, message);
      if (result == vrchat::DecodeResult::kUnknownAddress) {
        out.Refuse(Counter::kSourceIgnored);
      } else if (result != vrchat::DecodeResult::kOk) {
        out.Refuse(Counter::kSourceMalformed);
      } else if (const auto* tracker = std::get_if<vrchat::Tracker>(&message)) {
        HandleTracker(*tracker, peer.id, now_ns, out);
      } else if (const auto* pose = std::get_if<vrchat::SystemPose>(&message)) {
        rig_.Accept(kSystem[static_cast<std::size_t>(pose->device)],
                    {PositionOf(pose->position), RotationOf(pose->euler)}, peer.id, now_ns, out);
      }
    }
  }

  void Tick(std::int64_t now_ns, Outbox& out) override { rig_.Tick(now_ns, out); }
  std::int64_t NextDeadline_ns() const override { return rig_.NextDeadline_ns(); }
  bool has_sensors() const override { return true; }
  Status Calibrate(Calibration what, std::int64_t now_ns) override {
    return rig_.Calibrate(what, now_ns);
  }

 private:
  void HandleTracker(const vrchat::Tracker& tracker, std::uint64_t peer, std::int64_t now_ns,
                     Outbox& out) {
    const DeviceRig::Device& device = kNumbered[static_cast<std::size_t>(tracker.index)];
    const body::Quat no_rotation(kNoNumber, kNoNumber, kNoNumber, kNoNumber);
    if (!tracker.is_rotation) {
      return rig_.Accept(device, {PositionOf(tracker.values), no_rotation}, peer, now_ns, out);
    }
    if (tracker.index != vrchat::kHead) {
      return rig_.Accept(device, {body::Vec3::Constant(kNoNumber), RotationOf(tracker.values)},
                         peer, now_ns, out);
    }
    const float yaw = tracker.values[1];
    if (!(std::abs(yaw) <= kMostDegrees)) return out.Refuse(Counter::kSourceMalformed);
    rig_.NoteHeading(-kRadians * yaw, peer, now_ns, out);
  }

  DeviceRig rig_;
};

}  // namespace

std::unique_ptr<Translator> MakeVrChat(const config::Source& config) {
  return std::make_unique<VrChat>(config);
}

}  // namespace styled::source
