#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "daemon/config/config.h"
#include "daemon/perform/merge/merged_part.h"
#include "daemon/perform/performer/smoothing.h"
#include "daemon/source/source_frame.h"
#include "model/base/realtime.h"
#include "model/base/status.h"
#include "model/rig/hands.h"

namespace styled::pipeline {

// The newest fingers of a source that is merged into a performer. Each finger joint is read
// relative to the source's own hand and its T-pose (model/rig/tail.h), so the source's wrist, arm
// and place do not matter. A joint keeps its last rotation for kHold_ns, then turns to the
// performer's own within kFade_ns. When data returns, it turns to the source's rotation in the same
// time. These times are counted on the performer's clock, so that a replay gives the same bits.
// Only AcceptBody allocates. Pipeline thread. Pinned by
// tests/unit/daemon/perform/merge/finger_layer_test.cpp.
class FingerLayer : public MergedPart {
 public:
  // `wanted`: the joints used if the source has them. `names`: the source's joint names set by
  // hand.
  FingerLayer(const rig::TailSet& wanted, rig::JointNames names, config::Smoothing smoothing);

  const rig::TailSet& wanted() const { return wanted_; }

  enum class Body : std::uint8_t { kSame, kBound, kNotNext };
  // Accepts the body of the source's poses: a whole one, or hands alone. An error, once for each
  // such body, if it cannot be bound or has no wanted finger; the fingers then fall silent. Not
  // next: an old body, or another sender's; why() is the counter. `now_ns`: monotonic.
  Result<Body> AcceptBody(const source::SourceFrame& body, std::int64_t now_ns);
  runtime::Counter why() const { return why_; }  // what the last body counts as that was not next
  // Takes a frame over; kAccepted, or what it is refused as. A joint that is not tracked, not
  // finite or of no length keeps its last rotation, and counts as silent.
  STYLED_REALTIME runtime::Counter Accept(const source::SourceFrame& frame,
                                          std::int64_t now_ns) noexcept;

  // Advances the fades by `step_ns` of the performer's time.
  STYLED_REALTIME void Advance(std::int64_t step_ns) noexcept;
  // Turns the rotation of a finger joint (a TailJoint) towards the layer's. Returns false if the
  // layer has none now.
  STYLED_REALTIME bool Over(int joint, rig::Quat& rotation) const noexcept;

 private:
  struct Finger {
    rig::Quat rotation = rig::Quat::Identity();
    bool fresh = false;  // arrived since the last Advance
    std::int64_t silent_ns = kHold_ns + 1;
    float weight = 0;
  };
  // The state that belongs to one body.
  struct Bound {
    explicit Bound(const rig::Skeleton& skeleton) : pose(skeleton), held(skeleton.names.size()) {
      sound.assign(held.size(), rig::Quat::Identity());
    }
    rig::Tail tail;
    std::vector<rig::Quat> turns;  // last rotations of tail's joints
    rig::RigPose pose;
    std::vector<bool> held;        // joints that the last frame does not track
    std::vector<rig::Quat> sound;  // each joint's last valid rotation
    PoseSmoothing smoothing;
  };
  Status Bind(const v1::Body& body);
  STYLED_REALTIME static void HoldBadJoints(Bound& bound) noexcept;

  runtime::Counter why_ = kAccepted;
  rig::TailSet wanted_;
  rig::JointNames names_;
  config::Smoothing options_;
  std::unique_ptr<Bound> bound_;  // null: no body, or a refused one
  std::optional<std::uint32_t> crc_;
  std::array<Finger, rig::kTailLeftEye> fingers_;
};

}  // namespace styled::pipeline
