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

// Puts the fingers of other sources on a performer's pose, before it is styled: what comes after
// has them as if the performer's rig had sent them. Where the rig has no fingers, its body has got
// some (PerformerBinding), whose own rotations are those of the T-pose. One per body, pipeline
// thread; only the constructor allocates. Pinned by tests/unit/daemon/fingers_test.cpp.
class Fingers {
 public:
  Fingers() = default;  // none
  // `layers`: the first has precedence; they must outlive it.
  Fingers(std::vector<FingerLayer*> layers, const rig::Binding& binding);

  // `pose`: of the binding's skeleton, in its axes. `elapsed_ns`: of the performer's session.
  // Joints that no layer shows stay bit for bit.
  STYLED_REALTIME void Apply(std::int64_t elapsed_ns, rig::RigPose& pose) noexcept;

  // See model/base/checkpoint.h. The layers are not in it.
  STYLED_REALTIME void Carry(Checkpoint& c) noexcept {
    c(own_, shown_);
    c.Time(elapsed_ns_);
  }

  // The hands of which layers give fingers and the skeleton has no place for any: "left", "right",
  // "left and right"; "" for none.
  std::string HandsWithoutPlace() const;

 private:
  std::vector<FingerLayer*> layers_;
  rig::Tail tail_;  // the fingers alone
  // The performer's own fingers, the last ones that were finite; what the pose has now; what was
  // shown last.
  std::vector<rig::Quat> own_, read_, shown_;
  std::int64_t elapsed_ns_ = 0;
};

// The finger joints that the layers may give.
rig::TailSet JointsOf(std::span<FingerLayer* const> layers);

}  // namespace styled::pipeline
