#pragma once

#include <array>
#include <cstdint>

#include "proto/rigs/natnet/model.h"
#include "proto/rigs/natnet/packet.h"

namespace styled::natnet {

// A bone in a frame. Its pose is relative to the volume's origin or to its parent, depending on the
// server's settings; the stream does not state which.
struct Bone {
  std::int32_t id = 0;  // skeleton's id in the upper 16 bits, description's id in the lower
  std::array<float, 3> position_m{};
  std::array<float, 4> rotation{0, 0, 0, 1};  // x, y, z, w; as sent, of any length
  bool tracked = true;

  constexpr std::int32_t description_id() const { return id & 0xFFFF; }
};
struct Skeleton {
  std::int32_t id = 0;
  std::size_t bone_count = 0;
  std::array<Bone, kMaxBones> bones;
};

// FRAMEOFDATA. Markers, assets, force plates and devices are checked and skipped.
struct Frame {
  std::int32_t number = 0;
  // Rigid bodies: in the packet, and those that were read, relative to the volume's origin. Of
  // bitstreams after 4.2 none is read.
  std::size_t rigid_body_count = 0;
  std::size_t rigid_bodies_read = 0;
  std::array<Bone, kMaxRigidBodies> rigid_bodies;
  std::size_t skeleton_count = 0;
  std::size_t skeletons_left_out = 0;
  std::array<Skeleton, kMaxSkeletons> skeletons;
  // SMPTE: hours, minutes, seconds, frames from the highest byte down; 0 without a generator.
  std::uint32_t timecode = 0, timecode_subframe = 0;
  double timestamp_s = 0;  // of the camera's frame, since the server's start
  // Server ticks (ServerInfo::Connection::clock_hz); from 3.0 on, 0 if the server does not know.
  std::uint64_t exposure_ticks = 0, received_ticks = 0, transmit_ticks = 0;
  std::uint16_t params = 0;
};
// Bits of Frame::params.
inline constexpr std::uint16_t kRecording = 1;
inline constexpr std::uint16_t kModelsChanged = 2;
inline constexpr std::uint16_t kEditing = 4;  // played back, not live
inline constexpr std::uint16_t kBitstreamChanged = 8;

// `frame` is unspecified unless kOk. Up to 4.0 the frame must end where the payload does. From 4.1
// on its sections are checked by their sizes, and more bytes may follow.
STYLED_REALTIME DecodeResult DecodeFrame(std::span<const std::byte> payload, Version version,
                                         Frame& frame) noexcept;

// Encodes the frame with its skeletons and rigid_bodies_read bodies; all other sections are empty.
// Returns 0 if it does not fit.
STYLED_REALTIME std::size_t EncodeFrame(const Frame& frame, Version version,
                                        std::span<std::byte> out) noexcept;

}  // namespace styled::natnet
