#pragma once

#include <span>

#include "model/body/pose.h"
#include "model/train/judge/metrics.h"

namespace styled::judge {

// Whether a styled clip still does what its performer did: a punch reaches as far, a kick as high.
// Pure functions of poses (metres, y up, constant rate). Pinned by
// tests/unit/judge/acts_test.cpp.

// A mean over clips after Add; a figure without a count was not measured.
struct ActsKept {
  // Of the hand that is fastest as seen from the chest, where it is farthest from hanging within
  // 0.4 s after its fastest moment: how far the styled hand reaches from its shoulder in the
  // input's direction, over the input's reach (at the styled clip's best frame within 0.2 s after
  // it), and the angle between the two arms then. Only of clips that stay in place.
  Mean reach, direction_deg;
  // The greatest height that a foot ahead of the body reaches above the floor, over the input's.
  // Only of clips in which the input's does so at 40 cm or more, as in a kick.
  Mean kick_height;
  // The worst of each; 1, 0 and 1 if nothing is worse or nothing was measured.
  double least_reach = 1, worst_direction_deg = 0, least_kick_height = 1;

  void Add(const ActsKept& clip);
};

// `input` and `output` are of one clip, frame for frame.
ActsKept MeasureActs(std::span<const body::Pose> input, std::span<const body::Pose> output,
                     double rate_hz);

// The same for every act of a clip, for dances and fights, in which the fastest act alone is not
// representative. A gesture: a hand is fastest relative to the chest within 0.4 s on either side,
// at least 1 m/s, and more than three times as fast as the hips, and its arm is then stretched to
// 30 cm or more. A kick: a foot is highest within 0.4 s, 40 cm above the floor or more, and ahead
// of the body.
ActsKept MeasureEveryAct(std::span<const body::Pose> input, std::span<const body::Pose> output,
                         double rate_hz);

}  // namespace styled::judge
