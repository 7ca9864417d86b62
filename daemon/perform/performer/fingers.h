#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "daemon/perform/merge/finger_layer.h"
#include "model/base/checkpoint.h"
#include "model/base/realtime.h"
#include "model/rig/binding.h"
#include "model/rig/hands.h"

namespace styled::pipeline {

// Applies the fingers of other sources to a performer's pose before it is styled, so that all later
// steps treat them as the rig's own. If the rig has no fingers, PerformerBinding has added them to
// its body, with the rotations of the T-pose. One per body, pipeline thread; only the constructor
// allocates. Pinned by tests/unit/daemon/perform/performer/fingers_test.cpp.
class Fingers {
 public:
  Fingers() = default;  // none
  // `layers`: the first has precedence; they must outlive it.
  Fingers(std::vector<FingerLayer*> layers, const rig::Binding& binding);

  // `pose`: of the binding's skeleton, in its axes. `elapsed_ns`: of the performer's session.
  // Joints that no layer shows are unchanged bit for bit.
  STYLED_REALTIME void Apply(std::int64_t elapsed_ns, rig::RigPose& pose) noexcept;

  // See model/base/checkpoint.h. The layers are not in it.
  STYLED_REALTIME void Carry(Checkpoint& c) noexcept {
    c(own_, shown_);
    c.Time(elapsed_ns_);
  }

  // The hands for which layers have fingers and the skeleton has no joints: "left", "right", "left
  // and right"; "": none.
  std::string HandsWithoutPlace() const;

 private:
  std::vector<FingerLayer*> layers_;
  rig::Tail tail_;  // only the fingers
  // The performer's own last finite fingers; those read from the current pose; those shown last.
  std::vector<rig::Quat> own_, read_, shown_;
  std::int64_t elapsed_ns_ = 0;
};

// The finger joints that the layers may have.
rig::TailSet JointsOf(std::span<FingerLayer* const> layers);

}  // namespace styled::pipeline
