#pragma once

#include <cstdint>
#include <memory>

#include "model/base/critically_damped.h"
#include "model/base/realtime.h"
#include "model/feet/feet.h"
#include "model/rig/binding.h"
#include "model/stylist/stylist.h"

namespace styled::stylist {

// Steps 5 and 6 of the stylist onto a further skeleton: that of an avatar, whose proportions are
// not the performer's. Rotations go over joint by joint, the way over the floor is scaled by the
// hips' height; what then differs is the feet's to mend: the avatar's lowest foot is as high as the
// performer's, and where a performer's foot is planted the avatar's stands still, styled or not.
// Sized at construction; Process does not allocate. One thread at a time. Pinned by
// tests/unit/stylist/avatar_test.cpp.
class Avatar {
 public:
  // `performer`: the binding of the stylist whose outputs come. `rest`: a pose of the avatar's
  // skeleton, unit rotations, from which joints without a source are taken.
  Avatar(std::shared_ptr<const rig::Binding> performer, std::shared_ptr<const rig::Binding> avatar,
         const rig::RigPose& rest, const Options& options);

  // One frame, after the stylist's Process. `time_ns` grows from call to call; frames may be left
  // out between. False where the pose would be none (model/stylist/guard.h): it is the performer's
  // own motion then, and feet are held anew.
  STYLED_REALTIME bool Process(std::int64_t time_ns, const Output& styled) noexcept;
  // The avatar's pose: its own units and axes, rotations continuous in sign along time.
  const rig::RigPose& pose() const { return pose_; }
  // Forgets contacts and locks: the next frame is the first.
  STYLED_REALTIME void Reset() noexcept;

 private:
  std::shared_ptr<const rig::Binding> performer_, avatar_;
  bool ground_, hold_;
  float ground_tau_s_;
  feet::Feet feet_;
  CriticallyDamped shift_m_;
  rig::RigPose performed_;  // the performer's own pose, rotations of unit length
  rig::RigPose last_, pose_;
  std::int64_t last_ns_ = 0;
  bool started_ = false;
};

}  // namespace styled::stylist
