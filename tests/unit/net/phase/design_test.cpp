#include "model/net/phase/design.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/unit/net/phase/made.h"

namespace styled::phase {
namespace {

using testing::HasSubstr;

Style Nobody() {
  Style none;
  none.difference = true;
  none.walk.emplace();
  none.standing = none.posture;
  return none;
}

body::Vec3 Standing(const Style& style, body::Joint joint) {
  return body::Log((*style.standing)[joint]);
}

TEST(PhaseDesign, EachSliderAloneChangesTheStyleAndZeroTakesItBack) {
  for (std::size_t i = 0; i < Sliders().size(); ++i) {
    const net::Slider& slider = Sliders()[i];
    const net::SliderValue most[] = {{slider.name, slider.most}};
    const Result<Style> changed = WithSliders(Nobody(), most);
    ASSERT_TRUE(changed.ok()) << changed.status().message();
    EXPECT_NE(ToCode(changed.value()), ToCode(Nobody())) << slider.name;
    EXPECT_FLOAT_EQ(changed.value().sliders[i], slider.most - slider.usual);
    const net::SliderValue usual[] = {{slider.name, slider.usual}};
    const Result<Style> back = WithSliders(changed.value(), usual);
    ASSERT_TRUE(back.ok());
    EXPECT_EQ(back.value().sliders, Nobody().sliders) << slider.name;
    EXPECT_LT(back.value().walk->curve.series.cwiseAbs().maxCoeff(), 2e-3F) << slider.name;
  }
}

TEST(PhaseDesign, AStoopBendsTheBackForwardAndKeepsTheHeadUp) {
  const net::SliderValue stoop[] = {{"stoop", 40}};
  const Style style = WithSliders(Nobody(), stoop).value();
  EXPECT_GT(Standing(style, body::kSpine).x(), 0.2);
  EXPECT_LT(Standing(style, body::kHead).x(), -0.2);
}

TEST(PhaseDesign, LeftAndRightMirrorEachOther) {
  const net::SliderValue values[] = {{"elbows", 40},    {"arms_out", 20}, {"knee_lift", 30},
                                     {"arm_swing", 20}, {"sway", 8},      {"twist", 8}};
  const Style style = WithSliders(Nobody(), values).value();
  body::Pose here, there;
  here.rotations = style.walk->curve.At(gait::TermsAt(1));
  there.rotations = style.walk->curve.At(gait::TermsAt(1 + gait::tuning::kTurn_rad / 2));
  body::Mirror(there, there);
  EXPECT_LT(gait::VectorsAbout(here.rotations, there.rotations).cwiseAbs().maxCoeff(), 1e-4F);
}

TEST(PhaseDesign, AKneeIsLiftedInItsSwingOnly) {
  const net::SliderValue lift[] = {{"knee_lift", 40}};
  const Style style = WithSliders(Nobody(), lift).value();
  const auto knee = [&style](float phase) {
    return gait::VectorOf(style.walk->curve.VectorsAt(gait::TermsAt(phase)), body::kLeftLowerLeg)
        .x();
  };
  EXPECT_GT(knee(-gait::tuning::kTurn_rad / 4), 0.8);
  EXPECT_NEAR(knee(gait::tuning::kTurn_rad / 4), 0, 0.02);
  EXPECT_NEAR(Standing(style, body::kLeftLowerLeg).norm(), 0, 1e-5);
}

TEST(PhaseDesign, SlidersAddToAMeasuredStyle) {
  const Style bent = StyleOf(gait::Analyse(StyledWalk(8), kRate_hz));
  const net::SliderValue elbows[] = {{"elbows", 20}};
  const Style more = WithSliders(bent, elbows).value();
  EXPECT_FALSE(more.difference);
  const gait::Terms terms = gait::TermsAt(2);
  const gait::Vectors turn =
      gait::VectorsAbout(bent.walk->curve.At(terms), more.walk->curve.At(terms));
  EXPECT_NEAR(gait::VectorOf(turn, body::kLeftLowerArm).y(), -20 * gait::kDegree, 0.01);
}

TEST(PhaseDesign, WrongSlidersAreNamedWithWhatWasExpected) {
  const auto error = [](const char* name, float value) {
    const net::SliderValue one[] = {{name, value}};
    return WithSliders(Nobody(), one).status().message();
  };
  EXPECT_THAT(error("stop", 3), HasSubstr("expected one of stoop"));
  EXPECT_THAT(error("stoop", 300), HasSubstr("stoop: found 300, expected -30 to 60 degrees"));
  EXPECT_THAT(error("energy", std::numeric_limits<float>::quiet_NaN()), HasSubstr("energy: found"));
  EXPECT_EQ(error("Arm-Swing", 10), "");
}

TEST(PhaseDesign, EveryPresetIsWithinTheSliders) {
  for (const net::Preset& preset : Presets()) {
    EXPECT_TRUE(WithSliders(Nobody(), preset.values).ok()) << preset.name;
  }
}

}  // namespace
}  // namespace styled::phase
