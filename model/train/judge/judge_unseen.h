#pragma once

#include <span>

#include "model/train/judge/judge_clip_restyler.h"
#include "model/train/judge/judge_metrics.h"

namespace styled::judge {

// A style that the network was not trained on, by one example without a label. The shift is that of
// the mean pose (judge_variety.h), compared with the example's own from `normal`, the performer's
// clip without a style. Poses at kJudgeRate_hz.
struct UnseenFigures {
  Expression network, offset;  // offset: a constant rotation per joint, from the same two clips
  net::NearestStyle nearest;   // to the example's code
};
UnseenFigures MeasureUnseen(const ClipRestyler& restyler, const Poses& source, const Poses& normal,
                            const Poses& example);

// The constant rotation per joint between the mean rotations of two clips, without headings.
ConstantOffset OffsetBetween(std::span<const body::Pose> from, std::span<const body::Pose> to);

}  // namespace styled::judge
