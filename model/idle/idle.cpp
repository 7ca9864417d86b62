#include "model/idle/idle.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "model/base/smooth.h"
#include "model/feet/two_bone_ik.h"

namespace styled::idle {
namespace {

using body::Quat;
using body::Vec3;

constexpr double kTurn = 2 * std::numbers::pi;

// Adults at rest breathe 12 to 20 times and blink some 15 to 20 times a minute; a blink closes the
// lids for 0.1 to 0.4 s. The rate of breath varies by about a tenth.
constexpr double kBreath_s = 4;
constexpr double kBreathVaries_s = 37;
constexpr double kBreathVaries = 0.12;  // turns ahead or behind
// The rates of two performers differ by up to this share for breath, and twice as much for sway:
// side by side they must not move in step.
constexpr double kRatesDiffer = 0.2;
constexpr double kInhale = 0.06;       // turns; inhaling takes 0.4 of a breath
constexpr double kBlinkEvery_s = 3.6;  // one in each such period, at any time of it
constexpr double kBlinkCloses_s = 0.06, kBlinkOpens_s = 0.14;

// A quiet breath lifts the shoulders by some 4 mm; they are 0.15 m from the chest's middle.
constexpr float kShoulders_rad = 0.026F;
constexpr float kChest_rad = 0.016F;  // backwards
constexpr float kSpine_rad = 0.006F;  // forwards

// Standing people shift their weight by one to two centimetres within some ten seconds.
constexpr float kAside_m = 0.012F, kAhead_m = 0.004F;
constexpr double kAside_s = 11.3, kAhead_s = 7.7;
constexpr float kTrunk_m = 0.43F;   // from the hips to the neck
constexpr float kHeadStays = 0.6F;  // share of the shift that the trunk's lean takes back
constexpr float kArms_rad = 0.015F;
constexpr double kArms_s = 6.1;
constexpr float kHeadTurns_rad = 0.045F, kHeadNods_rad = 0.02F;
constexpr double kHeadTurns_s = 9.1, kHeadNods_s = 6.7;

// Of the hips above the ankles, as a share of the legs' length (thigh and shank): from which on a
// body stands. Standing is 1.06, and a chair 0.5.
constexpr float kSits = 0.75F, kStands = 0.95F;
// A straight leg has no room to shift the hips aside, so they sink a little: by the square of the
// amount, because a straight knee bends by the root of it.
constexpr float kSinks_m = 0.001F;

std::uint32_t Mixed(std::uint32_t x) noexcept {
  x ^= x >> 16U;
  x *= 0x7feb352dU;
  x ^= x >> 15U;
  x *= 0x846ca68bU;
  return x ^ (x >> 16U);
}
double Share(std::uint32_t x) noexcept { return Mixed(x) * 0x1p-32; }

struct Leg {
  int upper, lower, foot;
};
constexpr std::array<Leg, 2> kLegs{
    {{body::kLeftUpperLeg, body::kLeftLowerLeg, body::kLeftFoot},
     {body::kRightUpperLeg, body::kRightLowerLeg, body::kRightFoot}}};

float LegLength_m() {
  static const float length_m =
      body::Offset(body::kLeftLowerLeg).norm() + body::Offset(body::kLeftFoot).norm();
  return length_m;
}

// 0: the body sits, kneels or lies; 1: it stands.
float Stands(const body::WorldPose& world) noexcept {
  const float ankle_m =
      std::max(world.positions_m[body::kLeftFoot].y(), world.positions_m[body::kRightFoot].y());
  return SmoothStep((world.positions_m[body::kHips].y() - ankle_m) / LegLength_m(), kSits, kStands);
}

// Turns the leg so that its foot is where it was in `before`, though the hips have moved.
void KeepFoot(const Leg& leg, const body::WorldPose& before, const Vec3& moved_m,
              body::Pose& pose) noexcept {
  const Quat& upper = before.rotations[static_cast<std::size_t>(leg.upper)];
  const Quat& lower = before.rotations[static_cast<std::size_t>(leg.lower)];
  const Quat& foot = before.rotations[static_cast<std::size_t>(leg.foot)];
  const Vec3& ankle = before.positions_m[static_cast<std::size_t>(leg.foot)];
  const feet::TwoBones bones{
      .hip = before.positions_m[static_cast<std::size_t>(leg.upper)] + moved_m,
      .knee = before.positions_m[static_cast<std::size_t>(leg.lower)] + moved_m,
      .ankle = ankle + moved_m,
      .hinge = upper * Vec3::UnitX()};
  const feet::TwoBoneTurns turns = feet::ReachFor(bones, ankle);
  const Quat new_upper = turns.upper * upper;
  const Quat new_lower = turns.upper * turns.lower * lower;
  const Quat& hips = pose.rotations[body::kHips];
  pose.rotations[static_cast<std::size_t>(leg.upper)] = (hips.conjugate() * new_upper).normalized();
  pose.rotations[static_cast<std::size_t>(leg.lower)] =
      (new_upper.conjugate() * new_lower).normalized();
  pose.rotations[static_cast<std::size_t>(leg.foot)] = (new_lower.conjugate() * foot).normalized();
}

void Turn(body::Pose& pose, int joint, const Vec3& turn_rad) noexcept {
  Quat& rotation = pose.rotations[static_cast<std::size_t>(joint)];
  rotation = (rotation * body::Exp(turn_rad)).normalized();
}

}  // namespace

Idle::Idle(std::uint32_t seed)
    : seed_(Mixed(seed ^ 0x9e3779b9U)),
      breath_rate_(1 - kRatesDiffer / 2 + kRatesDiffer * Share(seed_ + 100)),
      sway_rate_(1 - kRatesDiffer + 2 * kRatesDiffer * Share(seed_ + 101)) {
  for (std::size_t i = 0; i < phases_.size(); ++i) {
    phases_[i] = Share(seed_ + static_cast<std::uint32_t>(i));
  }
}

// Slow, without a period that a viewer would see, -1 .. 1: three sines whose periods have no common
// multiple.
float Idle::Wander(int which, double time_s, double period_s) const noexcept {
  const auto at = 3 * static_cast<std::size_t>(which);
  const double turns = sway_rate_ * time_s / period_s;
  return static_cast<float>(0.5 * std::sin(kTurn * (turns + phases_[at])) +
                            0.3 * std::sin(kTurn * (1.618 * turns + phases_[at + 1])) +
                            0.2 * std::sin(kTurn * (2.414 * turns + phases_[at + 2])));
}

// -1 after exhaling .. 1 after inhaling.
float Idle::Breath(double time_s) const noexcept {
  const double turns = breath_rate_ * time_s / kBreath_s + phases_[0] +
                       kBreathVaries * std::sin(kTurn * (time_s / kBreathVaries_s + phases_[1]));
  return static_cast<float>(std::sin(kTurn * (turns + kInhale * std::sin(kTurn * turns))));
}

void Idle::Add(double time_s, const Amounts& amounts, body::Pose& pose) const noexcept {
  body::WorldPose before;
  body::ForwardKinematics(pose, before);
  const float body_amount = amounts.body;
  const float stands = Stands(before);
  // 1 Weight: the hips move over the feet, in the body's own heading.
  const float aside_m = body_amount * stands * kAside_m * Wander(1, time_s, kAside_s);
  const float ahead_m = body_amount * stands * kAhead_m * Wander(2, time_s, kAhead_s);
  Vec3 left = pose.rotations[body::kHips] * Vec3::UnitX();
  left.y() = 0;
  left = left.norm() > 1e-3F ? left.normalized() : Vec3::UnitX();
  Vec3 moved_m = aside_m * left + ahead_m * left.cross(Vec3::UnitY());
  moved_m.y() = -body_amount * body_amount * stands * kSinks_m -
                0.6F * (aside_m * aside_m + ahead_m * ahead_m);
  if (stands > 0) {
    pose.hips_position_m += moved_m;
    for (const Leg& leg : kLegs) KeepFoot(leg, before, moved_m, pose);
  }
  // 2 Trunk: it leans back over the feet, and the chest breathes.
  const float breath = body_amount * Breath(time_s);
  const float lean_rad = kHeadStays * aside_m / kTrunk_m;  // about z, to the left side's rise
  Turn(pose, body::kSpine, {breath * kSpine_rad, 0, lean_rad});
  Turn(pose, body::kChest, {-breath * kChest_rad, 0, 0});
  // 3 Arms: the shoulders rise with the breath; the arms follow slowly.
  const float rise_rad = breath * kShoulders_rad;
  const float swing_rad = body_amount * kArms_rad;
  Turn(pose, body::kLeftShoulder, {0, 0, rise_rad});
  Turn(pose, body::kRightShoulder, {0, 0, -rise_rad});
  Turn(pose, body::kLeftUpperArm, {0, swing_rad * Wander(3, time_s, kArms_s), -0.6F * rise_rad});
  Turn(pose, body::kRightUpperArm, {0, swing_rad * Wander(4, time_s, kArms_s), 0.6F * rise_rad});
  // 4 Head: as it was in the world, apart from its own wandering.
  const Quat trunk =
      pose.rotations[body::kHips] * pose.rotations[body::kSpine] * pose.rotations[body::kChest];
  pose.rotations[body::kNeck] = (trunk.conjugate() * before.rotations[body::kNeck]).normalized();
  if (amounts.head > 0) {
    Turn(pose, body::kHead,
         {amounts.head * kHeadNods_rad * Wander(5, time_s, kHeadNods_s),
          amounts.head * kHeadTurns_rad * Wander(6, time_s, kHeadTurns_s), 0});
  }
}

// One blink per period of kBlinkEvery_s, so that the eyes are never open for twice as long; now and
// then two follow each other at once, as people's do.
float Idle::Blink(double time_s) const noexcept {
  constexpr double kLasts_s = kBlinkCloses_s + kBlinkOpens_s;
  const double period = std::floor(time_s / kBlinkEvery_s);
  const auto number = static_cast<std::uint32_t>(static_cast<std::int64_t>(period));
  const double begins_s = Share(seed_ ^ (number * 0x85ebca6bU)) * (kBlinkEvery_s - kLasts_s);
  const double since_s = time_s - period * kBlinkEvery_s - begins_s;
  if (since_s < 0 || since_s > kLasts_s) return 0;
  return since_s < kBlinkCloses_s
             ? SmoothStep(static_cast<float>(since_s / kBlinkCloses_s))
             : 1 - SmoothStep(static_cast<float>((since_s - kBlinkCloses_s) / kBlinkOpens_s));
}

}  // namespace styled::idle
