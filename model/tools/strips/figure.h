#pragma once

#include "model/body/pose.h"
#include "model/tools/strips/canvas.h"

namespace styled::strips {

inline constexpr Color kLeft{36, 106, 190}, kRight{205, 70, 50}, kTrunk{60, 60, 60},
    kFloor{200, 200, 200};

// The place and direction of a drawn figure; its hips are at the middle.
inline constexpr float kFromTheRight_rad = 1.5707963F;
struct Place {
  float centre_px = 0, floor_px = 0, scale_px = 92;  // per metre
  float heading_rad = 0;                             // of the figure, turned away
  float view_rad = 0;  // 0: seen from the front; kFromTheRight_rad: it looks to the picture's right
  float floor_m = 0;   // the height that is drawn at floor_px
};

// Draws the humanoid as lines, the far side first: left limbs blue, right ones red.
void DrawFigure(const body::Pose& pose, const Place& place, Canvas& canvas);

}  // namespace styled::strips
