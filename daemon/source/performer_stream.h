#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/source/face.h"
#include "daemon/source/outbox.h"
#include "daemon/source/source_frame.h"
#include "model/rig/skeleton.h"
#include "proto/styled/face.h"

namespace styled::source {

// One performer of a rig's sender as the pipeline wants it: session, sequence numbers, and the body
// before the first frame and again once a second (proto/styled/v1/WIRE.md). Made when a performer
// is first seen; pipeline thread. Neither Send nor Restart allocates once the body is set.
// Pinned by tests/unit/daemon/performer_stream_test.cpp.
class PerformerStream {
 public:
  // `performer`: a valid name (MakeName).
  explicit PerformerStream(std::string performer);

  // The sender began anew: what follows is another session, of the same body.
  STYLED_REALTIME void Restart() noexcept;
  // What the poses belong to; sent with the next frame. Another body than the last is a change
  // within the session. Allocates.
  void SetBody(const rig::RigBody& body, Outbox& out);
  // Room for the faces of frames. Allocates.
  void ReserveFace() { face_.resize(kMaxFace); }
  bool has_body() const { return message_ != nullptr; }
  const rig::RigBody& body() const { return body_; }

  struct FrameInfo {
    std::uint64_t source_time_ns = 0;    // the rig's clock; any epoch
    std::int64_t now_ns = 0;             // arrival
    std::uint64_t lost = 0;              // frames that the rig's own count says were lost before
    const Timecode* timecode = nullptr;  // null: as in the last frame
    const Face* face = nullptr;          // null, or larger than the room reserved: none
  };
  // A pose of the body (local rotations; NaN in a joint: not tracked). Nothing before a body is
  // set. `pose` has the body's joint count.
  STYLED_REALTIME void Send(const rig::RigPose& pose, const FrameInfo& info, Outbox& out) noexcept;

  const std::string& performer() const { return performer_; }

 private:
  // Session, the next sequence number, and the body's CRC.
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
};

// A performer's name made of what a rig calls it: every character other than A-Za-z0-9_- becomes
// '_', cut to 32; "performer" where nothing is left.
std::string MakeName(std::string_view text);

}  // namespace styled::source
