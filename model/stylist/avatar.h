#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "model/base/checkpoint.h"
#include "model/base/critically_damped.h"
#include "model/base/realtime.h"
#include "model/feet/feet.h"
#include "model/rig/binding.h"
#include "model/rig/tail.h"
#include "model/stylist/stylist.h"

namespace styled::stylist {

// Steps 5 and 6 of the stylist for an additional skeleton: that of an avatar, whose proportions
// differ from the performer's. Rotations are transferred joint by joint; the path over the floor is
// scaled by the hips' height. Then the feet are corrected: the avatar's lowest foot is as high as
// the performer's, and while a performer's foot is planted the avatar's stands still, with or
// without a style. Fingers, eyes and jaw that both have follow the performer's. Memory is sized at
// construction; Process does not allocate. One thread at a time. Pinned by
// tests/unit/stylist/avatar_test.cpp.
class Avatar {
 public:
  // `performer`: the binding of the stylist whose outputs are processed. `rest`: a pose of the
  // avatar's skeleton with unit rotations, used for joints without a source. `tail`: the avatar's
  // fingers, eyes and jaw; the performer's are found by their names.
  Avatar(std::shared_ptr<const rig::Binding> performer, std::shared_ptr<const rig::Binding> avatar,
         const rig::RigPose& rest, const Options& options,
         const rig::TailMap& tail = rig::NoTail());

  // Processes one frame, after the stylist's Process; `styled.rig` must be in the binding's axes.
  // `time_ns` must increase from call to call; frames may be skipped. Returns false if the result
  // would not be a sound pose (model/stylist/guard.h): pose() is then the performer's own motion,
  // and contacts and locks are reset.
  STYLED_REALTIME bool Process(std::int64_t time_ns, const Output& styled) noexcept;
  // The avatar's pose in its own units and axes; rotations are continuous in sign over time.
  const rig::RigPose& pose() const { return pose_; }
  // Clears contacts and locks: the next frame counts as the first.
  STYLED_REALTIME void Reset() noexcept;
  // See model/base/checkpoint.h; between avatars of the same two skeletons and options.
  STYLED_REALTIME void Carry(Checkpoint& c) noexcept {
    c(feet_, shift_m_, tail_, last_, pose_);
    c.Time(last_ns_);
    c(started_);
  }

 private:
  // The pose without fingers, eyes and jaw.
  STYLED_REALTIME bool ProcessBody(std::int64_t time_ns, const Output& styled) noexcept;

  std::shared_ptr<const rig::Binding> performer_, avatar_;
  bool ground_, hold_;
  float ground_tau_s_;
  feet::Feet feet_;
  CriticallyDamped shift_m_;
  rig::Tail performer_tail_, avatar_tail_;  // the joints that both have
  std::vector<rig::Quat> tail_;             // the last frame's
  rig::RigPose performed_;                  // the performer's own pose, unit rotations
  rig::RigPose last_, pose_;
  std::int64_t last_ns_ = 0;
  bool started_ = false;
};

}  // namespace styled::stylist
