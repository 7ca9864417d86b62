#include "model/train/judge/acts.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "model/train/judge/gait.h"

namespace styled::judge {
namespace {

using body::Vec3;
using Worlds = std::vector<body::WorldPose>;

constexpr double kReachWithin_s = 0.4;  // from the fastest moment to the end of a punch
constexpr double kLate_s = 0.2;         // how much later the styled gesture may be, a kick also
                                        // earlier
constexpr float kInPlace_mps = 0.5F;    // hips slower than this: a gesture, not a swing in a walk
constexpr float kGesture_mps = 1.0F;    // a hand that is never faster makes no gesture
constexpr float kAhead_m = 0.3F;        // a foot so far in front of the hips is not lifted for a
                                        // step
constexpr float kKick_m = 0.4F;
constexpr float kSwing = 3;           // in a walk or run the hands are less faster than the hips
constexpr double kApart_s = 0.4;      // an act is the fastest or highest within this
constexpr float kStretched_m = 0.3F;  // the direction of a hand nearer to its shoulder is
                                      // meaningless

Worlds WorldsOf(std::span<const body::Pose> poses) {
  Worlds worlds(poses.size());
  for (std::size_t i = 0; i < poses.size(); ++i) body::ForwardKinematics(poses[i], worlds[i]);
  return worlds;
}

Vec3 At(const body::WorldPose& world, int joint) {
  return world.positions_m[static_cast<std::size_t>(joint)];
}

float Floor_m(const Worlds& worlds) {
  float floor_m = body::LowestFoot_m(worlds[0]);
  for (const body::WorldPose& world : worlds) {
    floor_m = std::min(floor_m, body::LowestFoot_m(world));
  }
  return floor_m;
}

// From the shoulder to the hand.
Vec3 Arm(const body::WorldPose& world, int hand) { return At(world, hand) - At(world, hand - 2); }

// A hand and the frame at which its gesture has reached its end.
struct Gesture {
  int hand = body::kLeftHand;
  std::size_t frame = 0;
};

// Frames within `within_s` of `frame`: the first, and one past the last.
std::pair<std::size_t, std::size_t> Around(std::size_t frame, double within_s, double rate_hz,
                                           std::size_t frames) {
  const auto within = static_cast<std::size_t>(within_s * rate_hz);
  return {frame - std::min(frame, within), std::min(frames, frame + within + 1)};
}

// Speeds of a hand as seen from the chest.
std::vector<float> HandSpeeds_mps(const Worlds& worlds, int hand, double rate_hz) {
  const auto from_chest = [&](std::size_t frame) {
    return Vec3(At(worlds[frame], hand) - At(worlds[frame], body::kChest));
  };
  std::vector<float> speeds_mps(worlds.size());
  for (std::size_t i = 1; i < worlds.size(); ++i) {
    speeds_mps[i] = (from_chest(i) - from_chest(i - 1)).norm() * static_cast<float>(rate_hz);
  }
  return speeds_mps;
}

// How far the hand is from where it would be if the arm hung.
float FromHanging_m(const body::WorldPose& world, int hand) {
  const float length_m = (At(world, hand) - At(world, hand - 1)).norm() +
                         (At(world, hand - 1) - At(world, hand - 2)).norm();
  return (Arm(world, hand) + length_m * Vec3::UnitY()).norm();
}

// The frame in which the hand has reached its end: the one farthest from hanging within
// kReachWithin_s after `fastest`, moved on until none within kLate_s is farther. Not the farthest
// from the shoulder: a hand that is raised beside a bent elbow is nearer to it than a hanging one.
std::size_t EndOf(const Worlds& worlds, int hand, std::size_t fastest, double rate_hz) {
  const auto farthest = [&](std::size_t first, std::size_t end, std::size_t frame) {
    for (std::size_t i = first; i < end; ++i) {
      if (FromHanging_m(worlds[i], hand) > FromHanging_m(worlds[frame], hand)) frame = i;
    }
    return frame;
  };
  const std::size_t frames = worlds.size();
  std::size_t frame =
      farthest(fastest, Around(fastest, kReachWithin_s, rate_hz, frames).second, fastest);
  for (std::size_t last = frames; last != frame;) {  // ends: the distance grows with every step
    last = frame;
    const auto [first, past] = Around(frame, kLate_s, rate_hz, frames);
    frame = farthest(first, past, frame);
  }
  return frame;
}

std::optional<Gesture> FindGesture(const Worlds& worlds, double rate_hz) {
  float fastest_mps = kGesture_mps;
  std::optional<Gesture> gesture;
  for (const int hand : {body::kLeftHand, body::kRightHand}) {
    const std::vector<float> speeds_mps = HandSpeeds_mps(worlds, hand, rate_hz);
    for (std::size_t i = 1; i < worlds.size(); ++i) {
      if (speeds_mps[i] <= fastest_mps) continue;
      fastest_mps = speeds_mps[i];
      gesture = Gesture{hand, i};
    }
  }
  if (gesture) gesture->frame = EndOf(worlds, gesture->hand, gesture->frame, rate_hz);
  return gesture;
}

// Frames whose value is at least `least` and the greatest within kApart_s.
std::vector<std::size_t> Peaks(const std::vector<float>& values, float least, double rate_hz) {
  std::vector<std::size_t> peaks;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const auto [first, end] = Around(i, kApart_s, rate_hz, values.size());
    const auto at = values.begin();
    const auto greatest = std::max_element(at + static_cast<std::ptrdiff_t>(first),
                                           at + static_cast<std::ptrdiff_t>(end));
    if (values[i] >= least && greatest == at + static_cast<std::ptrdiff_t>(i)) peaks.push_back(i);
  }
  return peaks;
}

// The hips' mean horizontal speed within kApart_s of `frame`.
float HipsSpeed_mps(const Worlds& worlds, std::size_t frame, double rate_hz) {
  const auto [first, end] = Around(frame, kApart_s, rate_hz, worlds.size());
  float way_m = 0;
  for (std::size_t i = first + 1; i < end; ++i) {
    const Vec3 step = At(worlds[i], body::kHips) - At(worlds[i - 1], body::kHips);
    way_m += std::hypot(step.x(), step.z());
  }
  return way_m * static_cast<float>(rate_hz) / static_cast<float>(end - first - 1);
}

void AddGesture(const Worlds& in, const Worlds& out, const Gesture& gesture, double rate_hz,
                ActsKept& kept) {
  const Vec3 arm_in = Arm(in[gesture.frame], gesture.hand);
  const std::size_t end = Around(gesture.frame, kLate_s, rate_hz, out.size()).second;
  float reach_m = -1;
  Vec3 arm_out = arm_in;
  for (std::size_t i = gesture.frame; i < end; ++i) {
    const Vec3 arm = Arm(out[i], gesture.hand);
    const float along_m = arm.dot(arm_in.normalized());
    if (along_m > reach_m) reach_m = along_m, arm_out = arm;
  }
  const double reach = reach_m / arm_in.norm();
  const double off_deg =
      std::acos(std::clamp(arm_out.normalized().dot(arm_in.normalized()), -1.0F, 1.0F)) * kDegrees;
  kept.reach.Add(reach);
  kept.direction_deg.Add(off_deg);
  kept.least_reach = std::min(kept.least_reach, reach);
  kept.worst_direction_deg = std::max(kept.worst_direction_deg, off_deg);
}

void AddKick(double height, ActsKept& kept) {
  kept.kick_height.Add(height);
  kept.least_kick_height = std::min(kept.least_kick_height, height);
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

void AddEveryGesture(const Worlds& in, const Worlds& out, double rate_hz, ActsKept& kept) {
  for (const int hand : {body::kLeftHand, body::kRightHand}) {
    const std::vector<float> speeds_mps = HandSpeeds_mps(in, hand, rate_hz);
    for (const std::size_t fastest : Peaks(speeds_mps, kGesture_mps, rate_hz)) {
      if (kSwing * HipsSpeed_mps(in, fastest, rate_hz) > speeds_mps[fastest]) continue;
      const Gesture gesture{hand, EndOf(in, hand, fastest, rate_hz)};
      if (Arm(in[gesture.frame], hand).norm() < kStretched_m) continue;
      AddGesture(in, out, gesture, rate_hz, kept);
    }
  }
}

void AddEveryKick(const Worlds& in, const Worlds& out, double rate_hz, ActsKept& kept) {
  const float floor_m = Floor_m(in);
  const std::vector<Vec3> headings = SmoothHeadings(in, rate_hz);
  for (const int foot : {body::kLeftFoot, body::kRightFoot}) {
    std::vector<float> heights_m(in.size());
    for (std::size_t i = 0; i < in.size(); ++i) {
      const bool ahead = headings[i].dot(At(in[i], foot) - At(in[i], body::kHips)) >= kAhead_m;
      if (ahead) heights_m[i] = At(in[i], foot).y() - floor_m;
    }
    for (const std::size_t kick : Peaks(heights_m, kKick_m, rate_hz)) {
      const auto [first, end] = Around(kick, kLate_s, rate_hz, out.size());
      float in_m = 0;
      float out_m = 0;
      for (std::size_t i = first; i < end; ++i) {
        in_m = std::max(in_m, At(in[i], foot).y() - floor_m);
        out_m = std::max(out_m, At(out[i], foot).y() - floor_m);
      }
      AddKick(out_m / in_m, kept);
    }
  }
}

}  // namespace

void ActsKept::Add(const ActsKept& clip) {
  reach.Add(clip.reach);
  direction_deg.Add(clip.direction_deg);
  kick_height.Add(clip.kick_height);
  least_reach = std::min(least_reach, clip.least_reach);
  worst_direction_deg = std::max(worst_direction_deg, clip.worst_direction_deg);
  least_kick_height = std::min(least_kick_height, clip.least_kick_height);
}

ActsKept MeasureActs(std::span<const body::Pose> input, std::span<const body::Pose> output,
                     double rate_hz) {
  ActsKept kept;
  if (input.size() < 2) return kept;
  const Worlds in = WorldsOf(input);
  const Worlds out = WorldsOf(output);
  const float floor_m = Floor_m(in);
  const float kick_in_m = KickHeight_m(in, rate_hz, floor_m);
  if (kick_in_m >= kKick_m) AddKick(KickHeight_m(out, rate_hz, floor_m) / kick_in_m, kept);

  const Mean speed_cm_s = MeasureGait(input, rate_hz).speed_cm_s;
  if (speed_cm_s.count <= 0 || speed_cm_s.value() > 100 * kInPlace_mps) return kept;
  const std::optional<Gesture> gesture = FindGesture(in, rate_hz);
  if (!gesture) return kept;
  AddGesture(in, out, *gesture, rate_hz, kept);
  return kept;
}

ActsKept MeasureEveryAct(std::span<const body::Pose> input, std::span<const body::Pose> output,
                         double rate_hz) {
  ActsKept kept;
  if (input.size() < 2) return kept;
  const Worlds in = WorldsOf(input);
  const Worlds out = WorldsOf(output);
  AddEveryGesture(in, out, rate_hz, kept);
  AddEveryKick(in, out, rate_hz, kept);
  return kept;
}

}  // namespace styled::judge
