#include "model/feet/contacts.h"

#include <gtest/gtest.h>

#include "tests/unit/feet/walker.h"

namespace styled::feet {
namespace {

TEST(FloorTest, BeginsWhereTheFirstFootIs) {
  Floor floor;
  EXPECT_EQ(floor.Follow(0.3F, 2, 0), 0.3F);
}

TEST(FloorTest, FallsSoonAndRisesSlowly) {
  Floor floor;
  (void)floor.Follow(0, 0, 0);
  for (int i = 0; i < 60; ++i) (void)floor.Follow(-0.1F, 0, 1 / 120.0F);
  EXPECT_NEAR(floor.height_m(), -0.1F, 0.01F) << "half a second on a lower floor";
  for (int i = 0; i < 60; ++i) (void)floor.Follow(0, 0, 1 / 120.0F);
  EXPECT_LT(floor.height_m(), -0.07F) << "half a second on a higher one";
  for (int i = 0; i < 1200; ++i) (void)floor.Follow(0, 0, 1 / 120.0F);
  EXPECT_NEAR(floor.height_m(), 0, 0.005F);
}

TEST(FloorTest, NeitherAFootInTheAirNorAWildFrameIsTheFloor) {
  Floor floor;
  (void)floor.Follow(0, 0, 0);
  for (int i = 0; i < 1200; ++i) (void)floor.Follow(0.4F, 2, 1 / 120.0F);
  EXPECT_EQ(floor.height_m(), 0);
  (void)floor.Follow(-30, 0, 1 / 120.0F);
  EXPECT_GT(floor.height_m(), -0.006F);
}

TEST(ContactsTest, FollowAWalkersFeetAtAnyRate) {
  const rig::Binding binding = HumanoidBinding();
  const Legs legs(binding);
  for (const double rate_hz : {24.0, 60.0, 120.0, 240.0}) {
    Contacts contacts;
    std::vector<Placed> placed(legs.joints().size());
    int wrong = 0, frames = 0;
    for (int i = 0; i < 8 * rate_hz; ++i) {
      const double time_s = i / rate_hz;
      const rig::RigPose pose = Walker{}.At(time_s);
      legs.Place({pose.translations, pose.rotations}, placed);
      contacts.Process(static_cast<float>(i == 0 ? 0 : 1 / rate_hz), legs, placed, {});
      EXPECT_NEAR(contacts.floor_m(), 0.02F, 0.012F);
      for (int side = 0; side < kLegs; ++side) {
        // Near its changes a contact may be either; elsewhere it must be right.
        const double phase = Walker{}.Phase(time_s, side);
        if (Walker::kStance - 0.06 < phase && phase < Walker::kStance + 0.12) continue;
        if (phase < 0.08 || phase > 0.92) continue;
        ++frames;
        const bool planted = (contacts.bits() >> side & 1U) != 0;
        wrong += planted != (phase < Walker::kStance);
      }
    }
    EXPECT_LT(wrong, 0.01 * frames) << rate_hz;
  }
}

}  // namespace
}  // namespace styled::feet
