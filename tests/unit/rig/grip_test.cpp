#include "model/rig/grip.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/unit/body/random_pose.h"
#include "tests/unit/rig/rigs.h"

namespace styled::rig {
namespace {

WristPair At(const Vec3& left, const Vec3& right) {
  return {Placed{left, Quat::Identity()}, Placed{right, Quat::Identity()}};
}
const Vec3 kFar(0, 100, 0);

// Within 4 m of the origin, as rounding grows with the distance.
WristPair OnAStage(body::Random& random) {
  body::Pose pose = random.AnyPose();
  pose.hips_position_m *= 0.1F;
  return WristsOf(pose);
}

TEST(Grip, IsWholeUpToAForearmAndNoneBeyondItAndSmoothBetween) {
  float last = 1;
  for (float d = 0; d < 0.7F; d += 0.001F) {
    const Grip grip =
        GripOf({Vec3(d, 0, 0), Quat::Identity()}, At(Vec3::Zero(), kFar), Hand::kAuto);
    EXPECT_EQ(grip.share[1], 0);
    if (d < kHeld_m) {
      EXPECT_EQ(grip.share[0], 1) << d;
    }
    if (d > kLetGo_m) {
      EXPECT_EQ(grip.share[0], 0) << d;
    }
    EXPECT_LE(std::abs(grip.share[0] - last), 0.011F) << d;
    last = grip.share[0];
  }
}

TEST(Grip, TheNearerOfTwoHandsHasAlmostAllAndTheyPassItSmoothly) {
  Grip last =
      GripOf({Vec3::Zero(), Quat::Identity()}, At(Vec3::Zero(), Vec3(0.4F, 0, 0)), Hand::kAuto);
  EXPECT_GT(last.share[0], 0.99F);
  for (float x = 0; x <= 0.4F; x += 0.001F) {
    const Grip grip =
        GripOf({Vec3(x, 0, 0), Quat::Identity()}, At(Vec3::Zero(), Vec3(0.4F, 0, 0)), Hand::kAuto);
    EXPECT_NEAR(grip.held(), 1, 1e-5F) << "never let go";
    EXPECT_LT(std::abs(grip.share[0] - last.share[0]), 0.03F) << x;
    last = grip;
  }
  EXPECT_GT(last.share[1], 0.99F);
  const Grip two =
      GripOf({Vec3(0.1F, 0, 0), Quat::Identity()}, At(Vec3::Zero(), Vec3(0.4F, 0, 0)), Hand::kAuto);
  EXPECT_NEAR(two.share[0], 0.98F, 0.01F) << "as the header says";
}

TEST(Grip, MayBeGivenAndNeedsAHand) {
  const Placed far{kFar, Quat::Identity()}, near{Vec3::Zero(), Quat::Identity()};
  const WristPair wrists = At(Vec3::Zero(), Vec3(1, 0, 0));
  EXPECT_EQ(GripOf(far, wrists, Hand::kRight).share, (std::array<float, 2>{0, 1}));
  EXPECT_EQ(GripOf(far, wrists, Hand::kLeft).share, (std::array<float, 2>{1, 0}));
  EXPECT_EQ(GripOf(near, wrists, Hand::kNone).held(), 0);
  for (const Hand hand : {Hand::kAuto, Hand::kLeft, Hand::kRight}) {
    EXPECT_EQ(GripOf(near, {}, hand).held(), 0) << "the rig has no hands";
  }
}

TEST(Carry, WeldsToAHandAndLeavesWhatNobodyHolds) {
  body::Random random(5);
  for (int i = 0; i < 100; ++i) {
    const WristPair from = OnAStage(random), to = OnAStage(random);
    const Placed object{Vec3(0.3F, 1, 0.2F), random.AnyPose().rotations[3].normalized()};
    const Placed free = Carry(object, {}, from, to);
    EXPECT_EQ(free.position_m, object.position_m);
    EXPECT_EQ(free.rotation.coeffs(), object.rotation.coeffs());
    for (const std::size_t side : {kLeftWrist, kRightWrist}) {
      Grip grip;
      grip.share[side] = 1;
      const Placed held = Carry(object, grip, from, to);
      const auto against = [&](const Placed& hand, const Placed& what) -> Vec3 {
        return hand.rotation.conjugate() * (what.position_m - hand.position_m);
      };
      EXPECT_LT((against(*from[side], object) - against(*to[side], held)).norm(), 1e-5F);
      const Quat before = from[side]->rotation.conjugate() * object.rotation;
      const Quat after = to[side]->rotation.conjugate() * held.rotation;
      EXPECT_LT(before.angularDistance(after), 1e-3F);
      // A skeleton without that hand.
      WristPair none = to;
      none[side].reset();
      EXPECT_EQ(Carry(object, grip, from, none).position_m, object.position_m);
    }
  }
}

TEST(Carry, GivesARotationWhateverTheHandsDo) {
  const auto turned = [](float radians) {
    return Placed{Vec3::Zero(), Quat(Eigen::AngleAxisf(radians, Vec3::UnitX()))};
  };
  const WristPair from{turned(0), turned(0)}, to{turned(3.1415927F), turned(-3.1415927F)};
  const Placed held = Carry({Vec3::Zero(), Quat::Identity()}, {{0.5F, 0.5F}}, from, to);
  EXPECT_NEAR(held.rotation.norm(), 1, 1e-5F);
}

// The wrists of a skeleton in other units and axes are the canonical humanoid's, where it has its
// proportions.
TEST(Wrists, AreWhereForwardKinematicsPutsTheHands) {
  BindingSpec spec = HumanoidSpec();
  const Quat axes(Eigen::AngleAxisf(1.5707963F, Vec3::UnitX()));
  for (Vec3& offset : spec.skeleton.offsets) offset = 100 * (axes * offset);
  spec.canonical_from_source = axes.conjugate();
  const Binding binding = Binding::Make(std::move(spec)).value();
  const Wrists wrists(binding);
  body::Random random(8);
  RigPose out(binding.skeleton());
  for (int i = 0; i < 50; ++i) {
    const body::Pose pose = random.AnyPose();
    binding.Unbind(pose, RigPose(binding.skeleton()), out);
    const WristPair expected = WristsOf(pose);
    const WristPair found = wrists.Read(binding.RootPosition(out), out.rotations);
    for (const std::size_t side : {kLeftWrist, kRightWrist}) {
      ASSERT_TRUE(found[side]);
      EXPECT_LT((found[side]->position_m - expected[side]->position_m).norm(), 1e-4F);
      EXPECT_LT(found[side]->rotation.angularDistance(expected[side]->rotation), 1e-3F);
      Vec3 position;
      Quat rotation;
      FromCanonical(binding, *found[side], position, rotation);
      const Placed again = ToCanonical(binding, position, rotation);
      EXPECT_LT((again.position_m - found[side]->position_m).norm(), 1e-5F);
      EXPECT_LT(again.rotation.angularDistance(found[side]->rotation), 1e-3F);
    }
  }
}

}  // namespace
}  // namespace styled::rig
