#pragma once

#include "model/train/judge/nets.h"
#include "model/train/judge/unseen.h"

namespace styled::judge {

// The effect of one style of a live network's space on a recorded clip, compared with the example
// of this style and with a constant offset from the same clips. Poses at kJudgeRate_hz; the first
// kSettling frames of the output do not count. Pinned by tests/unit/judge/unseen_test.cpp.
struct LiveUnseenFigures {
  Expression network, offset;  // of mean poses, as in UnseenFigures
  // The distance of the joints' movement about the mean pose (the deviation of each over time) from
  // the example's, divided by the distance of the unstyled clip's: 0 like the example, 1 unchanged.
  double movement = 0, offset_movement = 0;
  double jerk = 0;  // over the input's
  // Share of windows recognized as `style`; without a count where there are no judges, or where the
  // clip is shorter than their window. Real: the example itself.
  Mean recognized, offset_recognized, real_recognized;
};
inline constexpr std::size_t kSettling = 30;

// `code`: of the network's space. `normal`: the performer's clip without a style that `example` is
// compared with. `source`: the clip to restyle. `judges` may be null; otherwise `style` is theirs.
LiveUnseenFigures MeasureLiveUnseen(const ByCode& network, const net::StyleCode& code,
                                    const Poses& source, const Poses& normal, const Poses& example,
                                    const Judges* judges, int style);

}  // namespace styled::judge
