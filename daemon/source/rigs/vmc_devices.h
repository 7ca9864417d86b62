#pragma once

#include <cstdint>
#include <span>

#include "daemon/config/config.h"
#include "daemon/source/rigs/device_rig.h"
#include "daemon/source/translator.h"

namespace styled::source {

// The VMC sender of a port that sends tracking devices and no bones: an assistant. The part of
// vmc.h's translator that turns devices into a body. Pipeline thread.
class VmcDevices {
 public:
  // A performer that sends bones sends its devices, too, in datagrams of their own. So devices
  // count only after their sender sent no bone for this long.
  static constexpr std::int64_t kProof_ns = 500'000'000;

  explicit VmcDevices(const config::Source& config) : rig_(config) {}

  // Whether the datagram, which must have passed osc::Check, has a device in it.
  static bool HasDevice(std::span<const std::byte> datagram);
  bool IsSender(std::uint64_t peer) const { return peer_ != 0 && peer == peer_; }

  // Takes a datagram of a sender without bones. A second such sender is refused while the first is
  // not silent for DeviceRig::kSilent_ns.
  void Take(std::span<const std::byte> datagram, std::uint64_t peer, std::int64_t now_ns,
            Outbox& out);
  // The sender turned out to send bones.
  void Forget(std::uint64_t peer) {
    if (IsSender(peer)) peer_ = 0;
  }

  DeviceRig& rig() { return rig_; }
  const DeviceRig& rig() const { return rig_; }

 private:
  bool IsOld(float time_s, Outbox& out);

  DeviceRig rig_;
  std::uint64_t peer_ = 0;
  std::int64_t since_ns_ = 0, heard_ns_ = 0;
  bool has_time_ = false;
  float time_s_ = 0;  // the sender's clock
};

}  // namespace styled::source
