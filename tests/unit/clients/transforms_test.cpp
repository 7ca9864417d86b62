#include "clients/cpp/transforms.h"

#include <gtest/gtest.h>

#include <limits>

#include "tests/unit/clients/fake_daemon.h"

namespace styled::client {
namespace {

v1::Body Humanoid() { return HumanoidBody("rig.a", v1::OUTPUT_CANONICAL, 7); }

body::Pose Bent() {
  body::Pose pose;
  pose.hips_position_m = {0.3F, 0.9F, -2.0F};
  for (int joint = 0; joint < body::kJointCount; ++joint) {
    const float share = static_cast<float>(joint) / 21.0F;
    pose.rotations[joint] =
        body::Exp(body::Vec3(0.9F * share, 0.4F - share, 0.2F * static_cast<float>(joint % 3)));
  }
  return pose;
}

TEST(ValidateBody, AcceptsTheHumanoid) { EXPECT_EQ(Validate(Humanoid()), BodyError::kNone); }

TEST(ValidateBody, RefusesEachBrokenRule) {
  v1::Body body;
  EXPECT_EQ(Validate(body), BodyError::kJoints);

  body = Humanoid();
  body.mutable_offsets()->RemoveLast();
  EXPECT_EQ(Validate(body), BodyError::kSizes);

  body = Humanoid();
  body.mutable_parents()->RemoveLast();
  EXPECT_EQ(Validate(body), BodyError::kSizes);

  body = Humanoid();
  body.add_rest(0.0F);
  EXPECT_EQ(Validate(body), BodyError::kSizes);

  body = Humanoid();
  body.set_parents(0, 0);
  EXPECT_EQ(Validate(body), BodyError::kParents);
  for (const int parent : {-1, 5, 6, 99}) {
    body = Humanoid();
    body.set_parents(5, parent);
    EXPECT_EQ(Validate(body), BodyError::kParents) << parent;
  }

  body = Humanoid();
  body.set_offsets(4, std::numeric_limits<float>::quiet_NaN());
  EXPECT_EQ(Validate(body), BodyError::kNumbers);

  body = Humanoid();
  for (int joint = 0; joint <= kMaxJoints; ++joint) body.add_names("x");
  EXPECT_EQ(Validate(body), BodyError::kJoints);
}

TEST(WorldTransforms, EqualsForwardKinematicsOfTheBody) {
  const body::Pose pose = Bent();
  body::WorldPose expected;
  body::ForwardKinematics(pose, expected);
  const v1::Body body = Humanoid();
  std::vector<Transform> joints;
  ASSERT_EQ(WorldTransforms(body, HumanoidFrame(body, pose, 1), joints), FrameError::kNone);
  ASSERT_EQ(joints.size(), std::size_t{body::kJointCount});
  for (int joint = 0; joint < body::kJointCount; ++joint) {
    EXPECT_LT((joints[joint].position - expected.positions_m[joint]).norm(), 1e-5F) << joint;
    EXPECT_LT(joints[joint].rotation.angularDistance(expected.rotations[joint]), 1e-3F) << joint;
  }
}

TEST(WorldTransforms, TheRootPositionReplacesTheRootOffset) {
  const v1::Body body = Humanoid();
  v1::Frame frame = HumanoidFrame(body, body::Pose(), 1);
  for (int axis = 0; axis < 3; ++axis) frame.set_root_position(axis, 0);
  std::vector<Transform> joints;
  ASSERT_EQ(WorldTransforms(body, frame, joints), FrameError::kNone);
  EXPECT_EQ(joints[0].position, Eigen::Vector3f::Zero());
}

TEST(WorldTransforms, RefusesEachBadFrameAndLeavesTheOutputAlone) {
  const v1::Body body = Humanoid();
  const v1::Frame good = HumanoidFrame(body, body::Pose(), 1);
  std::vector<Transform> joints(2);
  const auto expect = [&](FrameError error, auto edit) {
    v1::Frame frame = good;
    edit(frame);
    EXPECT_EQ(WorldTransforms(body, frame, joints), error);
    EXPECT_EQ(joints.size(), 2U);
  };
  const float nan = std::numeric_limits<float>::quiet_NaN();
  expect(FrameError::kOtherBody, [](v1::Frame& f) { f.set_body_hash(8); });
  expect(FrameError::kOtherBody, [](v1::Frame& f) { f.set_output(v1::OUTPUT_RIG); });
  expect(FrameError::kSizes, [](v1::Frame& f) { f.mutable_rotations()->RemoveLast(); });
  expect(FrameError::kSizes, [](v1::Frame& f) { f.add_root_position(0); });
  expect(FrameError::kNumbers, [&](v1::Frame& f) { f.set_root_position(1, nan); });
  expect(FrameError::kNumbers, [&](v1::Frame& f) { f.set_rotations(9, nan); });
  expect(FrameError::kNumbers, [](v1::Frame& f) {
    for (int k = 0; k < 4; ++k) f.set_rotations(k, 0);
  });
}

}  // namespace
}  // namespace styled::client
