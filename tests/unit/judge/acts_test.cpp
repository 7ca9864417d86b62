#include "model/train/judge/acts.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace styled::judge {
namespace {

constexpr double kActsRate_hz = 120;
constexpr float kPi = std::numbers::pi_v<float>;

// Two seconds of standing with one punch of the left hand after a second, straight ahead and turned
// by `off_rad` to the side; the elbow keeps `bent_rad`. `late_s` later than the performer's.
std::vector<body::Pose> Punch(float off_rad, float bent_rad, float late_s) {
  std::vector<body::Pose> poses(240);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const float time_s = static_cast<float>(static_cast<double>(i) / kActsRate_hz) - late_s;
    const float done = std::clamp((time_s - 1) / 0.15F, 0.0F, 1.0F);
    // From a hanging arm with a bent elbow to a stretched one; at rest the arm points to the left.
    const body::Quat down = body::Exp(body::Vec3(0, 0, -kPi / 2));
    const body::Quat ahead = body::Exp(body::Vec3(0, -kPi / 2 + off_rad, 0));
    poses[i].rotations[body::kLeftUpperArm] = down.slerp(done, ahead);
    const float elbow = 1.8F + done * (bent_rad - 1.8F);
    poses[i].rotations[body::kLeftLowerArm] = body::Exp(body::Vec3(0, -elbow, 0));
  }
  return poses;
}

// That punch, and the hand drawn back the same way; then the same again, `off_rad` to the side.
std::vector<body::Pose> TwoPunches(float off_rad) {
  std::vector<body::Pose> poses;
  for (const float off : {0.0F, off_rad}) {
    const auto there = Punch(off, 0, 0);
    poses.insert(poses.end(), there.begin(), there.end());
    poses.insert(poses.end(), there.rbegin(), there.rend());
  }
  return poses;
}

// A second of standing in which the left leg rises forward to `height_rad` and comes down.
std::vector<body::Pose> Kick(float height_rad) {
  std::vector<body::Pose> poses(120);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const float lift = std::sin(kPi * static_cast<float>(i) / 119.0F);
    poses[i].rotations[body::kLeftUpperLeg] = body::Exp(body::Vec3(-height_rad * lift, 0, 0));
  }
  return poses;
}

TEST(Acts, APunchThatIsOnlyLateIsKept) {
  const auto input = Punch(0, 0, 0);
  for (const float late_s : {0.0F, 0.1F}) {
    const ActsKept kept = MeasureActs(input, Punch(0, 0, late_s), kActsRate_hz);
    EXPECT_EQ(kept.reach.count, 1);
    EXPECT_NEAR(kept.reach.value(), 1, 0.01);
    EXPECT_NEAR(kept.direction_deg.value(), 0, 1);
    EXPECT_EQ(kept.kick_height.count, 0) << "nobody kicked";
  }
}

TEST(Acts, AnElbowThatStaysBentShortensTheReach) {
  const ActsKept kept = MeasureActs(Punch(0, 0, 0), Punch(0, 2.0F, 0), kActsRate_hz);
  EXPECT_LT(kept.reach.value(), 0.6);
  EXPECT_GT(kept.reach.value(), 0.1);
}

TEST(Acts, APunchToTheSideIsOffByItsAngle) {
  const ActsKept kept = MeasureActs(Punch(0, 0, 0), Punch(0.7F, 0, 0), kActsRate_hz);
  EXPECT_NEAR(kept.direction_deg.value(), 0.7F * 180 / kPi, 3);
  EXPECT_NEAR(kept.reach.value(), std::cos(0.7F), 0.05);
}

// The raised hand ends nearer to its shoulder than where it hung, and soon after the clip begins.
TEST(Acts, ARaisedHandIsComparedWhereItIsHighest) {
  const auto raise = [](float forearm_rad) {
    std::vector<body::Pose> poses(240);
    for (std::size_t i = 0; i < poses.size(); ++i) {
      const float done =
          std::clamp(static_cast<float>(i) / static_cast<float>(0.3 * kActsRate_hz), 0.0F, 1.0F);
      const body::Quat down = body::Exp(body::Vec3(0, 0, -kPi / 2));
      poses[i].rotations[body::kLeftUpperArm] = down.slerp(done, body::Quat::Identity());
      poses[i].rotations[body::kLeftLowerArm] = body::Exp(body::Vec3(0, 0, done * forearm_rad));
    }
    return poses;
  };
  const ActsKept same = MeasureActs(raise(2.0F), raise(2.0F), kActsRate_hz);
  EXPECT_NEAR(same.reach.value(), 1, 0.01);
  EXPECT_NEAR(same.direction_deg.value(), 0, 1);
  const std::vector<body::Pose> hanging(240, raise(2.0F).front());
  EXPECT_LT(MeasureActs(raise(2.0F), hanging, kActsRate_hz).reach.value(), 0.5);
}

TEST(Acts, AKickIsComparedByItsHeight) {
  const auto input = Kick(kPi / 2);
  EXPECT_NEAR(MeasureActs(input, input, kActsRate_hz).kick_height.value(), 1, 1e-6);
  const double half = MeasureActs(input, Kick(kPi / 4), kActsRate_hz).kick_height.value();
  EXPECT_LT(half, 0.5);
  EXPECT_GT(half, 0.2);
  const auto step = Kick(0.3F);
  EXPECT_EQ(MeasureActs(step, step, kActsRate_hz).kick_height.count, 0) << "a step is no kick";
}

TEST(Acts, HandsThatSwingInAWalkMakeNoGesture) {
  auto input = Punch(0, 0, 0);
  for (std::size_t i = 0; i < input.size(); ++i) {
    input[i].hips_position_m.z() +=
        1.2F * static_cast<float>(static_cast<double>(i) / kActsRate_hz);
  }
  EXPECT_EQ(MeasureActs(input, input, kActsRate_hz).reach.count, 0);
  const std::vector<body::Pose> still(240);
  EXPECT_EQ(MeasureActs(still, still, kActsRate_hz).reach.count, 0);
}

TEST(EveryAct, AnUnchangedClipKeepsEveryAct) {
  for (const auto& input : {Punch(0, 0, 0), TwoPunches(0.5F), Kick(kPi / 2)}) {
    const ActsKept kept = MeasureEveryAct(input, input, kActsRate_hz);
    EXPECT_GT(kept.reach.count + kept.kick_height.count, 0);
    EXPECT_NEAR(kept.least_reach, 1, 1e-5);
    EXPECT_NEAR(kept.worst_direction_deg, 0, 0.1);
    EXPECT_NEAR(kept.least_kick_height, 1, 1e-5);
  }
}

TEST(EveryAct, CountsWhereTheFastestGestureAloneWouldHideTheOther) {
  const ActsKept kept = MeasureEveryAct(TwoPunches(0), TwoPunches(0.7F), kActsRate_hz);
  EXPECT_EQ(kept.reach.count, 4) << "twice there and back";
  EXPECT_NEAR(kept.worst_direction_deg, 0.7F * 180 / kPi, 3);
  EXPECT_NEAR(kept.direction_deg.value(), 0.35F * 180 / kPi, 3);
  EXPECT_NEAR(kept.least_reach, std::cos(0.7F), 0.05);
}

TEST(EveryAct, APunchCountsInAStepButASwingDoesNot) {
  auto punch = Punch(0, 0, 0);
  std::vector<body::Pose> swing(240);
  for (std::size_t i = 0; i < punch.size(); ++i) {
    const auto time_s = static_cast<float>(static_cast<double>(i) / kActsRate_hz);
    swing[i].rotations[body::kLeftUpperArm] =
        body::Exp(body::Vec3(0.6F * std::sin(2 * kPi * time_s), 0, 0)) *
        body::Exp(body::Vec3(0, 0, -kPi / 2));
    punch[i].hips_position_m.z() += 0.7F * time_s;
    swing[i].hips_position_m.z() += 1.2F * time_s;
  }
  EXPECT_EQ(MeasureEveryAct(punch, punch, kActsRate_hz).reach.count, 1);
  EXPECT_EQ(MeasureEveryAct(swing, swing, kActsRate_hz).reach.count, 0);
}

TEST(EveryAct, AddKeepsTheWorstOfAll) {
  ActsKept all;
  all.Add(MeasureEveryAct(TwoPunches(0), TwoPunches(0.7F), kActsRate_hz));
  all.Add(MeasureEveryAct(Kick(kPi / 2), Kick(kPi / 3), kActsRate_hz));
  EXPECT_NEAR(all.worst_direction_deg, 0.7F * 180 / kPi, 3);
  EXPECT_LT(all.least_kick_height, 0.7);
  EXPECT_EQ(all.kick_height.count, 1);
}

}  // namespace
}  // namespace styled::judge
