#include "model/train/judge/stream.h"

#include <gtest/gtest.h>

#include "model/body/heading.h"
#include "model/feet/legs.h"

namespace styled::judge {
namespace {

constexpr int kBlend = 10;

// A rest pose that glides straight ahead in the direction `heading_rad`, from `start_m`.
Poses Glide(int frames, float heading_rad, const body::Vec3& start_m) {
  Poses poses(static_cast<std::size_t>(frames));
  for (int i = 0; i < frames; ++i) {
    const body::Quat turn = body::Yaw(heading_rad);
    poses[i].rotations[body::kHips] = turn;
    poses[i].hips_position_m += start_m + turn * body::Vec3(0, 0, 0.04F * static_cast<float>(i));
  }
  return poses;
}

TEST(Chain, IsContinuousInPlaceAndHeading) {
  const std::vector<Poses> clips = {Glide(60, 0.3F, {1, 0, 2}), Glide(45, -2.0F, {-4, 0, 7})};
  const Chain chain = ChainClips(clips, 30, 20, kBlend);
  ASSERT_GT(chain.poses.size(), 600U);
  for (std::size_t i = 1; i < chain.poses.size(); ++i) {
    const body::Pose& a = chain.poses[i - 1];
    const body::Pose& b = chain.poses[i];
    ASSERT_NEAR((b.hips_position_m - a.hips_position_m).norm(), 0.04F, 0.01F) << i;
    ASSERT_LT(a.rotations[body::kHips].angularDistance(b.rotations[body::kHips]), 0.01F) << i;
  }
}

TEST(Chain, ShowsEachClipOnceMoreAfterTheTime) {
  const std::vector<Poses> clips = {Glide(60, 0, {0, 0, 0}), Glide(45, 1, {0, 0, 0})};
  const Chain chain = ChainClips(clips, 30, 20, kBlend);
  std::array<int, 2> late{};
  for (const Chain::Part& part : chain.parts) {
    EXPECT_LT(part.begin, part.end);
    if (part.begin >= 600) ++late[part.clip];
  }
  EXPECT_EQ(late[0], 1);
  EXPECT_EQ(late[1], 1);
}

TEST(Chain, LeavesOutClipsThatAreAllSeam) {
  const std::vector<Poses> clips = {Glide(12, 0, {0, 0, 0})};
  EXPECT_TRUE(ChainClips(clips, 30, 5, kBlend).poses.empty());
}

TEST(ConstantOffset, OfIdentityChangesNothing) {
  ConstantOffset none;
  none.offset.fill(body::Quat::Identity());
  const body::Pose in = Glide(3, 0.5F, {1, 0.1F, 0})[2];
  const body::Pose out = none.Apply(in);
  EXPECT_TRUE(out.hips_position_m.isApprox(in.hips_position_m));
  for (int joint = 0; joint < body::kJointCount; ++joint) {
    EXPECT_TRUE(out.rotations[joint].isApprox(in.rotations[joint]));
  }
}

TEST(ConstantOffset, KeepsTheLowestFootWhereItWas) {
  ConstantOffset bent;
  bent.offset.fill(body::Quat::Identity());
  bent.offset[body::kLeftLowerLeg] = body::Exp({0.8F, 0, 0});
  bent.offset[body::kRightLowerLeg] = body::Exp({0.8F, 0, 0});
  body::WorldPose before, after;
  body::ForwardKinematics(body::Pose(), before);
  body::ForwardKinematics(bent.Apply(body::Pose()), after);
  EXPECT_NEAR(body::LowestFoot_m(before), body::LowestFoot_m(after), 1e-5);
}

TEST(HumanoidBinding, GivesAPoseBackAsItCame) {
  const rig::Binding binding = feet::HumanoidBinding();
  const body::Pose in = Glide(5, 0.7F, {0.2F, 0, -1})[4];
  rig::RigPose source(binding.skeleton());
  source.translations[0] = in.hips_position_m;
  std::copy(in.rotations.begin(), in.rotations.end(), source.rotations.begin());
  body::Pose out;
  binding.Bind(source, out);
  EXPECT_TRUE(out.hips_position_m.isApprox(in.hips_position_m, 1e-4F));
  EXPECT_TRUE(out.rotations[body::kHips].isApprox(in.rotations[body::kHips], 1e-4F));
}

}  // namespace
}  // namespace styled::judge
