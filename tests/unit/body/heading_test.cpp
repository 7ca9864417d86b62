#include "model/body/heading.h"

#include <gtest/gtest.h>

#include "tests/unit/body/random_pose.h"

namespace styled::body {
namespace {

TEST(Heading, ATurnedBodysHeadingIsItsYaw) {
  for (float yaw = -3.1F; yaw < 3.1F; yaw += 0.2F) {
    WorldPose world;
    ForwardKinematics(Moved(Pose(), yaw, Vec3(1, 0, 2)), world);
    EXPECT_NEAR(Heading_rad(world), yaw, 1e-5);
  }
}

TEST(Heading, TurnsOverWhenTheBodyIsMirrored) {
  Random random(1);
  for (int round = 0; round < 50; ++round) {
    const Pose pose = Moved(Upright(random), random.Between(-2, 2), Vec3::Zero());
    Pose mirrored;
    Mirror(pose, mirrored);
    WorldPose a, b;
    ForwardKinematics(pose, a);
    ForwardKinematics(mirrored, b);
    EXPECT_NEAR(Heading_rad(a), -Heading_rad(b), 1e-5);
  }
}

}  // namespace
}  // namespace styled::body
