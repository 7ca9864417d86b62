#pragma once

#include <array>
#include <string_view>

#include "model/base/realtime.h"
#include "model/body/pose.h"
#include "model/stylist/settings.h"

namespace styled::stylist {

// The visibility of a style, defined once for the daemon, `stylize` and the judges. Pure functions;
// any thread. Pinned by tests/unit/stylist/visible_test.cpp.

inline constexpr std::array<std::string_view, 5> kVisibleLimbs{"head", "hands", "elbows", "knees",
                                                               "feet"};
// By limb, m.
using Moved = std::array<float, kVisibleLimbs.size()>;

// The distance by which the style moves each limb, the mean of its two sides, m. Both poses
// canonical, metres; without the hips' path over the floor, which is not part of the style's
// carriage.
STYLED_REALTIME Moved MovedBy(const body::Pose& input, const body::Pose& output) noexcept;

// Whether a style that moves limbs this far on average, over a second or a clip, is not visible: no
// limb moves by tuning::kUnseen_m.
STYLED_REALTIME bool IsUnseen(const Moved& moved_m) noexcept;

// Whether the settings request enough style to be visible: weights of styles other
// than neutral of at least tuning::kVisibleRequest together, on the whole body.
bool RequestsVisibleStyle(const Settings& settings) noexcept;

}  // namespace styled::stylist
