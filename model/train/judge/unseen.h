#pragma once

#include <functional>
#include <span>

#include "model/train/judge/clip_restyler.h"
#include "model/train/judge/live_restyler.h"
#include "model/train/judge/metrics.h"

namespace styled::judge {

// A style that the network was not trained on, by one example without a label. The shift is that of
// the mean pose (variety.h), compared with the example's own from `normal`, the performer's
// clip without a style. Poses at kJudgeRate_hz.
struct UnseenFigures {
  Expression network, offset;  // offset: a constant rotation per joint, from the same two clips
  net::NearestStyle nearest;   // to the example's code
};
// A network's output for a clip in the style of a code, and its styles; both at kJudgeRate_hz.
struct ByCode {
  const net::StyleSpace& space;
  std::function<Poses(const Poses& clip, const net::StyleCode& code)> restyle;
};
ByCode ByCodeOf(const ClipRestyler& restyler);
// By LiveRestyler, as live.
ByCode ByCodeOf(const LiveRestyler& restyler, const net::StyleSpace& space);

UnseenFigures MeasureUnseen(const ByCode& network, const Poses& source, const Poses& normal,
                            const Poses& example);

// The constant rotation per joint between the mean rotations of two clips, without headings.
ConstantOffset OffsetBetween(std::span<const body::Pose> from, std::span<const body::Pose> to);

}  // namespace styled::judge
