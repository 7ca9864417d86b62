#include "model/idle/idle.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace styled::idle {
namespace {

using body::Pose;
using body::Quat;
using body::Vec3;
using body::WorldPose;

constexpr double kStep_s = 1.0 / 60;

// With arms that hang, and knees that are a little bent as everybody's are.
Pose Standing() {
  Pose pose;
  const auto turn = [&](int joint, const Vec3& turn_rad) {
    pose.rotations[static_cast<std::size_t>(joint)] = body::Exp(turn_rad);
  };
  turn(body::kLeftUpperArm, {0, 0, -1.2F});
  turn(body::kRightUpperArm, {0, 0, 1.2F});
  for (const int upper : {int{body::kLeftUpperLeg}, int{body::kRightUpperLeg}}) {
    turn(upper, {-0.06F, 0, 0});
    turn(upper + 1, {0.12F, 0, 0});
    turn(upper + 2, {-0.06F, 0, 0});
  }
  turn(body::kHead, {0.1F, 0.4F, -0.05F});
  return pose;
}

Pose Seated() {
  Pose pose = Standing();
  pose.hips_position_m.y() = 0.5F;
  for (const int upper : {int{body::kLeftUpperLeg}, int{body::kRightUpperLeg}}) {
    pose.rotations[static_cast<std::size_t>(upper)] = body::Exp({-1.5F, 0, 0});
    pose.rotations[static_cast<std::size_t>(upper) + 1] = body::Exp({1.5F, 0, 0});
  }
  return pose;
}

WorldPose World(const Pose& pose) {
  WorldPose world;
  body::ForwardKinematics(pose, world);
  return world;
}

float Apart_rad(const Quat& a, const Quat& b) { return body::Log(a.conjugate() * b).norm(); }

TEST(Idle, FeetAndHeadStayAndTheChestBreathes) {
  const Idle idle(7);
  const Pose still = Standing();
  const WorldPose before = World(still);
  float foot_m = 0, foot_rad = 0, head_rad = 0, lowest_m = 10, highest_m = -10, aside_m = 0;
  for (double t = 0; t < 60; t += kStep_s) {
    Pose pose = still;
    idle.Add(t, {}, pose);
    const WorldPose now = World(pose);
    for (const int foot : {int{body::kLeftFoot}, int{body::kRightToes}}) {
      const auto at = static_cast<std::size_t>(foot);
      foot_m = std::max(foot_m, (now.positions_m[at] - before.positions_m[at]).norm());
      foot_rad = std::max(foot_rad, Apart_rad(now.rotations[at], before.rotations[at]));
    }
    head_rad =
        std::max(head_rad, Apart_rad(now.rotations[body::kHead], before.rotations[body::kHead]));
    const float shoulder_m =
        now.positions_m[body::kLeftUpperArm].y() - now.positions_m[body::kChest].y();
    lowest_m = std::min(lowest_m, shoulder_m);
    highest_m = std::max(highest_m, shoulder_m);
    aside_m = std::max(aside_m, std::abs(pose.hips_position_m.x()));
  }
  EXPECT_LT(foot_m, 2e-4F);
  EXPECT_LT(foot_rad, 1e-3F);
  EXPECT_LT(head_rad, 1e-3F) << "a phone measures the head";
  EXPECT_GT(highest_m - lowest_m, 0.003F) << "seen from a metre";
  EXPECT_LT(highest_m - lowest_m, 0.012F);
  EXPECT_GT(aside_m, 0.006F);
  EXPECT_LT(aside_m, 0.02F);
}

TEST(Idle, BreathsPerMinuteAreThoseOfAPersonAtRest) {
  const Idle idle(3);
  int breaths = 0;
  float last = 0, last_change = 0;
  for (double t = 0; t < 120; t += kStep_s) {
    Pose pose = Standing();
    idle.Add(t, {}, pose);
    const float chest = body::Log(pose.rotations[body::kChest]).x();
    const float change = chest - last;
    if (last_change > 0 && change <= 0) ++breaths;
    last = chest;
    last_change = change;
  }
  EXPECT_GE(breaths, 2 * 12);
  EXPECT_LE(breaths, 2 * 20);
}

TEST(Idle, ASeatedBodyBreathesAndDoesNotSlide) {
  const Idle idle(7);
  const Pose still = Seated();
  float chest_rad = 0;
  for (double t = 0; t < 30; t += kStep_s) {
    Pose pose = still;
    idle.Add(t, {}, pose);
    ASSERT_EQ(pose.hips_position_m, still.hips_position_m);
    ASSERT_EQ(pose.rotations[body::kLeftUpperLeg].coeffs(),
              still.rotations[body::kLeftUpperLeg].coeffs());
    chest_rad = std::max(chest_rad, Apart_rad(pose.rotations[body::kChest], Quat::Identity()));
  }
  EXPECT_GT(chest_rad, 0.01F);
}

// No frame of 60 Hz shows a step, of the smallest and the largest amount; nothing leaves unit
// length.
TEST(Idle, MovesWithoutJumps) {
  for (const float amount : {0.1F, 1.5F}) {
    const Idle idle(11);
    Pose last = Standing();
    idle.Add(0, {amount, 1}, last);
    for (double t = kStep_s; t < 60; t += kStep_s) {
      Pose pose = Standing();
      idle.Add(t, {amount, 1}, pose);
      EXPECT_LT((pose.hips_position_m - last.hips_position_m).norm(), 4e-4F * amount) << t;
      for (std::size_t j = 0; j < body::kJointCount; ++j) {
        ASSERT_NEAR(pose.rotations[j].norm(), 1, 1e-5F);
        ASSERT_LT(Apart_rad(pose.rotations[j], last.rotations[j]), 3e-3F * amount + 1e-3F)
            << "joint " << j << " at " << t;
      }
      last = pose;
    }
  }
}

TEST(Idle, TwoPerformersDoNotMoveTogether) {
  const Idle one(1), other(2);
  double product = 0, squares = 0;
  for (double t = 0; t < 600; t += 0.1) {
    Pose a = Standing(), b = Standing();
    one.Add(t, {}, a);
    other.Add(t, {}, b);
    product +=
        static_cast<double>(a.hips_position_m.x()) * static_cast<double>(b.hips_position_m.x());
    squares +=
        static_cast<double>(a.hips_position_m.x()) * static_cast<double>(a.hips_position_m.x());
  }
  EXPECT_LT(std::abs(product / squares), 0.5);
}

TEST(Idle, EyesBlinkAsOftenAsPeoplesDo) {
  const Idle idle(5);
  int blinks = 0;
  double open_since = 0, longest_s = 0, closed_s = 0;
  bool closed = false;
  for (double t = 0; t < 600; t += kStep_s) {
    const float lids = idle.Blink(t);
    ASSERT_GE(lids, 0);
    ASSERT_LE(lids, 1);
    closed_s += lids > 0.5F ? kStep_s : 0;
    if (lids > 0.5F && !closed) {
      ++blinks;
      longest_s = std::max(longest_s, t - open_since);
    }
    if (closed && lids <= 0.5F) open_since = t;
    closed = lids > 0.5F;
  }
  EXPECT_GE(blinks, 10 * 12);
  EXPECT_LE(blinks, 10 * 20);
  EXPECT_LT(longest_s, 8);
  EXPECT_LT(closed_s / blinks, 0.3);
  EXPECT_EQ(idle.Blink(123.4), Idle(5).Blink(123.4)) << "of time and seed alone";
}

}  // namespace
}  // namespace styled::idle
