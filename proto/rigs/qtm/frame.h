#pragma once

#include <array>
#include <cstdint>

#include "proto/rigs/qtm/packet.h"
#include "proto/rigs/qtm/timecode.h"

namespace styled::qtm {

// QTM has no limit; a stand-in's skeletons have 21 markers each.
inline constexpr std::size_t kMaxMarkers = 512;

// Components of a data packet that are read or written; others are skipped.
enum class Component : std::uint32_t { kMarkers = 1, kTimecode = 17, kSkeletons = 18 };

// A segment relative to its parent; the root in the capture volume. NaN: not tracked.
struct Segment {
  std::uint32_t id = 0;
  std::array<float, 3> position_mm{};
  std::array<float, 4> rotation{};  // x, y, z, w
};
struct SkeletonPose {
  std::size_t segment_count = 0;  // 0: QTM does not see this skeleton
  std::array<Segment, kMaxSegments> segments;
};

// Labelled markers; only the stand-in has them, for the witness.
struct Markers {
  std::size_t count = 0;
  std::array<std::array<float, 3>, kMaxMarkers> positions_mm;
};

// A data packet. The skeletons are those of the XML, in its order.
struct Frame {
  std::int64_t timestamp_us = 0;  // of the cameras, since the measurement began
  std::uint32_t number = 0;
  bool has_skeletons = false;  // without it the packet has no timecode
  std::size_t skeleton_count = 0;
  std::size_t skeletons_left_out = 0;
  std::array<SkeletonPose, kMaxSkeletons> skeletons;
  bool has_timecode = false;  // of the first source of timecodes
  Timecode timecode;
  bool has_markers = false;  // written, never read
  Markers markers;
};

// `frame` is unspecified unless kOk. Bytes after the last component are allowed.
STYLED_REALTIME DecodeResult DecodeFrame(std::span<const std::byte> payload, Frame& frame) noexcept;

// Returns the packet's size, 0 if it does not fit.
STYLED_REALTIME std::size_t EncodeFrame(const Frame& frame, std::span<std::byte> out) noexcept;

}  // namespace styled::qtm
