#pragma once

#include <bitset>
#include <cstdint>

#include "model/base/realtime.h"
#include "model/rig/skeleton.h"
#include "model/stylist/settings.h"

namespace styled::stylist {

// Guards the stylist against bad input, before binding: holds joints whose values are not finite or
// whose rotation has no length, and poses whose root jumps by metres. Sized once; no allocation.
class InputGuard {
 public:
  explicit InputGuard(const rig::Skeleton& skeleton);

  // Copies `in` to `source` with bad joints replaced by their last good value (the rest pose before
  // there is one), marks them in `held`, and writes the same with unit rotations to clean().
  // Rotations are bit for bit as they came where they are of length 1, but for a rig's rounding;
  // else of length 1.
  STYLED_REALTIME void HoldBadJoints(const rig::RigPose& in, rig::RigPose& source,
                                     std::bitset<256>& held) noexcept;

  enum class Jump { kNone, kHeld, kAccepted };
  // Judges the step of the root from the last accepted pose. `metres` is the length of one unit.
  // kHeld: `source` and clean() are put back to the last accepted pose. kAccepted: the jump has
  // held for options.jump_accept_frames, and is the start of something new.
  STYLED_REALTIME Jump JudgeJump(double dt_s, float metres, const Options& options,
                                 rig::RigPose& source) noexcept;

  const rig::RigPose& clean() const { return clean_; }
  STYLED_REALTIME void Reset() noexcept { has_last_ = false; }

 private:
  rig::RigPose clean_;       // this frame, unit rotations
  rig::RigPose last_;        // the last accepted source pose as received
  rig::RigPose last_clean_;  // and with unit rotations
  rig::RigPose rest_;
  rig::Vec3 candidate_ = rig::Vec3::Zero();
  int candidate_frames_ = 0;
  double since_last_s_ = 0;
  bool has_last_ = false;
};

}  // namespace styled::stylist
