#include "model/net/phase/space.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/unit/net/phase/made.h"

namespace styled::phase {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;

const net::StyleSpace& TestSpace() { return *TestStylizer()->space(); }

net::StyleCode CodeOf(const std::vector<body::Pose>& example) {
  net::StyleRequest request;
  request.sources = {{.style = -1, .seed = {}, .reference = example, .weight = 1}};
  return TestSpace().MakeCode(request);
}

TEST(PhaseSpace, AWalkIsDescribedAsItIs) {
  const net::Findings findings = TestSpace().Describe(CodeOf(StyledWalk(8)));
  EXPECT_THAT(findings.found, Contains(HasSubstr("walk: ")));
  EXPECT_THAT(findings.found, Contains(HasSubstr("steps a minute")));
  EXPECT_THAT(findings.weak, IsEmpty());
}

TEST(PhaseSpace, AShortWalkSaysThatItIsShort) {
  std::vector<body::Pose> walk = StyledWalk(6);
  walk.erase(walk.begin(), walk.begin() + 3 * 30 + 15);
  const net::Findings findings = TestSpace().Describe(CodeOf(walk));
  EXPECT_THAT(findings.weak, Contains(HasSubstr("show 3 s or more")));
}

TEST(PhaseSpace, OneSecondIsAPostureAndSaysSo) {
  const std::vector<body::Pose> wave = gait::Perform("wave-left:60", 1, kRate_hz);
  const net::StyleCode code = CodeOf(wave);
  EXPECT_EQ(TestSpace().Suits(code), net::Suitable::kNo);
  EXPECT_THAT(TestSpace().Describe(code).weak, Contains(HasSubstr("a posture only")));
}

TEST(PhaseSpace, APoseIsNoMotion) {
  const net::StyleCode code = CodeOf(std::vector<body::Pose>(60));
  EXPECT_EQ(TestSpace().Suits(code), net::Suitable::kAlone);
  EXPECT_THAT(TestSpace().Describe(code).found, Contains("a pose"));
}

TEST(PhaseSpace, AStyleIsNearestToItself) {
  EXPECT_EQ(TestSpace().Nearest(CodeOf(StyledWalk(10))).style, 1);
  const net::NearestStyle neutral = TestSpace().Nearest(CodeOf(gait::Perform("walk:60", 10, 30)));
  EXPECT_EQ(neutral.style, 0);
  EXPECT_LT(neutral.distance, 0.3F);
}

TEST(PhaseSpace, StrengthIsAShareOfTheWayFromNeutral) {
  const std::vector<body::Pose> example = StyledWalk(10);
  net::StyleRequest request;
  request.sources = {{.style = -1, .seed = {}, .reference = example, .weight = 1}};
  request.strength = 0.5F;
  const Style half = FromCode(TestSpace().MakeCode(request));
  const Style neutral = TestNeutral();
  const gait::Terms terms = gait::TermsAt(1);
  const gait::Vectors turn =
      gait::VectorsAbout(neutral.walk->curve.At(terms), half.walk->curve.At(terms));
  EXPECT_NEAR(gait::VectorOf(turn, body::kRightLowerArm).y(), kElbow_rad / 2, 0.04);
}

TEST(PhaseSpace, CodesAreIndependentOfTheWeights) {
  const net::StyleCode code = CodeOf(StyledWalk(5));
  EXPECT_EQ(TestSpace().Portable(code), code);
}

// Of a style that was made beside another network, which is gone now.
TEST(PhaseSpace, OfAPairsCodeItsOwnPartIsTaken) {
  const net::StyleCode code = CodeOf(StyledWalk(5));
  net::StyleCode pair = code, other(300, 0.5F);
  pair.insert(pair.end(), other.begin(), other.end());
  EXPECT_EQ(TestSpace().Portable(pair), code);
  EXPECT_THAT(TestSpace().Portable(other), IsEmpty());
  other.resize(2 * kCodeSize, 0.5F);
  EXPECT_THAT(TestSpace().Portable(other), IsEmpty());
}

TEST(PhaseSpace, AMeanKeepsWhatOnlyOneOfThemHas) {
  const net::StyleCode walk = CodeOf(StyledWalk(8)), run = CodeOf(gait::Perform("run:60", 8, 30));
  const Style both = FromCode(TestSpace().Mean(walk, run, 0.5F));
  EXPECT_TRUE(both.walk && both.run);
  const net::StyleCode difference = TestSpace().Difference(walk, walk);
  EXPECT_THAT(TestSpace().Mean(walk, difference, 0.5F), IsEmpty());
}

TEST(PhaseSpace, ADesignTellsItsSliders) {
  const net::StyleCode code = TestSpace().Design({}, {{"stoop", 20}, {"energy", 0.5F}}).value();
  const net::SliderValues values = TestSpace().SlidersOf(code);
  ASSERT_EQ(values.size(), 2U);
  EXPECT_EQ(values[0].name, "stoop");
  EXPECT_FLOAT_EQ(values[1].value, 0.5F);
  const net::Findings findings = TestSpace().Describe(code);
  EXPECT_THAT(findings.found, testing::ElementsAre("by hand: stoop 20, energy 0.5"));
  EXPECT_THAT(findings.weak, IsEmpty());
  EXPECT_FALSE(TestSpace().Design({}, {{"stop", 1}}).ok());
}

}  // namespace
}  // namespace styled::phase
