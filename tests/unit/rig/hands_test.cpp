// Bodies that get fingers, and hands without a body.
#include "model/rig/hands.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/unit/rig/rigs.h"

namespace styled::rig {
namespace {

using ::testing::HasSubstr;

constexpr int kLeftIndex = kTailLeftThumb + 3;
const TailSet kBoth = FingersOf(body::kLeftHand) | FingersOf(body::kRightHand);

Binding Bound(const BindingSpec& spec) {
  auto binding = Binding::Make(spec);
  EXPECT_TRUE(binding.ok()) << binding.status().message();
  return std::move(binding.value());
}

void Add(BindingSpec& spec, const std::string& name, int parent, const Vec3& offset) {
  spec.skeleton.names.push_back(name);
  spec.skeleton.parents.push_back(parent);
  spec.skeleton.offsets.push_back(offset);
  spec.rest_rotations.push_back(spec.rest_rotations[static_cast<std::size_t>(parent)]);
}

TEST(Hands, FingersOfAHandAreFifteen) {
  EXPECT_EQ(FingersOf(body::kLeftHand).count(), 15U);
  EXPECT_EQ(FingersOf(body::kRightHand).count(), 15U);
  EXPECT_EQ(kBoth.count(), 30U);
  EXPECT_FALSE(kBoth[kTailLeftEye]);
}

TEST(Hands, ABodyWithoutFingersGetsThoseThatAreWanted) {
  Random random(1);
  for (const float units_per_metre : {1.0F, 100.0F}) {
    const StrangeRig rig = MakeStrangeRig(random, units_per_metre);
    const Binding before = Bound(rig.spec);
    const Binding after = WithFingers(before, kBoth);
    EXPECT_EQ(after.skeleton().joint_count(), before.skeleton().joint_count() + 30);
    EXPECT_EQ(after.scale(), before.scale());
    const Tail tail = Tail::Make(after, MapTailNames(after.skeleton()));
    ASSERT_EQ(tail.size(), 30U);
    for (const Tail::Joint& joint : tail.joints()) {
      EXPECT_LT((joint.offset_m - FingerOffset_m(joint.joint)).norm(), 1e-5F)
          << kTailNames[static_cast<std::size_t>(joint.joint)];
    }
    // In the T-pose their local rotations are the identity, and so is the tail.
    RigPose pose(after.skeleton());
    std::vector<Quat> turns(tail.size(), Quat::Identity());
    tail.Read(pose.rotations, turns);
    for (const Quat& turn : turns) EXPECT_LT(body::Angle_rad(turn, Quat::Identity()), 1e-3);
  }
}

TEST(Hands, TheFingersThatABodyHasStay) {
  BindingSpec spec = HumanoidSpec();
  Add(spec, "leftIndexProximal", body::kLeftHand, {0.1F, 0, 0.02F});
  // Without the joint before it: one that is put between would not lie above it.
  Add(spec, "leftRingIntermediate", body::kLeftHand, {0.13F, 0, -0.02F});
  const Binding after = WithFingers(Bound(spec), FingersOf(body::kLeftHand));
  const auto& names = after.skeleton().names;
  EXPECT_EQ(names.size(), static_cast<std::size_t>(kJointCount) + 2 + 12);
  EXPECT_EQ(std::ranges::count(names, "leftIndexProximal"), 1);
  EXPECT_EQ(std::ranges::count(names, "leftRingProximal"), 0);
  const Tail tail = Tail::Make(after, MapTailNames(after.skeleton()));
  EXPECT_EQ(tail.size(), 14U);
  EXPECT_EQ(tail.map()[kLeftIndex], kJointCount) << "the body's own";
  for (const Tail::Joint& joint : tail.joints()) {
    if (joint.joint == kLeftIndex + 1)
      EXPECT_EQ(joint.parent, kJointCount + 3) << "thumb, then index";
  }
  // Nothing is missing: nothing changes.
  EXPECT_EQ(WithFingers(after, FingersOf(body::kLeftHand)).skeleton(), after.skeleton());
}

TEST(Hands, ANameThatIsTakenAndAHandThatIsMissingAreLeftOut) {
  BindingSpec spec = HumanoidSpec();
  Add(spec, "leftThumbMetacarpal", body::kHead, {0, 0.1F, 0});  // no finger
  spec.source_joint[body::kRightHand] = -1;
  const Binding after = WithFingers(Bound(spec), kBoth);
  EXPECT_EQ(after.skeleton().joint_count(), kJointCount + 1 + 14);
  BindingSpec large = HumanoidSpec();
  while (large.skeleton.joint_count() < kMaxSourceJoints - 10) {
    Add(large, "prop" + std::to_string(large.skeleton.joint_count()), body::kHead, Vec3::Zero());
  }
  EXPECT_EQ(WithFingers(Bound(large), kBoth).skeleton(), large.skeleton) << "too many joints";
}

// A skeleton of hands and fingers alone, `axes`: source from canonical.
Skeleton Gloves(const Quat& axes, bool right = true) {
  Skeleton skeleton;
  const auto add = [&](const std::string& name, int parent, const Vec3& offset_m) {
    skeleton.names.push_back(name);
    skeleton.parents.push_back(parent);
    skeleton.offsets.push_back(axes * offset_m);
    return skeleton.joint_count() - 1;
  };
  const int root = add("gloves", -1, Vec3::Zero());
  std::array<int, 2> hands{add("leftHand", root, {0.7F, 1.4F, 0}), -1};
  if (right) hands[1] = add("rightHand", root, {-0.7F, 1.4F, 0});
  int last = 0;
  for (int t = 0; t < (right ? kTailLeftEye : kTailRightThumb); ++t) {
    const int parent = TailBefore(t) >= 0 ? last : hands[t < kTailRightThumb ? 0 : 1];
    last = add(std::string(kTailNames[static_cast<std::size_t>(t)]), parent, FingerOffset_m(t));
  }
  return skeleton;
}

TEST(Hands, ShowTheAxesByThemselves) {
  const float quarter = std::numbers::pi_v<float> / 2;
  for (const Quat& axes : {Quat::Identity(), Quat(Eigen::AngleAxisf(quarter, Vec3::UnitX())),
                           Quat(Eigen::AngleAxisf(-quarter, Vec3::UnitY()))}) {
    for (const bool right : {true, false}) {
      const auto spec = BindHands(Gloves(axes, right), {});
      ASSERT_TRUE(spec.ok()) << spec.status().message();
      EXPECT_LT(body::Angle_rad(spec.value().canonical_from_source, axes.conjugate()), 1e-3);
      const Tail tail = Tail::Make(spec.value(), 1, MapTailNames(spec.value().skeleton));
      EXPECT_EQ(tail.size(), right ? 30U : 15U);
    }
  }
}

TEST(Hands, OneFingerHasTheUsualUpAndWithoutLengthsTheUsualAxes) {
  Skeleton skeleton;
  skeleton.names = {"rightHand", "rightIndexProximal", "rightIndexIntermediate"};
  skeleton.parents = {-1, 0, 1};
  skeleton.offsets = {Vec3::Zero(), {0, 0, 0.1F}, {0, 0, 0.03F}};  // the right is +Z here
  auto spec = BindHands(skeleton, {});
  ASSERT_TRUE(spec.ok()) << spec.status().message();
  const Vec3 left = spec.value().canonical_from_source * Vec3(0, 0, -1);
  EXPECT_LT((left - Vec3::UnitX()).norm(), 1e-5F);
  EXPECT_LT((spec.value().canonical_from_source * Vec3::UnitY() - Vec3::UnitY()).norm(), 1e-5F);
  skeleton.offsets.assign(3, Vec3::Zero());
  spec = BindHands(skeleton, {});
  ASSERT_TRUE(spec.ok()) << spec.status().message();
  EXPECT_LT(body::Angle_rad(spec.value().canonical_from_source, Quat::Identity()), 1e-6);
}

TEST(Hands, WithoutFingersOrNotFlatAreRefused) {
  Skeleton skeleton;
  skeleton.names = {"leftHand", "watch"};
  skeleton.parents = {-1, 0};
  skeleton.offsets = {Vec3::Zero(), Vec3::UnitX()};
  EXPECT_THAT(BindHands(skeleton, {}).status().message(),
              HasSubstr("found no finger below a hand"));
  skeleton = Gloves(Quat::Identity());
  // The right hand's fingers point up, the left hand's to the side.
  std::vector<Quat> rest(skeleton.names.size(), Quat::Identity());
  for (std::size_t j = 0; j < rest.size(); ++j) {
    if (!skeleton.names[j].starts_with("left")) continue;
    skeleton.offsets[j] = Vec3(skeleton.offsets[j].z(), skeleton.offsets[j].y(), 0);
  }
  EXPECT_THAT(BindHands(skeleton, rest).status().message(), HasSubstr("do not lie flat"));
  EXPECT_FALSE(BindHands(skeleton, rest, {{"leftHand", "nobody"}}).ok());
}

}  // namespace
}  // namespace styled::rig
