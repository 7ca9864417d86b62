#pragma once

#include <cmath>
#include <numbers>

#include "model/feet/legs.h"
#include "model/feet/two_bone_ik.h"

namespace styled::feet {

// A walking canonical humanoid with flat feet, each planted exactly for kStance of its cycle, and a
// possible styled version: shorter steps at the same pace.
struct Walker {
  static constexpr double kCycle_s = 1.1, kStance = 0.6, kSpeed_mps = 0.8;
  static constexpr float kHips_m = 0.92F, kAnkle_m = 0.09F, kLift_m = 0.1F;

  double speed_mps = kSpeed_mps;

  // 0 .. 1; the foot is planted below kStance.
  double Phase(double time_s, int side) const {
    const double cycles = time_s / kCycle_s + 0.5 * side + 10;
    return cycles - std::floor(cycles);
  }
  Vec3 Ankle(double time_s, int side) const {
    const double phase = Phase(time_s, side);
    // A planted foot is below the hips in the middle of its stance.
    const double planted_at_s = time_s - (phase - kStance / 2) * kCycle_s;
    const double u = std::max(0.0, (phase - kStance) / (1 - kStance));
    const double way = u * u * u * (10 - 15 * u + 6 * u * u);
    const double lift = std::pow(std::sin(std::numbers::pi * way), 2);
    return {side == 0 ? 0.09F : -0.09F, kAnkle_m + kLift_m * static_cast<float>(lift),
            static_cast<float>(speed_mps * (planted_at_s + way * kCycle_s))};
  }
  // `steps`: the length of the steps as a share of the covered distance.
  rig::RigPose At(double time_s, float steps = 1) const {
    static const rig::Binding binding = HumanoidBinding();
    static const Legs legs(binding);
    rig::RigPose pose(binding.skeleton());
    pose.translations[0] = Vec3(0, kHips_m, static_cast<float>(speed_mps * time_s));
    for (int side = 0; side < kLegs; ++side) {
      const Legs::Leg& leg = legs.leg(side);
      std::vector<Placed> placed(legs.joints().size());
      legs.Place({pose.translations, pose.rotations}, placed);
      const auto at = [&](int i) { return placed[static_cast<std::size_t>(i)].position_m; };
      Vec3 ankle = Ankle(time_s, side);
      ankle.z() = pose.translations[0].z() + steps * (ankle.z() - pose.translations[0].z());
      const TwoBoneTurns turns =
          ReachFor({at(leg.upper), at(leg.lower), at(leg.foot), Vec3::UnitX()}, ankle);
      const auto set = [&](int i, const Quat& q) {
        pose.rotations[static_cast<std::size_t>(legs.joints()[static_cast<std::size_t>(i)])] = q;
      };
      set(leg.upper, turns.upper);
      set(leg.lower, turns.lower);
      set(leg.foot, (turns.upper * turns.lower).conjugate());
    }
    return pose;
  }
  // The same moment with smaller steps: its feet slide.
  rig::RigPose Styled(double time_s) const { return At(time_s, 0.7F); }
};

}  // namespace styled::feet
