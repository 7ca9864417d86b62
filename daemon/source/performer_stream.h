#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/source/native_decoder.h"
#include "daemon/source/outbox.h"
#include "model/rig/skeleton.h"
#include "proto/styled/v1/frame.pb.h"

namespace styled::source {

// What a rig tells beside the pose: names and weights, and messages to be passed on.
struct Face {
  struct Expression {
    std::string_view name;
    float value = 0;
  };
  std::vector<Expression> expressions;
  std::vector<std::span<const std::byte>> thru;
};

// One performer of a rig's sender, put into our own datagrams (proto/styled/v1/WIRE.md): sessions,
// sequence numbers, the body again once a second. Made when a performer is first seen; pipeline
// thread. Neither Send nor Restart allocates once the body is set, but for a larger face than was
// reserved.
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
  // Room for a face of so many expressions and messages, and for their texts. Allocates.
  void ReserveFace(std::size_t expressions, std::size_t name_bytes, std::size_t thrus,
                   std::size_t thru_bytes);
  bool has_body() const { return !body_bytes_.empty(); }
  const rig::RigBody& body() const { return body_; }

  struct FrameInfo {
    std::uint64_t source_time_ns = 0;  // the rig's clock; any epoch
    std::int64_t now_ns = 0;           // arrival
    std::uint64_t lost = 0;            // frames that the rig's own count says were lost before
    const Timecode* timecode = nullptr;
    const Face* face = nullptr;
  };
  // A pose of the body (local rotations; NaN in a joint: not tracked). Nothing before a body is
  // set. `pose` has the body's joint count.
  STYLED_REALTIME void Send(const rig::RigPose& pose, const FrameInfo& info, Outbox& out) noexcept;

  const std::string& performer() const { return performer_; }

 private:
  void SetFace(const Face* face);
  STYLED_REALTIME void SendBody(std::int64_t now_ns, Outbox& out) noexcept;

  std::string performer_;
  rig::RigBody body_;
  std::string body_bytes_;  // serialized
  std::uint32_t body_crc_ = 0;
  v1::SourceFrame frame_;  // keeps its memory
  std::uint64_t session_, sequence_ = 0;
  std::int64_t next_body_ns_ = 0;
};

// A performer's name of what a rig calls him: every other character than A-Za-z0-9_- becomes '_',
// cut to 32; "performer" where nothing is left.
std::string MakeName(std::string_view text);

}  // namespace styled::source
