#include "model/net/phase/style.h"

#include <gtest/gtest.h>

#include <limits>

#include "tests/unit/net/phase/made.h"

namespace styled::phase {
namespace {

float Apart_rad(const gait::Rotations& a, const gait::Rotations& b) {
  return gait::VectorsAbout(a, b).cwiseAbs().maxCoeff();
}
float Apart_rad(const gait::Curve& a, const gait::Curve& b) {
  float most = 0;
  for (float phase = 0; phase < 6.2F; phase += 0.3F) {
    const gait::Terms terms = gait::TermsAt(phase);
    most = std::max(most, Apart_rad(a.At(terms), b.At(terms)));
  }
  return most;
}

TEST(PhaseStyle, ACodeIsTheStyle) {
  Style style = TestNeutral();
  style.sliders[3] = 4;
  style.difference = true;
  const net::StyleCode code = ToCode(style);
  ASSERT_TRUE(IsCode(code));
  const Style read = FromCode(code);
  EXPECT_TRUE(read.difference);
  EXPECT_LT(Apart_rad(read.walk->curve, style.walk->curve), 1e-4F);
  EXPECT_LT(Apart_rad(read.run->curve, style.run->curve), 1e-4F);
  EXPECT_LT(Apart_rad(*read.standing, *style.standing), 1e-4F);
  EXPECT_EQ(read.walk->speed_mps, style.walk->speed_mps);
  EXPECT_EQ(read.sliders, style.sliders);
}

TEST(PhaseStyle, AStyleOfNothingHasNoGait) {
  const Style read = FromCode(ToCode(Style()));
  EXPECT_FALSE(read.has_gait());
  EXPECT_FALSE(read.standing);
}

TEST(PhaseStyle, OtherNumbersAreNoCode) {
  net::StyleCode code = ToCode(TestNeutral());
  EXPECT_FALSE(IsCode({}));
  net::StyleCode longer = code;
  longer.push_back(0);
  EXPECT_FALSE(IsCode(longer));
  net::StyleCode flag = code;
  flag[1] = 0.5F;
  EXPECT_FALSE(IsCode(flag));
  // Finite numbers that would overflow in a step: of a gait, a posture, a slider, a speed.
  for (const std::size_t at :
       {std::size_t{80}, std::size_t{600}, std::size_t{1100}, kCodeSize - 20, std::size_t{513}}) {
    net::StyleCode huge = code;
    huge[at] = 1e30F;
    EXPECT_FALSE(IsCode(huge)) << at;
  }
  code[100] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_FALSE(IsCode(code));
}

TEST(PhaseStyle, AMeanOfTwoClipsHasTheGaitsOfBoth) {
  const Weighted both[] = {{StyleOfScript("walk:60", 8), 8}, {StyleOfScript("run:60", 8), 8}};
  const Style mean = MeanOf(both);
  ASSERT_TRUE(mean.walk && mean.run);
  EXPECT_LT(Apart_rad(mean.walk->curve, both[0].style.walk->curve), 1e-3F);
  EXPECT_LT(Apart_rad(mean.run->curve, both[1].style.run->curve), 1e-3F);
}

TEST(PhaseStyle, AMeanIsBetweenItsStylesByWeight) {
  const Style walk = StyleOfScript("walk:60", 8);
  const Style bent = StyleOf(gait::Analyse(StyledWalk(8), kRate_hz));
  const Weighted both[] = {{walk, 3}, {bent, 1}};
  const gait::Rotations mean = MeanOf(both).walk->curve.At(gait::TermsAt(1));
  const auto elbow = [](const gait::Rotations& a, const gait::Rotations& b) {
    return body::Log(a[body::kLeftLowerArm].conjugate() * b[body::kLeftLowerArm]).y();
  };
  EXPECT_NEAR(elbow(walk.walk->curve.At(gait::TermsAt(1)), mean), -kElbow_rad / 4, 0.02);
}

TEST(PhaseStyle, ADifferenceIsWhatWasAdded) {
  const Style walk = StyleOfScript("walk:60", 10);
  const Style bent = StyleOf(gait::Analyse(StyledWalk(10), kRate_hz));
  const Style difference = DifferenceOf(bent, walk);
  ASSERT_TRUE(difference.difference && difference.walk);
  for (float phase = 0; phase < 6.2F; phase += 0.5F) {
    const gait::Vectors turn = difference.walk->curve.VectorsAt(gait::TermsAt(phase));
    EXPECT_NEAR(gait::VectorOf(turn, body::kLeftLowerArm).y(), -kElbow_rad, 0.03);
    EXPECT_NEAR(gait::VectorOf(turn, body::kLeftUpperArm).z(), kLift_rad * std::cos(phase), 0.03);
    EXPECT_LT(gait::VectorOf(turn, body::kHead).norm(), 0.03);
  }
}

TEST(PhaseStyle, WhatIsTurnedByADifferenceIsTurnedBack) {
  const Style walk = StyleOfScript("walk:60", 10);
  const Style bent = StyleOf(gait::Analyse(StyledWalk(10), kRate_hz));
  const Style difference = DifferenceOf(bent, walk);
  const Style there = WithDifference(walk, difference);
  EXPECT_LT(Apart_rad(there.walk->curve, bent.walk->curve), 0.03F);
  const Style back = WithoutDifference(there, difference);
  EXPECT_LT(Apart_rad(back.walk->curve, walk.walk->curve), 0.03F);
  EXPECT_LT(Apart_rad(back.posture, walk.posture), 0.03F);
}

}  // namespace
}  // namespace styled::phase
