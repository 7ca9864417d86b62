#pragma once

#include <cstddef>
#include <span>

#include "proto/rigs/vmc/device.h"
#include "proto/rigs/vmc/vmc.h"

namespace styled::vmc {

// The content of one frame to send. The caller owns what the views point to.
struct Packed {
  Root root;
  std::span<const Bone> bones;  // names of HumanBodyBones
  std::span<const Blend> blends;
  std::span<const Thru> thrus;
  std::span<const Device> devices;
  Available available;
  float time_s = 0;
};

// Splits one frame into datagrams that every known receiver accepts: the root and bones first, at
// most 13 of them per datagram; last, together in one datagram, Blend/Apply, OK and T (EVMC4U
// counts frames by a T that comes last; VMCLiveLink publishes at Blend/Apply). Each datagram is one
// bundle. No allocation; one thread.
//
//   for (Packer packer(frame); const auto size = packer.Next(buffer);) send(buffer, size);
class Packer {
 public:
  static constexpr std::size_t kMaxPacketSize = 1400;  // below an Ethernet frame's 1472
  static constexpr std::size_t kMaxBonesPerPacket = 13;

  explicit Packer(const Packed& frame) noexcept : frame_(frame) {}

  // Writes the next datagram to the front of `out`, which must hold kMaxPacketSize bytes, and
  // returns its size; 0 when there are no more. Blends, Thrus and Devices too large for a
  // datagram are left out.
  STYLED_REALTIME std::size_t Next(std::span<std::byte> out) noexcept;

 private:
  std::size_t NextBones(std::span<std::byte> out) noexcept;
  std::size_t NextRest(std::span<std::byte> out) noexcept;

  Packed frame_;
  bool root_sent_ = false, finished_ = false;
};

}  // namespace styled::vmc
