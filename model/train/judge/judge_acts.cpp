#include "model/train/judge/judge_acts.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "model/train/judge/judge_gait.h"

namespace styled::judge {
namespace {

using body::Vec3;
using Worlds = std::vector<body::WorldPose>;

constexpr double kReachWithin_s = 0.4;  // from the fastest moment to the end of a punch
constexpr double kLate_s = 0.2;         // how much earlier or later the styled gesture may be
constexpr float kInPlace_mps = 0.5F;    // hips slower than this: a gesture, not a swing in a walk
constexpr float kGesture_mps = 1.0F;    // a hand that is never faster makes no gesture
constexpr float kAhead_m = 0.3F;        // a foot so far before the hips is not lifted for a step
constexpr float kKick_m = 0.4F;

Worlds WorldsOf(std::span<const body::Pose> poses) {
  Worlds worlds(poses.size());
  for (std::size_t i = 0; i < poses.size(); ++i) body::ForwardKinematics(poses[i], worlds[i]);
  return worlds;
}

Vec3 At(const body::WorldPose& world, int joint) {
  return world.positions_m[static_cast<std::size_t>(joint)];
}

// From the shoulder to the hand.
Vec3 Arm(const body::WorldPose& world, int hand) { return At(world, hand) - At(world, hand - 2); }

// A hand and the frame at which its gesture has reached its end.
struct Gesture {
  int hand = body::kLeftHand;
  std::size_t frame = 0;
};

std::optional<Gesture> FindGesture(const Worlds& worlds, double rate_hz) {
  float fastest_mps = kGesture_mps;
  std::optional<Gesture> gesture;
  for (const int hand : {body::kLeftHand, body::kRightHand}) {
    for (std::size_t i = 1; i < worlds.size(); ++i) {
      const auto from_chest = [&](std::size_t frame) {
        return Vec3(At(worlds[frame], hand) - At(worlds[frame], body::kChest));
      };
      const float speed_mps =
          (from_chest(i) - from_chest(i - 1)).norm() * static_cast<float>(rate_hz);
      if (speed_mps > fastest_mps) {
        fastest_mps = speed_mps;
        gesture = Gesture{hand, i};
      }
    }
  }
  if (!gesture) return gesture;
  const auto end = std::min(
      worlds.size(), gesture->frame + static_cast<std::size_t>(kReachWithin_s * rate_hz) + 1);
  float farthest_m = 0;
  for (std::size_t i = gesture->frame; i < end; ++i) {
    const float reach_m = Arm(worlds[i], gesture->hand).norm();
    if (reach_m > farthest_m) farthest_m = reach_m, gesture->frame = i;
  }
  return gesture;
}

// The greatest height above `floor_m` of a foot ahead of the hips; 0 if none is.
float KickHeight_m(const Worlds& worlds, double rate_hz, float floor_m) {
  const std::vector<Vec3> headings = SmoothHeadings(worlds, rate_hz);
  float highest_m = 0;
  for (std::size_t i = 0; i < worlds.size(); ++i) {
    for (const int foot : {body::kLeftFoot, body::kRightFoot}) {
      const Vec3 from_hips = At(worlds[i], foot) - At(worlds[i], body::kHips);
      if (headings[i].dot(from_hips) < kAhead_m) continue;
      highest_m = std::max(highest_m, At(worlds[i], foot).y() - floor_m);
    }
  }
  return highest_m;
}

}  // namespace

void ActsKept::Add(const ActsKept& clip) {
  reach.Add(clip.reach);
  direction_deg.Add(clip.direction_deg);
  kick_height.Add(clip.kick_height);
}

ActsKept MeasureActs(std::span<const body::Pose> input, std::span<const body::Pose> output,
                     double rate_hz) {
  ActsKept kept;
  if (input.size() < 2) return kept;
  const Worlds in = WorldsOf(input);
  const Worlds out = WorldsOf(output);
  float floor_m = body::LowestFoot_m(in[0]);
  for (const body::WorldPose& world : in) floor_m = std::min(floor_m, body::LowestFoot_m(world));
  const float kick_in_m = KickHeight_m(in, rate_hz, floor_m);
  if (kick_in_m >= kKick_m) {
    kept.kick_height.Add(KickHeight_m(out, rate_hz, floor_m) / kick_in_m);
  }

  const Mean speed_cm_s = MeasureGait(input, rate_hz).speed_cm_s;
  if (speed_cm_s.count <= 0 || speed_cm_s.value() > 100 * kInPlace_mps) return kept;
  const std::optional<Gesture> gesture = FindGesture(in, rate_hz);
  if (!gesture) return kept;
  const Vec3 arm_in = Arm(in[gesture->frame], gesture->hand);
  const auto late = static_cast<std::size_t>(kLate_s * rate_hz);
  const std::size_t end = std::min(out.size(), gesture->frame + late + 1);
  float reach_m = -1;
  Vec3 arm_out = arm_in;
  for (std::size_t i = gesture->frame - std::min(gesture->frame, late); i < end; ++i) {
    const Vec3 arm = Arm(out[i], gesture->hand);
    const float along_m = arm.dot(arm_in.normalized());
    if (along_m > reach_m) reach_m = along_m, arm_out = arm;
  }
  kept.reach.Add(reach_m / arm_in.norm());
  kept.direction_deg.Add(
      std::acos(std::clamp(arm_out.normalized().dot(arm_in.normalized()), -1.0F, 1.0F)) *
      57.29578F);
  return kept;
}

}  // namespace styled::judge
