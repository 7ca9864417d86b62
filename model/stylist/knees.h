#pragma once

#include "model/base/realtime.h"
#include "model/body/pose.h"

namespace styled::stylist {

// Keeps the knees of `styled` from bending backwards, or farther backwards than those of `in`: a
// style that straightens a leg was learned on legs that were bent more. The bound is a rounded
// corner, so that a little backward bend remains: a straight leg styled 30 degrees backwards leaves
// at about 10. Smooth. A knee that equals
// the performer's is not changed, nor is one bent beyond what a leg can do. `share`, 0 .. 1: the
// strength of the correction. Pinned by tests/unit/stylist/knees_test.cpp.
STYLED_REALTIME void KeepKnees(const body::Pose& in, float share, body::Pose& styled) noexcept;

}  // namespace styled::stylist
