#include "model/stylist/knees.h"

#include <gtest/gtest.h>

namespace styled::stylist {
namespace {

using body::Pose;
using body::Vec3;

constexpr std::size_t kKnee = body::kLeftLowerLeg;

body::Quat Bent(float bend_rad, float aside_rad = 0) {
  return body::Exp(Vec3(0, 0, aside_rad)) * body::Exp(Vec3(bend_rad, 0, 0));
}

// The published bend of a knee of `own` that a style bends to `wanted`.
float Kept_rad(float own, float wanted) {
  Pose in, styled;
  in.rotations[kKnee] = Bent(own);
  styled.rotations[kKnee] = Bent(wanted);
  KeepKnees(in, 1, styled);
  const Vec3 turn = body::Log(styled.rotations[kKnee]);
  EXPECT_NEAR(turn.y(), 0, 1e-5F);
  EXPECT_NEAR(turn.z(), 0, 1e-5F);
  return turn.x();
}

TEST(Knees, KneesBentLikeThePerformersStayUnchanged) {
  for (const float bend : {-0.3F, -0.05F, 0.0F, 0.02F, 0.4F, 2.2F}) {
    Pose in, styled;
    in.rotations[kKnee] = Bent(bend, 0.2F);
    styled = in;
    KeepKnees(in, 1, styled);
    EXPECT_LT(in.rotations[kKnee].angularDistance(styled.rotations[kKnee]), 1e-6F) << bend;
  }
}

TEST(Knees, DoNotBendBackwards) {
  for (const float own : {0.05F, 0.2F, 0.6F, 1.2F}) {
    for (const float wanted : {0.0F, -0.2F, -0.5F, -0.9F}) {
      EXPECT_GT(Kept_rad(own, wanted), -0.2F) << own << " styled to " << wanted;
    }
  }
}

TEST(Knees, KneesBentBackwardsByThePerformerBendNoFurther) {
  EXPECT_GT(Kept_rad(-0.2F, -0.6F), -0.4F);
  EXPECT_LT(Kept_rad(-0.2F, -0.6F), -0.2F);
}

TEST(Knees, WellBentAreAsStyled) {
  EXPECT_NEAR(Kept_rad(0.6F, 1.4F), 1.4F, 0.03F);
  EXPECT_NEAR(Kept_rad(1.4F, 0.6F), 0.6F, 0.04F);
}

TEST(Knees, GoOnSmoothlyAndInOrder) {
  float last = Kept_rad(0.3F, -1.0F), last_step = 0;
  for (int i = 1; i <= 200; ++i) {
    const float now = Kept_rad(0.3F, -1.0F + 0.01F * static_cast<float>(i));
    const float step = now - last;
    EXPECT_GT(step, -1e-5F);
    EXPECT_LT(step, 0.0101F);
    if (i > 1) EXPECT_LT(std::abs(step - last_step), 3e-4F) << i;
    last = now;
    last_step = step;
  }
}

TEST(Knees, BentRoundPiDoNotPop) {
  EXPECT_NEAR(Kept_rad(0.3F, -3.1414F), -3.1414F, 1e-3F);
  EXPECT_NEAR(Kept_rad(0.3F, 3.1414F), 3.1414F, 0.02F);
}

TEST(Knees, OnlyKneesAreTouched) {
  Pose in, styled;
  for (auto& rotation : styled.rotations) rotation = Bent(-0.5F);
  KeepKnees(in, 1, styled);
  for (int joint = 0; joint < body::kJointCount; ++joint) {
    const bool knee = joint == body::kLeftLowerLeg || joint == body::kRightLowerLeg;
    const auto j = static_cast<std::size_t>(joint);
    EXPECT_EQ(styled.rotations[j].coeffs() != Bent(-0.5F).coeffs(), knee) << joint;
  }
}

}  // namespace
}  // namespace styled::stylist
