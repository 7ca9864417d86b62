#include "model/stylist/visible.h"

#include <gtest/gtest.h>

#include <cmath>

namespace styled::stylist {
namespace {

TEST(MovedBy, IsTheMeanOfBothSidesBesideTheWayOverTheFloor) {
  body::Pose input, output;
  output.hips_position_m += body::Vec3(3, 0, -4);
  output.rotations[body::kLeftUpperLeg] = body::Exp(body::Vec3(0.1F, 0, 0));
  const Moved moved_m = MovedBy(input, output);
  const float thigh_m = body::Offset(body::kLeftLowerLeg).norm();
  EXPECT_NEAR(moved_m[3], thigh_m * std::sin(0.05F), 1e-4) << "of one knee twice half the angle";
  EXPECT_GT(moved_m[4], moved_m[3]) << "the foot is below it";
  for (const std::size_t above : {0U, 1U, 2U}) EXPECT_NEAR(moved_m[above], 0, 1e-5);
}

TEST(MovedBy, ABodyThatIsLoweredIsMoved) {
  body::Pose input, output;
  output.hips_position_m.y() -= 0.05F;
  for (const float m : MovedBy(input, output)) EXPECT_NEAR(m, 0.05F, 1e-5);
}

TEST(IsUnseen, OneLimbThatMovesIsToBeSeen) {
  EXPECT_TRUE(IsUnseen({}));
  EXPECT_TRUE(IsUnseen({0.014F, 0.014F, 0.014F, 0.014F, 0.014F}));
  for (std::size_t limb = 0; limb < kVisibleLimbs.size(); ++limb) {
    Moved moved_m{};
    moved_m[limb] = 0.016F;
    EXPECT_FALSE(IsUnseen(moved_m)) << kVisibleLimbs[limb];
  }
}

TEST(RequestsVisibleStyle, OfTheStylesButNeutralOnTheWholeBody) {
  Settings settings;
  EXPECT_FALSE(RequestsVisibleStyle(settings)) << "of none";
  settings.mix[0] = {1, 0.5F};
  EXPECT_TRUE(RequestsVisibleStyle(settings));
  settings.strength = 0.9F;
  EXPECT_FALSE(RequestsVisibleStyle(settings));
  settings.mix[1] = {2, 0.25F};
  EXPECT_TRUE(RequestsVisibleStyle(settings)) << "together";
  settings.parts = body::kAllParts ^ body::Bit(body::Part::kHead);
  EXPECT_FALSE(RequestsVisibleStyle(settings)) << "of some parts";
  settings.parts = body::kAllParts;
  settings.mix = {};
  settings.mix[0] = {0, 1};
  EXPECT_FALSE(RequestsVisibleStyle(settings)) << "neutral is no style";
}

}  // namespace
}  // namespace styled::stylist
