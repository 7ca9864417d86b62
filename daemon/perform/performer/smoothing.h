#pragma once

#include <cstdint>
#include <vector>

#include "daemon/config/config.h"
#include "model/base/checkpoint.h"
#include "model/base/realtime.h"
#include "model/rig/skeleton.h"

namespace styled::pipeline {

// The One Euro filter (Casiez, Roussel, Vogel, CHI 2012, doi 10.1145/2207676.2208639) for a rig's
// poses: a low-pass whose cutoff grows with the speed, so that a body at rest does not jitter and a
// fast one is not delayed. Each joint's local rotation is filtered by its angular speed, the root's
// position by its speed. One per performer, pipeline thread; only the constructor allocates. Pinned
// by tests/unit/daemon/perform/performer/smoothing_test.cpp.
class PoseSmoothing {
 public:
  PoseSmoothing() = default;  // leaves poses as they are
  PoseSmoothing(const config::Smoothing& options, std::size_t joints, float metres_per_unit);

  bool active() const noexcept { return options_.rest_hz > 0; }
  // The next pose passes unfiltered.
  STYLED_REALTIME void Reset() noexcept { any_ = false; }
  // See model/base/checkpoint.h.
  STYLED_REALTIME void Carry(Checkpoint& c) noexcept {
    c(any_, joints_, position_, velocity_, has_position_);
    c.Time(time_ns_);
  }
  // Filters the pose at a time of the session. Values that are not finite stay, and leave the
  // joint's filter unchanged. After a gap of more than kGap_ns, or a step back, the filter
  // restarts.
  static constexpr std::int64_t kGap_ns = 500'000'000;
  STYLED_REALTIME void Apply(rig::RigPose& pose, std::int64_t time_ns) noexcept;

 private:
  struct Joint {
    rig::Quat rotation = rig::Quat::Identity();  // as filtered
    rig::Vec3 speed = rig::Vec3::Zero();         // rad/s, as filtered
    bool known = false;
    STYLED_REALTIME void Carry(Checkpoint& c) noexcept { c(rotation, speed, known); }
  };
  STYLED_REALTIME void Turn(Joint& joint, rig::Quat& rotation, float step_s) const noexcept;
  STYLED_REALTIME void Move(rig::Vec3& position, float step_s) noexcept;

  config::Smoothing options_;
  float metres_per_unit_ = 1;
  bool any_ = false;
  std::int64_t time_ns_ = 0;
  std::vector<Joint> joints_;
  rig::Vec3 position_ = rig::Vec3::Zero(), velocity_ = rig::Vec3::Zero();  // body units
  bool has_position_ = false;
};

}  // namespace styled::pipeline
