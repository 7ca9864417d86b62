#pragma once

#include <Eigen/Core>

#include "model/base/checkpoint.h"
#include "model/base/critically_damped.h"
#include "model/base/realtime.h"
#include "model/body/pose.h"
#include "model/net/styles.h"
#include "model/stylist/change_filter.h"
#include "model/stylist/mixer.h"

namespace styled::stylist {

// Keeps the carriage of a style when the network does not show it: an old person also kicks, waits
// and sits bowed. The trunk, the head and the collars are turned by the part of the style's posture
// (net::StyleInfo::posture) that the change of style of the last half second lacks. The upper arms
// keep their direction in the world, so that the act stays the same. Nothing is added to a
// performer who lies, crouches deeply, bends far or hangs upside down, or for styles without a
// posture. It sets in and ends within a second, in a fall within a third of one. Value type, no
// allocation; one thread at a time. Pinned by tests/unit/stylist/posture_test.cpp.
class PostureKeeper {
 public:
  // Evaluates one frame, `dt_s` after the one before. `change`: the change of style that is applied
  // in it. `amount`, 0 .. 1: the share of the missing posture that is added.
  STYLED_REALTIME void Follow(const net::Styles& styles, const Mixer& mixer,
                              const StyleDelta& change, const body::Pose& input, float amount,
                              float dt_s) noexcept;
  // Adds the posture to a pose that has that change.
  STYLED_REALTIME void Apply(body::Pose& styled) const noexcept;
  STYLED_REALTIME void Reset() noexcept { *this = PostureKeeper(); }
  // The following frames are those of the same performer with left and right exchanged.
  STYLED_REALTIME void Mirror() noexcept;

  // Whether nothing is added.
  bool none() const { return turns_.isZero(0.0F); }
  // The angle by which all joints together are turned, rad.
  float turned_rad() const { return turns_.colwise().norm().sum(); }
  // See model/base/checkpoint.h.
  STYLED_REALTIME void Carry(Checkpoint& c) noexcept {
    c(shown_, wanted_, turns_, share_, stands_);
  }

 private:
  // Rotation vectors by net::kPostureJoints, rad.
  using Turns = Eigen::Matrix<float, 3, net::kPostureJoints.size()>;
  static Turns Wanted(const net::Styles& styles, const Mixer& mixer) noexcept;

  Turns shown_ = Turns::Zero(), wanted_ = Turns::Zero();  // means over the last half second
  Turns turns_ = Turns::Zero();                           // added in this frame
  CriticallyDamped share_;                                // share of the posture that is added
  CriticallyDamped stands_;  // 0 .. 1: the pose is one to which a carriage applies
};

}  // namespace styled::stylist
