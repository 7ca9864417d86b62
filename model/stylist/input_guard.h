#pragma once

#include <bitset>

#include "model/base/checkpoint.h"
#include "model/base/realtime.h"
#include "model/rig/skeleton.h"
#include "model/stylist/settings.h"

namespace styled::stylist {

// Protects the stylist from bad input, before binding. Holds joints whose values are not finite or
// whose rotation has no length, and holds the whole pose when its root jumps by metres. Memory is
// sized at construction; no allocation afterwards. One thread at a time. Pinned by
// tests/unit/stylist/input_guard_test.cpp.
class InputGuard {
 public:
  explicit InputGuard(const rig::Skeleton& skeleton);

  // Copies `in` to `source` with bad joints replaced by their last good value (the rest pose if
  // there is none yet), marks them in `held`, and writes the same with unit rotations to clean().
  // In `source`, rotations whose length is 1 within a rig's rounding stay bit for bit as received;
  // others are normalized.
  STYLED_REALTIME void HoldBadJoints(const rig::RigPose& in, rig::RigPose& source,
                                     std::bitset<256>& held) noexcept;

  enum class Jump { kNone, kHeld, kAccepted };
  // Checks the root's step from the last accepted pose. `metres`: the length of one source unit.
  // kHeld: `source` and clean() are reset to the last accepted pose. kAccepted: the new place has
  // been stable for options.jump_accept_frames frames, and a new session begins there.
  STYLED_REALTIME Jump JudgeJump(double dt_s, float metres, const Options& options,
                                 rig::RigPose& source) noexcept;

  const rig::RigPose& clean() const { return clean_; }
  STYLED_REALTIME void Reset() noexcept { has_last_ = false; }
  // See model/base/checkpoint.h.
  STYLED_REALTIME void Carry(Checkpoint& c) noexcept;

 private:
  // Of candidate_frames_, which are accepted after Options::jump_accept_frames, at most 1000.
  static constexpr int kMostFrames = 1000;

  rig::RigPose clean_;       // this frame, unit rotations
  rig::RigPose last_;        // the last accepted source pose as received
  rig::RigPose last_clean_;  // the same with unit rotations
  rig::RigPose rest_;
  rig::Vec3 candidate_ = rig::Vec3::Zero();
  int candidate_frames_ = 0;
  double since_last_s_ = 0;
  bool has_last_ = false;
};

}  // namespace styled::stylist
