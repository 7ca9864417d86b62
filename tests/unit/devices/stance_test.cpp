#include "model/devices/stance.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "tests/support/units.h"
#include "tests/unit/devices/mounted.h"

namespace styled::devices {
namespace {

using testing::Worn;

using support::kDegrees;
const std::vector<int> kAll{body::kHead,         body::kHips,         body::kChest,
                            body::kLeftHand,     body::kRightHand,    body::kLeftFoot,
                            body::kRightFoot,    body::kLeftUpperArm, body::kRightUpperArm,
                            body::kLeftUpperLeg, body::kRightUpperLeg};

// A strap is where it can be: not at the joint, but along the bone.
std::vector<Seen> Strapped(float heading, float scale, std::vector<int> parts) {
  const std::vector<Seen> exact = Worn(parts, 0, heading, scale).See(body::Pose());
  std::vector<Seen> seen = exact;
  for (Seen& device : seen) {
    const Quat room(Eigen::AngleAxisf(heading, Vec3::UnitY()));
    Vec3 off(0, 0, 0.05F);
    switch (device.part) {
      case body::kHead:
        off = {0, 0.06F, 0.08F};
        device.is_head = true;
        break;
      case body::kLeftUpperArm:
        off = {0.2F, 0, 0};
        break;
      case body::kRightUpperArm:
        off = {-0.2F, 0, 0};
        break;
      case body::kLeftUpperLeg:
      case body::kRightUpperLeg:
        off = {0, -0.38F, 0.05F};
        break;
      default:
        break;
    }
    device.at_joint = false;
    device.position_m += scale * (room * off);
  }
  return seen;
}

std::vector<int> Guessed(std::vector<Seen> seen, bool display) {
  for (Seen& device : seen) {
    device.part = Seen::kUnknown;
    device.is_head = device.is_head && display;
  }
  GuessParts(seen);
  std::vector<int> parts;
  for (const Seen& device : seen) parts.push_back(device.part);
  return parts;
}

TEST(GuessParts, FindsEveryPartOfAPerformerOfAnySizeWhoLooksAnywhereWithADisplay) {
  for (const float scale : {0.75F, 1.0F, 1.2F}) {
    for (float heading = -3; heading < 3.1F; heading += 0.5F) {
      EXPECT_EQ(Guessed(Strapped(heading, scale, kAll), true), kAll) << heading << " " << scale;
    }
  }
}

TEST(GuessParts, DoesNotDependOnTheOrder) {
  std::mt19937 random(3);
  std::vector<int> parts = kAll;
  for (int i = 0; i < 20; ++i) {
    std::ranges::shuffle(parts, random);
    EXPECT_EQ(Guessed(Strapped(1, 0.9F, parts), true), parts);
  }
}

TEST(GuessParts, WithoutADisplayLooksIntoTheHalfAroundAhead) {
  const std::vector<int> parts{body::kHips, body::kLeftFoot, body::kRightFoot};
  const std::vector<int> swapped{body::kHips, body::kRightFoot, body::kLeftFoot};
  for (const float heading : {-1.4F, 0.0F, 1.4F}) {
    EXPECT_EQ(Guessed(Strapped(heading, 1, parts), false), parts) << heading;
  }
  EXPECT_EQ(Guessed(Strapped(2, 1, parts), false), swapped) << "it cannot know";
}

TEST(GuessParts, LeavesWhatIsNowhereAndWhatIsTaken) {
  std::vector<Seen> seen = Strapped(0, 1, {body::kHead, body::kHips, body::kLeftFoot});
  seen[1].part = body::kHips;
  seen[0].part = seen[2].part = Seen::kUnknown;
  Seen camera{.position_m = {1.5F, 0.8F, 0}};  // on a tripod
  Seen second{.position_m = seen[1].position_m};
  seen.push_back(camera);
  seen.push_back(second);
  GuessParts(seen);
  EXPECT_EQ(seen[0].part, body::kHead);
  EXPECT_FALSE(seen[0].guessed) << "a display is known to be there";
  EXPECT_EQ(seen[1].part, body::kHips);
  EXPECT_EQ(seen[3].part, Seen::kUnknown);
  EXPECT_NE(seen[4].part, body::kHips) << "no part twice";
  std::vector<Seen> nobody;
  GuessParts(nobody);
}

TEST(FindStance, IsExactForExactDevices) {
  for (const float heading : {-2.5F, 0.0F, 1.0F}) {
    const Worn worn(kAll, 0, heading, 1.15F);
    const Stance found = FindStance(worn.See(body::Pose()));
    EXPECT_NEAR(std::remainder(found.heading - heading, 6.2831853F), 0, 1e-3F);
    EXPECT_NEAR(found.scale, 1.15F, 1e-3F);
    EXPECT_NEAR((found.place_m - worn.TrueStance().place_m).norm(), 0, 1e-3F);
    EXPECT_EQ(found.faced_by, "the hands");
    EXPECT_EQ(found.scaled_by, "the head's height");
  }
}

TEST(FindStance, UsesWhatIsThere) {
  const auto of = [](std::vector<int> parts) { return FindStance(Strapped(0.7F, 0.9F, parts)); };
  EXPECT_EQ(of({body::kHips, body::kLeftFoot, body::kRightFoot}).faced_by, "the feet");
  EXPECT_EQ(of({body::kHips, body::kLeftFoot, body::kRightFoot}).scaled_by, "the hips' height");
  EXPECT_NEAR(of({body::kLeftFoot, body::kRightFoot}).heading * kDegrees, 40.1F, 0.5F);
  EXPECT_EQ(of({body::kHead, body::kLeftFoot, body::kRightFoot}).faced_by, "the head");
  EXPECT_NEAR(of({body::kHead}).heading * kDegrees, 40.1F, 0.5F) << "by the display";
  EXPECT_NEAR(of({body::kHead}).scale, 0.9F, 0.01F) << "the eyes are above the joint";
  EXPECT_NEAR(of({body::kLeftHand, body::kRightHand}).scale, 0.9F, 0.01F);
  const Stance none = FindStance({});
  EXPECT_EQ(none.heading, 0);
  EXPECT_EQ(none.scale, 1);
}

}  // namespace
}  // namespace styled::devices
