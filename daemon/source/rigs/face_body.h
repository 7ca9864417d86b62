#pragma once

#include <cstdint>
#include <span>

#include "daemon/config/config.h"
#include "daemon/source/face_stream.h"
#include "daemon/source/outbox.h"
#include "daemon/source/performer_stream.h"
#include "daemon/source/transport.h"
#include "model/base/realtime.h"
#include "model/base/status.h"
#include "model/rig/skeleton.h"
#include "proto/arkit/shapes.h"

namespace styled::source {

// The performer of a phone and nothing else (config::Source::FaceAlone): the canonical
// humanoid with eyes, standing or seated, in metres. Neck and head share the head's rotation, so
// that the head's in the world is the phone's; the eyes follow ARKit's shapes of the gaze.
// Everything else stands still here: the performer's idle motion (v1::Look.idle, initially 1) moves
// it. Pipeline thread; does not allocate once the first frame was sent. Pinned by
// tests/unit/livelinkface/face_body_test.cpp.
class FaceBody {
 public:
  explicit FaceBody(const config::Source& config);

  // Subsequent frames belong to a new session.
  STYLED_REALTIME void Restart() noexcept { stream_.Restart(); }

  struct Frame {
    // The head's rotation from looking straight at the phone: rad, to the performer's left, down,
    // and towards the right shoulder, applied in the order yaw, pitch, roll. One that is not finite
    // leaves the head as it is.
    float yaw_rad = 0, pitch_rad = 0, roll_rad = 0;
    std::uint64_t source_time_ns = 0, lost = 0;  // as in PerformerStream::FrameInfo
    std::int64_t now_ns = 0;
  };
  // `shapes`: the weights that `face` was made from.
  void Send(const Frame& frame, std::span<const float, arkit::kShapes> shapes, const Face& face,
            Outbox& out);

  // kFull: the head looks straight ahead now, wherever the phone stands; kYaw: to the sides only.
  Status Calibrate(Calibration what);

 private:
  PerformerStream stream_;
  rig::RigBody body_;
  rig::RigPose pose_;
  rig::Quat head_ = rig::Quat::Identity();      // as the phone sees it
  rig::Quat straight_ = rig::Quat::Identity();  // head_ at the last calibration
};

}  // namespace styled::source
