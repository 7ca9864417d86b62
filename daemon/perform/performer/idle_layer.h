#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <string_view>
#include <vector>

#include "model/base/checkpoint.h"
#include "model/base/realtime.h"
#include "model/idle/idle.h"
#include "model/rig/binding.h"
#include "model/rig/mirror.h"

namespace styled::pipeline {

// Lets a performer's body breathe, sway and blink by itself (v1::Look.idle): on top of the rig's
// motion, and on the rig's last pose while the rig is silent. When the rig returns, the body moves
// from where it was shown to the rig's pose in kReturn_s. It is a part of the input, so the style
// applies to it. One per body, pipeline thread; only the constructor allocates. Pinned by
// tests/unit/daemon/pipeline/idle_test.cpp.
class IdleLayer {
 public:
  static constexpr float kReturn_s = 0.5F;

  // `id`: the performer's, which decides their own motion.
  IdleLayer(std::shared_ptr<const rig::Binding> binding, std::string_view id);

  // A frame of the rig at a time of the session: `pose` is of the binding's skeleton, in its axes.
  // Bit for bit unchanged while `amount` is 0 and no earlier motion fades. Joints that are not
  // finite stay so.
  STYLED_REALTIME void Apply(std::int64_t elapsed_ns, float amount, rig::RigPose& pose) noexcept;
  // The rig is silent: writes its last pose with the motion of `elapsed_ns`. Returns false if there
  // is none.
  STYLED_REALTIME bool ApplySilent(std::int64_t elapsed_ns, float amount,
                                   rig::RigPose& pose) noexcept;
  // Whether a frame of the rig has come, in this process or before a checkpoint.
  bool has_pose() const noexcept { return has_last_; }
  // The poses that are kept change to their mirror images, with the rig's next one.
  STYLED_REALTIME void Mirror(const rig::MirrorMap& map) noexcept;
  // The face of a silent performer: the share of its last expressions that is left, and how far the
  // lids are closed, 0 .. 1.
  STYLED_REALTIME float FaceKept() const noexcept { return 1 - std::min(amounts_.head, 1.0F); }
  STYLED_REALTIME float EyesClosed() const noexcept { return idle_.Blink(time_s_); }

  // See model/base/checkpoint.h.
  STYLED_REALTIME void Carry(Checkpoint& c) noexcept;

 private:
  STYLED_REALTIME void Advance(std::int64_t elapsed_ns, float amount, bool silent) noexcept;
  STYLED_REALTIME void KeepFinite(const rig::RigPose& pose) noexcept;
  STYLED_REALTIME void Show() noexcept;

  std::shared_ptr<const rig::Binding> binding_;
  idle::Idle idle_;
  double time_s_ = 0;  // of the motion; stands still where the session's time jumps
  std::int64_t elapsed_ns_ = 0;
  float step_s_ = 0;
  idle::Idle::Amounts amounts_{0, 0};
  bool has_last_ = false, silent_ = false;
  float returning_ = 0;           // 1 .. 0: the share of left_ in what is shown
  rig::RigPose last_;             // the rig's, without the motion
  rig::RigPose left_;             // shown when the rig returned
  rig::RigPose shown_, scratch_;  // shown now
};

}  // namespace styled::pipeline
