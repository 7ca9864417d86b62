#include "model/stylist/avatar.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/unit/feet/walker.h"
#include "tests/unit/rig/rigs.h"

namespace styled::stylist {
namespace {

using body::Quat;
using body::Vec3;
using feet::kLegs;
using feet::Legs;
using feet::Walker;

// Thighs half as long again, shins a fifth longer, longer feet, wider hips; in centimetres, Z up.
rig::Binding Stilts() {
  rig::BindingSpec spec = rig::HumanoidSpec();
  const Quat axes(Eigen::AngleAxisf(1.5707963F, Vec3::UnitX()));  // +Y up to +Z up
  const auto scale = [&spec](int joint, const Vec3& by) {
    Vec3& offset = spec.skeleton.offsets[static_cast<std::size_t>(joint)];
    offset = offset.cwiseProduct(by);
  };
  for (const int left : {body::kLeftUpperLeg, body::kRightUpperLeg}) {
    scale(left, Vec3(1.3F, 1, 1));
    scale(left + 1, Vec3(1, 1.5F, 1));
    scale(left + 2, Vec3(1, 1.2F, 1));
    scale(left + 3, Vec3(1, 1.1F, 1.4F));
  }
  for (Vec3& offset : spec.skeleton.offsets) offset = 100 * (axes * offset);
  spec.canonical_from_source = axes.conjugate();
  return rig::Binding::Make(std::move(spec)).value();
}

body::Pose Canonical(const rig::RigPose& pose) {
  body::Pose out;
  out.hips_position_m = pose.translations[0];
  std::copy(pose.rotations.begin(), pose.rotations.end(), out.rotations.begin());
  return out;
}

struct AvatarTest : testing::Test {
  const std::shared_ptr<const rig::Binding> humanoid =
      std::make_shared<const rig::Binding>(feet::HumanoidBinding());
  const std::shared_ptr<const rig::Binding> stilts = std::make_shared<const rig::Binding>(Stilts());
  const Legs legs{*stilts};
  const Walker walker;

  // The stylist's output for the walker at a moment.
  Output At(double time_s, bool styled) const {
    Output out(humanoid->skeleton());
    out.source = walker.At(time_s);
    out.canonical_input = Canonical(out.source);
    out.canonical = styled ? Canonical(walker.Styled(time_s)) : out.canonical_input;
    out.flags = styled ? 0 : kBypass;
    return out;
  }
  Vec3 Toes_cm(const rig::RigPose& pose, int side) const {
    std::vector<feet::Placed> placed(legs.joints().size());
    legs.Place({pose.translations, pose.rotations}, placed);
    return placed[static_cast<std::size_t>(legs.leg(side).toes)].position_m /
           stilts->scale();  // canonical axes, the avatar's centimetres
  }
  struct Walk {
    double skate_cmps = 0, lowest_cm = 1e9, highest_planted_cm = -1e9, largest_turn = 0;
  };
  // Walks for six seconds; measures the avatar's toes while the walker's own feet are planted.
  Walk WalkOn(const Options& options, bool styled) {
    Avatar avatar(humanoid, stilts, rig::RigPose(stilts->skeleton()), options);
    Walk walk;
    double way_cm = 0, seconds = 0;
    rig::RigPose last;
    constexpr int kRate = 120;
    for (int i = 0; i < 6 * kRate; ++i) {
      const double t = static_cast<double>(i) / kRate;
      avatar.Process(static_cast<std::int64_t>(t * 1e9), At(t, styled));
      const rig::RigPose& pose = avatar.pose();
      for (int side = 0; t > 2 && side < kLegs; ++side) {
        const Vec3 toes = Toes_cm(pose, side);
        walk.lowest_cm = std::min<double>(walk.lowest_cm, toes.y());
        const double phase = walker.Phase(t, side);
        if (phase < 0.15 || phase > Walker::kStance - 0.02) continue;
        walk.highest_planted_cm = std::max<double>(walk.highest_planted_cm, toes.y());
        Vec3 step = toes - Toes_cm(last, side);
        step.y() = 0;
        way_cm += step.norm();
        seconds += 1.0 / kRate;
      }
      for (std::size_t joint = 0; i > 60 && joint < pose.rotations.size(); ++joint) {
        walk.largest_turn = std::max<double>(
            walk.largest_turn, body::Angle_rad(last.rotations[joint], pose.rotations[joint]));
      }
      last = pose;
    }
    walk.skate_cmps = way_cm / seconds;
    return walk;
  }
};

TEST_F(AvatarTest, ALongLeggedOneKeepsItsPlantedFeetStillStyledOrNot) {
  for (const bool styled : {false, true}) {
    Options loose;
    loose.feet = false;
    EXPECT_GT(WalkOn(loose, styled).skate_cmps, 3) << "nothing to mend";
    const Walk held = WalkOn({}, styled);
    EXPECT_LT(held.skate_cmps, 1) << styled;
    EXPECT_LT(held.largest_turn, 0.25) << styled;
    // The height of the avatar's toe joint above the floor, in its centimetres.
    const double toes_cm = 100 * (Walker::kAnkle_m + body::Offset(body::kLeftToes).y()) *
                           static_cast<double>(0.01F / stilts->scale());
    EXPECT_NEAR(held.lowest_cm, toes_cm, 1.5) << styled;
    EXPECT_NEAR(held.highest_planted_cm, toes_cm, 1.5) << styled;
  }
}

TEST_F(AvatarTest, AnotherBodyOfTheSameProportionsTakesTheMotionAsItIs) {
  Avatar avatar(humanoid, humanoid, rig::RigPose(humanoid->skeleton()), {});
  for (int i = 0; i < 240; ++i) {
    const Output out = At(i / 120.0, false);
    avatar.Process(i * 8'333'333LL, out);
    for (std::size_t joint = 0; joint < body::kJointCount; ++joint) {
      ASSERT_LT(body::Angle_rad(avatar.pose().rotations[joint], out.canonical.rotations[joint]),
                4e-3);
    }
    ASSERT_LT((avatar.pose().translations[0] - out.canonical.hips_position_m).norm(), 2e-3);
  }
}

// The performer has an index finger of two joints; the avatar has them in other axes, and a jaw.
TEST_F(AvatarTest, FingersThatBothHaveFollowAndOthersRest) {
  const auto with = [](rig::BindingSpec spec, const std::string& name, int parent) {
    const Quat turned(Eigen::AngleAxisf(1, Vec3(1, 2, 3).normalized()));
    spec.skeleton.names.push_back(name);
    spec.skeleton.parents.push_back(parent);
    spec.skeleton.offsets.emplace_back(3, 0, 0);
    spec.rest_rotations.push_back(spec.canonical_from_source.x() == 0 ? Quat::Identity() : turned);
    return spec;
  };
  rig::BindingSpec performer = humanoid->spec(), avatar = stilts->spec();
  performer = with(performer, "LeftHandIndex1", body::kLeftHand);
  performer = with(performer, "LeftHandIndex2", body::kJointCount);
  avatar = with(avatar, "finger", body::kLeftHand);
  avatar = with(avatar, "fingertip", body::kJointCount);
  avatar = with(avatar, "jaw", body::kHead);
  const auto from = std::make_shared<const rig::Binding>(rig::Binding::Make(performer).value());
  const auto to = std::make_shared<const rig::Binding>(rig::Binding::Make(avatar).value());
  rig::TailMap tail = rig::NoTail();
  constexpr int kIndex = rig::kTailLeftThumb + rig::kFingerJoints;
  tail[kIndex] = body::kJointCount;
  tail[kIndex + 1] = body::kJointCount + 1;
  tail[rig::kTailJaw] = body::kJointCount + 2;
  const rig::RigPose rest(to->skeleton());
  Avatar worn(from, to, rest, {}, tail);
  Output out(from->skeleton());
  const Output walking = At(0.5, true);
  out.canonical = walking.canonical;
  out.canonical_input = walking.canonical_input;
  const Quat bent(Eigen::AngleAxisf(0.7F, Vec3::UnitZ()));
  out.rig.rotations[body::kJointCount] = bent;
  out.rig.rotations[body::kJointCount + 1] = bent;
  ASSERT_TRUE(worn.Process(0, out));
  std::vector<Quat> read(3, Quat::Identity());
  rig::Tail::Make(*to, tail).Read(worn.pose().rotations, read);
  EXPECT_LT(body::Angle_rad(read[0], bent), 2e-3F);
  EXPECT_LT(body::Angle_rad(read[1], bent), 2e-3F);
  EXPECT_EQ(worn.pose().rotations[body::kJointCount + 2].coeffs(),
            rest.rotations[body::kJointCount + 2].coeffs());
}

TEST_F(AvatarTest, ANewSessionIsWhereverThePerformerIs) {
  Avatar avatar(humanoid, humanoid, rig::RigPose(humanoid->skeleton()), {});
  for (int i = 0; i < 60; ++i) avatar.Process(i * 8'333'333LL, At(i / 120.0, false));
  Output far = At(3, false);
  far.flags |= kNewSession;
  far.source.translations[0].x() += 5;
  far.canonical.hips_position_m.x() += 5;
  avatar.Process(60 * 8'333'333LL, far);
  EXPECT_LT((avatar.pose().translations[0] - far.canonical.hips_position_m).norm(), 2e-3);
  for (std::size_t joint = 0; joint < body::kJointCount; ++joint) {
    EXPECT_LT(body::Angle_rad(avatar.pose().rotations[joint], far.canonical.rotations[joint]),
              4e-3);
  }
}

}  // namespace
}  // namespace styled::stylist
