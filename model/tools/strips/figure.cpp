#include "model/tools/strips/figure.h"

#include <cmath>
#include <utility>

#include "model/body/heading.h"

namespace styled::strips {
namespace {

// 0 left, 1 the trunk, 2 right.
int SideOf(int joint) {
  if ((joint >= body::kLeftShoulder && joint <= body::kLeftHand) ||
      (joint >= body::kLeftUpperLeg && joint <= body::kLeftToes)) {
    return 0;
  }
  return body::MirrorJoint(joint) == joint ? 1 : 2;
}

}  // namespace

void DrawFigure(const body::Pose& pose, const Place& place, Canvas& canvas) {
  body::WorldPose world;
  body::ForwardKinematics(pose, world);
  const body::Quat turned = body::Yaw(-place.heading_rad);
  const float across = std::cos(place.view_rad), along = std::sin(place.view_rad);
  const auto level_px = [&](const body::Vec3& p) {
    return place.scale_px * (across * p.x() + along * p.z());
  };
  const auto point = [&](int joint) {
    const body::Vec3& at = world.positions_m[static_cast<std::size_t>(joint)];
    return std::pair{place.centre_px + level_px(turned * (at - pose.hips_position_m)),
                     place.floor_px - place.scale_px * (at.y() - place.floor_m)};
  };
  const float width_px = 3.5F * place.scale_px / 92;
  for (const int layer : {0, 1, 2}) {  // the far side first
    for (int joint = 1; joint < body::kJointCount; ++joint) {
      if (SideOf(joint) != layer) continue;
      const auto [x0, y0] = point(body::kHumanoid[static_cast<std::size_t>(joint)].parent);
      const auto [x1, y1] = point(joint);
      canvas.Line(x0, y0, x1, y1, width_px, layer == 0 ? kLeft : layer == 1 ? kTrunk : kRight);
    }
  }
  const body::Quat head = turned * world.rotations[body::kHead];
  const body::Vec3 crown = head * body::Vec3(0, 0.12F, 0.02F);
  const auto [x, y] = point(body::kHead);
  canvas.Line(x, y, x + level_px(crown), y - place.scale_px * crown.y(), 13 * width_px / 3.5F,
              kTrunk);
}

}  // namespace styled::strips
