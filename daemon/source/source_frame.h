#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "daemon/source/machine.h"
#include "model/base/realtime.h"
#include "model/rig/skeleton.h"
#include "proto/styled/timecode.h"
#include "proto/styled/v1/body.pb.h"

namespace styled::source {

// One frame or one body of one performer: what every source passes to the pipeline
// (Receiver::OnFrames). A rig's translator fills it in directly; the native protocol is decoded
// into it (native_decoder.h). It owns nothing but `body` and `refusal`. Its views are valid during
// the call only; frame_memory.h copies a frame that must live longer.
struct SourceFrame {
  // For both kinds. `machine` all zeros: the source distinguishes its senders itself.
  bool is_body = false;
  std::string_view performer;  // a valid name: config::IsName
  Machine machine{};
  std::uint64_t session = 0, sequence = 0;
  // CRC-32C of the serialized Body: of this body, or of the body that a frame's pose belongs to (0:
  // not stated; the session's last body is meant).
  std::uint32_t body_crc = 0;
  // The arrival time of the datagram that completes it, on the clock of runtime::Clock::Now_ns():
  // for UDP and accepted TCP connections the kernel's time, otherwise the time of reading. 0: the
  // time at which it is passed on. Only latencies depend on it.
  std::int64_t arrival_ns = 0;

  // For a frame. The pose consists of floats in this machine's byte order, aligned or not: root
  // position x, y, z in the rig's unit, and x, y, z, w of each joint's local rotation (parent from
  // joint), in the body's order. A joint that is not tracked is NaN. The pipeline checks the
  // counts.
  std::uint64_t source_time_ns = 0;  // the rig's clock, any epoch
  bool has_timecode = false;
  Timecode timecode;
  std::span<const std::byte> root_position, rotations;
  // Expressions and passed-on messages: fields 18 and 19 of v1::SourceFrame including their tags,
  // which are the same in v1::Frame. At most kMaxFace bytes (proto/styled/face.h).
  std::span<const std::byte> face;
  // Objects that the rig tracks: field 20 of v1::SourceFrame including its tags, unchecked
  // (ReadProps of props.h). At most kMaxPropBytes. `scene_props`: they belong to all performers of
  // the source, not to this one alone.
  std::span<const std::byte> props;
  bool scene_props = false;

  // For a body: the object that a translator made; without a translator, the serialized message as
  // it arrived. The latter is parsed only after the body is admitted, so that a refused sender
  // costs no allocation.
  std::shared_ptr<const v1::Body> body;
  std::span<const std::byte> body_bytes;
  // For a body of which the translator has found that no performer can be made: what the sender
  // sends, what is missing, and what to do, in one sentence. The performer is listed as refused for
  // this reason, and the body is not bound. Null: the pipeline judges the body.
  std::shared_ptr<const std::string> refusal;
};

// Copies the pose's floats, bit for bit, into a pose of `joint_count` joints. Returns false and
// leaves `pose` untouched when the frame has another joint count.
STYLED_REALTIME bool CopyPose(const SourceFrame& frame, int joint_count,
                              rig::RigPose& pose) noexcept;

// The body of a SourceFrame whose is_body is set; false where its bytes are not a v1::Body.
// Allocates.
bool ReadBody(const SourceFrame& frame, v1::Body& body);

}  // namespace styled::source
