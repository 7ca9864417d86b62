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

// Keeps the carriage of a style where the network does not show it: whoever is old kicks, waits and
// sits bowed, too. The trunk, the head and the collars are turned by the style's posture
// (net::StyleInfo::posture), as far as the change of style over the last half second lacks it. The
// upper arms keep their direction in the world, so that the act stays what it is. Nothing is added
// to a performer who lies, crouches deeply, bends far or hangs upside down. Styles without a
// posture have none. It sets in and ends within a second, in a fall within a third of one. Value
// type, no allocation; one thread at a time. Pinned by tests/unit/stylist/posture_test.cpp.
class PostureKeeper {
 public:
  // Judges one frame, `dt_s` after the one before. `change`: the change of style that is applied in
  // it. `amount`, 0 .. 1: the share of what lacks that is added.
  STYLED_REALTIME void Follow(const net::Styles& styles, const Mixer& mixer,
                              const StyleDelta& change, const body::Pose& input, float amount,
                              float dt_s) noexcept;
  // Adds it to a pose that has that change.
  STYLED_REALTIME void Apply(body::Pose& styled) const noexcept;
  STYLED_REALTIME void Reset() noexcept { *this = PostureKeeper(); }

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
  Turns turns_ = Turns::Zero();                           // that are added in this frame
  CriticallyDamped share_;                                // of the posture, that is added
  CriticallyDamped stands_;  // 0 .. 1: a body to which a carriage belongs
};

}  // namespace styled::stylist
