#pragma once

#include <cstddef>
#include <span>

#include "proto/rigs/vmc/vmc.h"

namespace styled::vmc {

// What to send of one instant. Views are the caller's.
struct Packed {
  Root root;
  std::span<const Bone> bones;  // names of HumanBodyBones
  std::span<const Blend> blends;
  std::span<const Thru> thrus;
  Available available;
  float time_s = 0;
};

// Cuts one frame into datagrams that every known receiver takes: the root and bones first, at most
// 13 of them to a datagram, and last, in one datagram, Blend/Apply, OK and T (EVMC4U counts frames
// by a T that comes last; VMCLiveLink publishes at Blend/Apply). Each datagram is one bundle. No
// allocation; one thread.
//
//   for (Packer packer(frame); const auto size = packer.Next(buffer);) send(buffer, size);
class Packer {
 public:
  static constexpr std::size_t kMaxPacketSize = 1400;  // below an Ethernet frame's 1472
  static constexpr std::size_t kMaxBonesPerPacket = 13;

  explicit Packer(const Packed& frame) noexcept : frame_(frame) {}

  // Writes the next datagram to the front of `out`, kMaxPacketSize bytes or more, and returns its
  // size; 0 when there is no more. Blends and Thrus that no packet could hold are left out.
  STYLED_REALTIME std::size_t Next(std::span<std::byte> out) noexcept;

 private:
  std::size_t NextBones(std::span<std::byte> out) noexcept;
  std::size_t NextRest(std::span<std::byte> out) noexcept;

  Packed frame_;
  bool root_sent_ = false, finished_ = false;
};

}  // namespace styled::vmc
