#pragma once

#include <array>
#include <cstdint>

#include "daemon/decide/anticipation.h"
#include "daemon/decide/session.h"
#include "daemon/runtime/counters.h"
#include "daemon/runtime/schedule.h"
#include "model/base/checkpoint.h"
#include "model/base/realtime.h"
#include "proto/styled/v1/stats.pb.h"

namespace styled::decide {

// Decides which datagrams of a performer count. Holds their session and order, their lateness
// (schedule), the limit of body changes, the silence after which the performer is stale, and the
// refusals. One per performer, pipeline thread; only Describe allocates. Times are on the daemon's
// monotonic clock. Pinned by tests/unit/daemon/decide/admission_test.cpp.
class Admission {
 public:
  Session session;
  runtime::Schedule schedule;
  Anticipation anticipation;
  bool session_has_body = false;  // this session has sent its body
  bool sends_frames = false;      // frames of its body arrive, calibrated or not

  // Call when subsequent datagrams belong to a new session.
  STYLED_REALTIME void StartSession() noexcept {
    session_has_body = false;
    schedule = runtime::Schedule();
  }

  // See model/base/checkpoint.h. After a restore, lateness is measured from zero and the performer
  // is live again with its next frame.
  STYLED_REALTIME void Carry(Checkpoint& c, std::int64_t now_ns) noexcept {
    session.Carry(c, now_ns);
    c(session_has_body, sends_frames);
    if (!c.reads()) return;
    schedule = runtime::Schedule();
    anticipation = Anticipation();
    live_ = false;
  }

  // Whether one more change of the body is allowed now: kBodyChanges at once, then one per
  // kBodyChange_ns, because each change rebuilds everything that depends on the body.
  bool MayChangeBody(std::int64_t now_ns) noexcept;

  // Call when a frame that arrived at `now_ns` was accepted: the performer is live.
  STYLED_REALTIME void MarkLive(std::int64_t now_ns) noexcept;
  STYLED_REALTIME void MarkStale() noexcept { live_ = false; }
  bool live() const { return live_; }
  std::int64_t last_frame_ns() const { return last_frame_ns_; }  // of the last accepted frame
  std::uint64_t received() const { return received_; }           // frames accepted
  // Silence after which the performer is stale: `stale_ns`, or three periods of a slower rig, at
  // most 10 s.
  STYLED_REALTIME std::int64_t StaleAfter_ns(std::int64_t stale_ns) const noexcept;

  // Call when a datagram of this performer changed nothing and was counted as `why`.
  STYLED_REALTIME void MarkRefused(runtime::Counter why) noexcept {
    ++refused_;
    refused_as_ = why;
  }

  // Call once a second with the `frames` sent since the last call. Updates rate and refusals.
  void Sample(std::uint64_t frames) noexcept;
  void Describe(v1::PerformerStats& stats) const;

 private:
  static constexpr int kBodyChanges = 8;  // for a rig that detects its bones one by one
  static constexpr std::int64_t kBodyChange_ns = 500'000'000;

  int body_changes_left_ = kBodyChanges;
  std::int64_t body_changed_ns_ = 0;
  bool live_ = false;
  std::uint64_t received_ = 0;
  std::int64_t last_frame_ns_ = 0;
  std::array<std::int64_t, 2> intervals_ns_{};  // between the last frames
  std::int64_t since_ns_ = 0;                   // the last frame counted in the rate
  bool fresh_ = true;                           // that frame was the first after a silence
  float rate_hz_ = 0;
  std::uint64_t refused_ = 0, refused_at_sample_ = 0;
  runtime::Counter refused_as_ = runtime::Counter::kCount;
  bool refusing_ = false;  // in the last second
};

}  // namespace styled::decide
