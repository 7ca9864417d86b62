#pragma once

#include <cstdint>
#include <span>

#include "daemon/config/config.h"
#include "daemon/source/rigs/device_rig.h"
#include "daemon/source/translator.h"

namespace styled::source {

// The part of vmc.h's translator that turns tracking devices into a body, for a VMC sender that
// sends devices and no bones (an assistant). Pipeline thread.
class VmcDevices {
 public:
  // A performer that sends bones also sends its devices, in datagrams of their own. Devices
  // therefore count only after their sender sent no bone for this long.
  static constexpr std::int64_t kProof_ns = 500'000'000;

  explicit VmcDevices(const config::Source& config) : rig_(config) {}

  // Whether the datagram, which must have passed osc::Check, has a device in it.
  static bool HasDevice(std::span<const std::byte> datagram);
  bool IsSender(std::uint64_t peer) const { return peer_ != 0 && peer == peer_; }

  // Accepts a datagram of a sender without bones. A second such sender is refused until the first
  // has been silent for DeviceRig::kSilent_ns.
  void Handle(std::span<const std::byte> datagram, std::uint64_t peer, std::int64_t now_ns,
              Outbox& out);
  // The sender sent bones, so it is not an assistant.
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
