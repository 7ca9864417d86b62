#include "daemon/source/rigs/vmc_devices.h"

#include <cmath>
#include <limits>

#include "proto/rigs/vmc/device.h"

namespace styled::source {
namespace {

using runtime::Counter;

// A clock that goes back by more than this belongs to a sender that restarted; by less, to an old
// datagram.
constexpr float kDevicesRestart_s = 1;

// Calls `use(message)` for each message of the datagram.
template <typename Use>
void ForEach(std::span<const std::byte> datagram, const Use& use) {
  vmc::osc::Reader reader(datagram);
  vmc::osc::Message message;
  while (reader.Next(message) == vmc::osc::Reader::Step::kMessage) use(message);
}

// From Unity's axes, mirrored in x = 0. These devices measure both: a NaN, which would mean "not
// measured", becomes infinity, which the rig refuses.
DeviceRig::Measured FromUnity(const vmc::Transform& transform) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  const auto& p = transform.position;
  const auto& q = transform.rotation;
  DeviceRig::Measured measured{{-p[0], p[1], p[2]}, {q[3], q[0], -q[1], -q[2]}};
  if (!measured.position_m.allFinite()) measured.position_m.setConstant(kInfinity);
  if (!measured.rotation.coeffs().allFinite()) measured.rotation.coeffs().setConstant(kInfinity);
  return measured;
}

}  // namespace

bool VmcDevices::HasDevice(std::span<const std::byte> datagram) {
  bool has = false;
  ForEach(datagram, [&has](const vmc::osc::Message& message) {
    vmc::Device device;
    has = has || Decode(message, device) == vmc::DecodeResult::kOk;
  });
  return has;
}

// Counts an old datagram, and detects a restart of the sender.
bool VmcDevices::IsOld(float time_s, Outbox& out) {
  if (!std::isfinite(time_s)) return false;
  const bool fell = has_time_ && time_s < time_s_;
  if (fell && time_s_ - time_s <= kDevicesRestart_s) {
    out.Refuse(Counter::kPipelineReordered);
    return true;
  }
  if (fell) rig_.Restart();
  has_time_ = true;
  time_s_ = time_s;
  return false;
}

void VmcDevices::Handle(std::span<const std::byte> datagram, std::uint64_t peer,
                        std::int64_t now_ns, Outbox& out) {
  if (vmc::osc::Check(datagram) != vmc::osc::Result::kOk) {
    return out.Refuse(Counter::kSourceMalformed);
  }
  if (!IsSender(peer)) {
    if (peer_ != 0 && now_ns - heard_ns_ <= DeviceRig::kSilent_ns) {
      return out.Refuse(Counter::kPipelineSecondSender);
    }
    peer_ = peer;
    since_ns_ = now_ns;
    has_time_ = false;
  }
  heard_ns_ = now_ns;
  bool old = false;
  ForEach(datagram, [&](const vmc::osc::Message& bytes) {
    vmc::Message message;
    if (bytes.address != vmc::kTimeAddress) return;
    if (Decode(bytes, message) != vmc::DecodeResult::kOk) return;
    old = old || IsOld(std::get<vmc::Time>(message).seconds, out);
  });
  if (old) return;
  const bool proven = now_ns - since_ns_ >= kProof_ns;
  ForEach(datagram, [&](const vmc::osc::Message& bytes) {
    if (bytes.address == vmc::kTimeAddress) return;
    vmc::Device device;
    const vmc::DecodeResult result = Decode(bytes, device);
    if (result == vmc::DecodeResult::kUnknownAddress) return out.Refuse(Counter::kSourceIgnored);
    if (result != vmc::DecodeResult::kOk) return out.Refuse(Counter::kSourceMalformed);
    if (!proven) return;
    const bool is_head = device.kind == vmc::Device::Kind::kHmd;
    rig_.Accept({.name = device.serial,
                 .usual_part = is_head ? int{body::kHead} : devices::Seen::kUnknown,
                 .is_head = is_head},
                FromUnity(device.transform), peer, now_ns, out);
  });
}

}  // namespace styled::source
