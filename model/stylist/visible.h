#pragma once

#include <array>
#include <string_view>

#include "model/base/realtime.h"
#include "model/body/pose.h"
#include "model/stylist/settings.h"

namespace styled::stylist {

// What is to be seen of a style, in one definition for the daemon, `stylize` and the judges. Pure
// functions; any thread. Pinned by tests/unit/stylist/visible_test.cpp.

inline constexpr std::array<std::string_view, 5> kVisibleLimbs{"head", "hands", "elbows", "knees",
                                                               "feet"};
// By limb, m.
using Moved = std::array<float, kVisibleLimbs.size()>;

// How far the style moves each limb, the mean of its two sides, m. Both poses canonical, metres;
// beside the hips' way over the floor, which is not of the style's carriage.
STYLED_REALTIME Moved MovedBy(const body::Pose& input, const body::Pose& output) noexcept;

// Whether nothing of a style is to be seen where it moves limbs so far on average, over a second or
// a clip: not one by tuning::kUnseen_m.
STYLED_REALTIME bool IsUnseen(const Moved& moved_m) noexcept;

// Whether so much of a style is asked for that one expects to see it: of other styles than neutral
// at least tuning::kAsksForMuch together, on the whole body.
bool AsksForMuch(const Settings& settings) noexcept;

}  // namespace styled::stylist
