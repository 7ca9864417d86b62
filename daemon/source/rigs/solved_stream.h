#pragma once

#include <cstdint>

#include "daemon/config/config.h"
#include "daemon/source/performer_stream.h"
#include "daemon/source/translator.h"
#include "model/body/pose.h"

namespace styled::source {

// Sends the poses of a body solver (model/rig/trackers.h, model/devices) at config.rate_hz, as body
// "canonical" in metres: trackers have no common clock, so the frames have the daemon's. Silent
// while the solver has no pose. Pipeline thread; does not allocate once the first frame was sent.
// Pinned by tests/unit/slimevr/tracker_rig_test.cpp.
class SolvedStream {
 public:
  explicit SolvedStream(const config::Source& config);

  // A tracker sent data: frames begin, unless they already have.
  STYLED_REALTIME void Wake(std::int64_t now_ns) noexcept {
    if (next_frame_ns_ == Translator::kNever) next_frame_ns_ = now_ns;
  }
  // Sends the frames that are due. `solve(time_ns, body::Pose&)` writes the pose of `time_ns`, or
  // returns false; a frame's source time is `delay_ns` earlier. Frames due more than 100 ms ago are
  // left out and counted as lost.
  template <typename Solve>
  void Tick(std::int64_t now_ns, std::int64_t delay_ns, Outbox& out, const Solve& solve) {
    if (next_frame_ns_ > now_ns) return;
    std::uint64_t lost = SkipOld(now_ns);
    while (next_frame_ns_ <= now_ns) {
      if (!solve(next_frame_ns_, solved_)) {
        next_frame_ns_ = Translator::kNever;  // until a tracker sends data again
        return;
      }
      SendFrame(next_frame_ns_ - delay_ns, now_ns, lost, out);
      lost = 0;
      next_frame_ns_ += period_ns_;
    }
  }
  std::int64_t NextDeadline_ns() const { return next_frame_ns_; }

  // The poses jump: a new session, of a performer of `scale` times the canonical humanoid's size.
  // Poses of the solver have the canonical humanoid's lengths. Allocates with the next frame.
  void Restart(float scale = 1);

 private:
  std::uint64_t SkipOld(std::int64_t now_ns) noexcept;
  void SendFrame(std::int64_t time_ns, std::int64_t now_ns, std::uint64_t lost, Outbox& out);

  PerformerStream stream_;
  float scale_ = 1;
  bool has_body_ = false;
  rig::RigPose pose_;
  body::Pose solved_;
  std::int64_t period_ns_;
  std::int64_t next_frame_ns_ = Translator::kNever;
};

}  // namespace styled::source
