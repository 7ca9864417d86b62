#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/source/face.h"
#include "daemon/source/outbox.h"
#include "daemon/source/props.h"
#include "daemon/source/source_frame.h"
#include "model/rig/skeleton.h"
#include "proto/styled/face.h"

namespace styled::source {

// Turns the poses of one performer of a rig's sender into SourceFrames: adds session and sequence
// numbers, and sends the body before the first frame and again once a second
// (proto/styled/v1/WIRE.md). Created when a performer is first seen; pipeline thread. Neither Send
// nor Restart allocates once the body is set. Pinned by
// tests/unit/daemon/source/performer_stream_test.cpp.
class PerformerStream {
 public:
  // `performer`: a valid name (MakeName).
  explicit PerformerStream(std::string performer);

  // The sender restarted: subsequent frames belong to a new session with the same body.
  STYLED_REALTIME void Restart() noexcept;
  // Sets the body of the subsequent poses; it is sent with the next frame. A body that differs from
  // the last one is a change within the session. Allocates when the body differs.
  void SetBody(const rig::RigBody& body, Outbox& out);
  // Reserves room for the faces of frames. Allocates.
  void ReserveFace() { face_.resize(kMaxFace); }
  bool has_body() const { return message_ != nullptr; }
  const rig::RigBody& body() const { return body_; }

  struct FrameInfo {
    std::uint64_t source_time_ns = 0;    // the rig's clock; any epoch
    std::int64_t now_ns = 0;             // time of arrival, monotonic
    std::uint64_t lost = 0;              // frames lost before this one, by the rig's own count
    const Timecode* timecode = nullptr;  // null: the same as in the last frame
    const Face* face = nullptr;          // null, or larger than the reserved room: the frame has no
                                         // face
    std::span<const Prop> props = {};    // those that fit into kMaxPropBytes are encoded
    bool scene_props = false;            // as in SourceFrame
  };
  // Sends a pose of the body: local rotations, NaN for a joint that is not tracked. `pose` must
  // have the body's joint count. Does nothing before a body is set.
  STYLED_REALTIME void Send(const rig::RigPose& pose, const FrameInfo& info, Outbox& out) noexcept;

  // Sends the body alone, as one that the pipeline has to refuse for this reason
  // (SourceFrame::refusal), at most twice a second, so that the performer is listed as refused for
  // as long as its sender sends. Does nothing before a body is set.
  STYLED_REALTIME void SendRefused(const std::shared_ptr<const std::string>& why,
                                   std::int64_t now_ns, Outbox& out) noexcept;

  const std::string& performer() const { return performer_; }

 private:
  // A frame with session, next sequence number and the body's CRC filled in.
  STYLED_REALTIME SourceFrame Next() noexcept;

  std::string performer_;
  rig::RigBody body_;
  std::shared_ptr<const v1::Body> message_;  // body_; null: none yet
  std::uint32_t body_crc_ = 0;
  std::uint64_t session_, sequence_ = 0;
  std::int64_t next_body_ns_ = 0;
  Timecode timecode_;
  bool has_timecode_ = false;
  std::vector<std::byte> face_;
  std::array<std::byte, kMaxPropBytes> props_;
};

// Makes a performer's name from the rig's name for it: every character other than A-Za-z0-9_-
// becomes '_', and the text is cut to 32. An empty text gives "performer".
std::string MakeName(std::string_view text);

}  // namespace styled::source
