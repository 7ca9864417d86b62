#include "model/stylist/posture.h"

#include <algorithm>

#include "model/base/smooth.h"
#include "model/stylist/tuning.h"

namespace styled::stylist {
namespace {

using body::Pose;
using body::Quat;
using body::WorldPose;

// 0 .. 1: whether the body's pose is one to which a carriage applies.
float Stands(const Pose& input) noexcept {
  WorldPose world;
  body::ForwardKinematics(input, world);
  const body::Vec3 trunk = world.positions_m[body::kNeck] - world.positions_m[body::kHips];
  const float up = trunk.y() / std::max(trunk.norm(), 1e-3F);
  const float height_m = world.positions_m[body::kHips].y() - body::LowestFoot_m(world);
  return SmoothStep(up, tuning::kPostureLies, tuning::kPostureUpright) *
         SmoothStep(height_m, tuning::kPostureCrouches_m, tuning::kPostureSits_m);
}

// A collar's rotation relative to the hips.
Quat Collar(const Pose& pose, std::size_t collar) noexcept {
  return pose.rotations[body::kSpine] * pose.rotations[body::kChest] * pose.rotations[collar];
}

}  // namespace

void PostureKeeper::Mirror() noexcept {
  static_assert(net::kPostureJoints[4] == body::kLeftShoulder &&
                net::kPostureJoints[5] == body::kRightShoulder);
  for (Turns* const turns : {&shown_, &wanted_, &turns_}) {
    turns->bottomRows<2>() *= -1;
    turns->col(4).swap(turns->col(5));
  }
}

PostureKeeper::Turns PostureKeeper::Wanted(const net::Styles& styles, const Mixer& mixer) noexcept {
  Turns wanted = Turns::Zero();
  const auto add = [&](int style, float weight) {
    const auto& posture = styles[static_cast<std::size_t>(style)].posture;
    for (std::size_t i = 0; posture && i < posture->size(); ++i) {
      wanted.col(static_cast<Eigen::Index>(i)) += weight * (*posture)[i];
    }
  };
  for (const net::StyleWeight& active : mixer.in_force()) add(active.style, active.weight);
  add(mixer.input_style(), -mixer.presence());
  for (std::size_t i = 0; i < net::kPostureJoints.size(); ++i) {
    const float share = mixer.share(body::PartOf(net::kPostureJoints[i]));
    wanted.col(static_cast<Eigen::Index>(i)) *= share * (1 - mixer.absolute());
  }
  return wanted;
}

void PostureKeeper::Follow(const net::Styles& styles, const Mixer& mixer, const StyleDelta& change,
                           const Pose& input, float amount, float dt_s) noexcept {
  const Turns wanted = Wanted(styles, mixer);
  const float new_share = DecayShare(dt_s, tuning::kPostureMean_s);
  wanted_ += new_share * (wanted - wanted_);
  for (std::size_t i = 0; i < net::kPostureJoints.size(); ++i) {
    const auto column = static_cast<Eigen::Index>(i);
    shown_.col(column) += new_share * (change.col(net::kPostureJoints[i]) - shown_.col(column));
  }
  // The share of the posture that the change of style already shows, as its projection. A style
  // that sets in is compared with a posture that sets in.
  const float size = wanted_.squaredNorm();
  float lacks = 0;
  if (size > tuning::kNoPosture_rad * tuning::kNoPosture_rad) {
    const float shown = shown_.cwiseProduct(wanted_).sum() / size;
    lacks = amount * std::clamp(1 - shown / tuning::kPostureShown, 0.0F, 1.0F);
  }
  const float share = share_.Follow(lacks, dt_s, tuning::kPostureFade_s / 2);
  if (!(share > 0)) {
    turns_.setZero();
    return;
  }
  const float stands = stands_.Follow(Stands(input), dt_s, tuning::kPostureStands_s);
  turns_ = std::min(share, 1.0F) * std::clamp(stands, 0.0F, 1.0F) * wanted;
}

void PostureKeeper::Apply(Pose& styled) const noexcept {
  if (none()) return;
  const Quat left = Collar(styled, body::kLeftShoulder);
  const Quat right = Collar(styled, body::kRightShoulder);
  for (std::size_t i = 0; i < net::kPostureJoints.size(); ++i) {
    Quat& rotation = styled.rotations[net::kPostureJoints[i]];
    const body::Vec3 turn = turns_.col(static_cast<Eigen::Index>(i));
    rotation = (rotation * body::Exp(turn)).normalized();
  }
  const auto keep = [&styled](std::size_t collar, const Quat& before, std::size_t arm) {
    styled.rotations[arm] =
        (Collar(styled, collar).conjugate() * before * styled.rotations[arm]).normalized();
  };
  keep(body::kLeftShoulder, left, body::kLeftUpperArm);
  keep(body::kRightShoulder, right, body::kRightUpperArm);
}

}  // namespace styled::stylist
