#include "model/net/phase/dynamics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace styled::phase {
namespace {

constexpr float kDt_s = 1.0F / 30;

// The left upper arm swings by a sine of 20 degrees and 1 Hz.
gait::Rotations Swing(int frame) {
  gait::Rotations pose;
  pose.fill(body::Quat::Identity());
  pose[body::kLeftUpperArm] =
      body::Exp({0, 0, 0.35F * std::sin(6.2831853F * static_cast<float>(frame) * kDt_s)});
  return pose;
}

// The angle of that arm as shown, frame after frame.
std::vector<float> Shown(const DynamicValues& values, int frames = 240) {
  Dynamics dynamics;
  std::vector<float> shown;
  for (int i = 0; i < frames; ++i) {
    gait::Vectors turns = gait::Vectors::Zero();
    const gait::Rotations own = Swing(i);
    dynamics.Follow(own, values, static_cast<double>(i) * static_cast<double>(kDt_s), kDt_s, turns);
    const body::Vec3 turn = gait::VectorOf(turns, body::kLeftUpperArm);
    shown.push_back(body::Log(own[body::kLeftUpperArm] * body::Exp(turn)).z());
  }
  return {shown.begin() + frames / 2, shown.end()};
}

float Size(const std::vector<float>& angles) {
  const auto [least, most] = std::minmax_element(angles.begin(), angles.end());
  return (*most - *least) / 2;
}

TEST(PhaseDynamics, NothingChangesNothing) {
  Dynamics dynamics;
  gait::Vectors turns = gait::Vectors::Zero();
  dynamics.Follow(Swing(3), {}, 0, kDt_s, turns);
  EXPECT_TRUE(turns.isZero(0));
  EXPECT_NEAR(Size(Shown({})), 0.35, 0.01);
}

TEST(PhaseDynamics, EnergyScalesTheMovementAboutItsMean) {
  EXPECT_NEAR(Size(Shown({.energy = -0.5F})), 0.175, 0.03);
  EXPECT_NEAR(Size(Shown({.energy = 0.5F})), 0.525, 0.03);
  EXPECT_LT(Size(Shown({.energy = -1})), 0.06);  // what the mean follows of the swing
}

TEST(PhaseDynamics, ALagIsADelay) {
  const std::vector<float> plain = Shown({}), late = Shown({.lag_s = 0.1F});
  // The shift with the largest product.
  double best = -1;
  int delay = 0;
  for (int shift = 0; shift < 15; ++shift) {
    double sum = 0;
    for (std::size_t i = 15; i < plain.size(); ++i) {
      sum += static_cast<double>(late[i]) *
             static_cast<double>(plain[i - static_cast<std::size_t>(shift)]);
    }
    if (sum > best) {
      best = sum;
      delay = shift;
    }
  }
  EXPECT_NEAR(static_cast<float>(delay) * kDt_s, 0.1, 0.05);
}

TEST(PhaseDynamics, AHeldArmStandsStillAndSnaps) {
  const std::vector<float> held = Shown({.hold_s = 0.4F});
  int still = 0;
  float fastest = 0;
  for (std::size_t i = 1; i < held.size(); ++i) {
    const float step = std::abs(held[i] - held[i - 1]);
    still += step < 0.01F ? 1 : 0;
    fastest = std::max(fastest, step);
  }
  EXPECT_GT(still, static_cast<int>(held.size()) / 3);
  EXPECT_GT(fastest, 0.15F);  // the swing itself moves by 0.07 a frame at most
}

TEST(PhaseDynamics, ShakingIsAFunctionOfTime) {
  const DynamicValues values{.tremor_rad = 0.05F, .wander_rad = 0.1F};
  Dynamics one, other;
  gait::Vectors here = gait::Vectors::Zero(), there = here;
  for (int i = 0; i < 40; ++i) one.Follow(Swing(i), values, i * 0.033, kDt_s, here);
  here.setZero();
  one.Follow(Swing(0), values, 5, kDt_s, here);
  other.Follow(Swing(0), values, 5, kDt_s, there);
  EXPECT_EQ(here, there);
  EXPECT_FALSE(here.isZero(1e-3F));
  EXPECT_TRUE(gait::VectorOf(here, body::kHips).isZero(0));
  EXPECT_TRUE(gait::VectorOf(here, body::kLeftUpperLeg).isZero(0));
}

TEST(PhaseDynamics, ACheckpointContinues) {
  const DynamicValues values{.energy = 0.3F, .lag_s = 0.1F};
  Dynamics one, other;
  gait::Vectors turns = gait::Vectors::Zero();
  for (int i = 0; i < 30; ++i) one.Follow(Swing(i), values, i * 0.033, kDt_s, turns);
  std::vector<std::byte> bytes(8192);
  Checkpoint write = Checkpoint::Into(bytes);
  one.Carry(write);
  ASSERT_TRUE(write.ok());
  Checkpoint read = Checkpoint::From(std::span(bytes).first(write.size()));
  other.Carry(read);
  ASSERT_TRUE(read.complete());
  gait::Vectors a = gait::Vectors::Zero(), b = a;
  one.Follow(Swing(31), values, 1.1, kDt_s, a);
  other.Follow(Swing(31), values, 1.1, kDt_s, b);
  EXPECT_EQ(a, b);
  std::fill(bytes.begin() + 1, bytes.end(), std::byte{0xFF});
  Checkpoint garbage = Checkpoint::From(std::span(bytes).first(write.size()));
  other.Carry(garbage);
  EXPECT_FALSE(garbage.ok());
}

}  // namespace
}  // namespace styled::phase
