#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "model/base/realtime.h"
#include "model/rig/skeleton.h"
#include "proto/styled/face.h"
#include "proto/styled/timecode.h"

namespace styled::source {

// A `SourceFrame` as it lies in its datagram: views into the bytes that were read, valid as long as
// they are.
struct SourceFrameView {
  std::string_view performer;
  std::uint64_t source_time_ns = 0;
  bool has_timecode = false;
  Timecode timecode;
  std::uint32_t body_crc = 0;
  std::span<const std::byte> root_position;  // floats, little-endian
  std::span<const std::byte> rotations;
  std::span<const std::byte>
      face;  // expressions and thru, tags and all; they mean the same in Frame
};

enum class [[nodiscard]] FrameResult : std::uint8_t {
  kOk,
  kMalformed,  // no valid protobuf, or a field of another type
  kBadName,    // performer is not [A-Za-z0-9_-]{1,32}
};

// Reads a serialized SourceFrame without protobuf's objects: those give back a frame's timecode,
// and grow with a hostile frame, on the heap. Floats must be packed (proto3's default; one run per
// field), expressions and thru in one run (the last one counts); unknown fields are skipped, the
// last of repeated scalars wins. `view` is unspecified unless kOk. Pure; any thread. Pinned against
// protobuf by tests/unit/daemon/native_decoder_test.cpp.
STYLED_REALTIME FrameResult ReadSourceFrame(std::span<const std::byte> payload,
                                            SourceFrameView& view) noexcept;

// Only the performer's name of a serialized SourceFrame or Body (field 1 of both); empty when there
// is none or the bytes are malformed before it.
STYLED_REALTIME std::string_view ReadPerformer(std::span<const std::byte> payload) noexcept;

// As protobuf wants strings to be.
STYLED_REALTIME bool IsUtf8(std::string_view text) noexcept;

// Copies the view's floats, bit for bit, into a pose of `joint_count` joints. False, and `pose`
// untouched, when the frame has another joint count.
STYLED_REALTIME bool CopyPose(const SourceFrameView& view, int joint_count,
                              rig::RigPose& pose) noexcept;

}  // namespace styled::source
