#include "model/stylist/visible.h"

#include <algorithm>
#include <cstddef>

#include "model/stylist/tuning.h"

namespace styled::stylist {
namespace {

using body::Pose;
using body::WorldPose;

// Left and right; the head is both.
constexpr std::array<std::array<body::Joint, 2>, kVisibleLimbs.size()> kJoints{
    {{body::kHead, body::kHead},
     {body::kLeftHand, body::kRightHand},
     {body::kLeftLowerArm, body::kRightLowerArm},
     {body::kLeftLowerLeg, body::kRightLowerLeg},
     {body::kLeftFoot, body::kRightFoot}}};

WorldPose InPlace(const Pose& pose) noexcept {
  Pose in_place = pose;
  in_place.hips_position_m.x() = in_place.hips_position_m.z() = 0;
  WorldPose world;
  body::ForwardKinematics(in_place, world);
  return world;
}

}  // namespace

Moved MovedBy(const Pose& input, const Pose& output) noexcept {
  const WorldPose from = InPlace(input), to = InPlace(output);
  Moved moved_m{};
  for (std::size_t limb = 0; limb < kJoints.size(); ++limb) {
    for (const body::Joint joint : kJoints[limb]) {
      moved_m[limb] += (to.positions_m[joint] - from.positions_m[joint]).norm() / 2;
    }
  }
  return moved_m;
}

bool IsUnseen(const Moved& moved_m) noexcept {
  return std::ranges::all_of(moved_m, [](float m) { return m < tuning::kUnseen_m; });
}

bool RequestsVisibleStyle(const Settings& settings) noexcept {
  float sum = 0;
  for (const net::StyleWeight& entry : settings.mix) {
    if (entry.style > 0) sum += entry.weight;
  }
  return sum * settings.strength >= tuning::kVisibleRequest && settings.parts == body::kAllParts;
}

}  // namespace styled::stylist
