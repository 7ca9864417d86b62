#include "model/clip/bind_clip.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <tuple>

#include "model/rig/motion_up.h"
#include "model/synthetic/performer.h"
#include "model/synthetic/script.h"
#include "tests/unit/rig/rigs.h"

namespace styled::clip {
namespace {

using rig::Quat;
using rig::Vec3;
using testing::HasSubstr;

// The synthetic performer as a rig of the humanoid's names, whose zero pose is `zero`: local
// rotations away from the T-pose, identity where there is none.
Clip Performed(const std::string& script, const std::map<int, Quat>& zero, double seconds = 4) {
  Clip clip;
  clip.skeleton = rig::HumanoidSkeleton();
  std::array<Quat, body::kJointCount> world;  // of the zero pose's joints, from the T-pose's
  for (int c = 0; c < body::kJointCount; ++c) {
    const int parent = body::kHumanoid[c].parent;
    const auto turn = zero.find(c);
    world[c] = parent < 0 ? Quat::Identity() : world[parent];
    if (turn != zero.end()) world[c] = world[c] * turn->second;
    if (parent >= 0) clip.skeleton.offsets[c] = world[parent] * body::Offset(c);
  }
  clip.rate_hz = 30;
  synthetic::Options options;
  options.script = synthetic::ParseScript(script).value();
  synthetic::Performer performer(options);
  body::Pose pose;
  for (int i = 0; i < static_cast<int>(seconds * clip.rate_hz); ++i) {
    performer.Pose(i / clip.rate_hz, pose);
    rig::RigPose frame(clip.skeleton);
    frame.translations[0] = pose.hips_position_m;
    for (int c = 0; c < body::kJointCount; ++c) {
      const int parent = body::kHumanoid[c].parent;
      const Quat above = parent < 0 ? Quat::Identity() : world[parent];
      frame.rotations[c] = above * pose.rotations[c] * world[c].conjugate();
    }
    clip.frames.push_back(frame);
  }
  return clip;
}

Quat About(const Vec3& axis, float degrees) {
  return Quat(Eigen::AngleAxisf(degrees / 57.29578F, axis));
}
// Zero poses: arms hanging; and one that lies on its side, so that no pose but a frame tells.
std::map<int, Quat> ArmsDown() {
  return {{body::kLeftUpperArm, About(Vec3::UnitZ(), -85)},
          {body::kRightUpperArm, About(Vec3::UnitZ(), 85)}};
}
std::map<int, Quat> Tangled() {
  auto zero = ArmsDown();
  zero[body::kLeftUpperLeg] = About(Vec3::UnitX(), -120);
  zero[body::kRightUpperLeg] = About(Vec3::UnitX(), -120);
  return zero;
}

std::string Refusal(const Clip& clip, const std::string& dialect, const std::string& rest,
                    const rig::JointNames& given = {}) {
  const auto bound = BindClip(clip, {dialect, ParseRestPose(rest).value(), given, {}});
  return bound.ok() ? "accepted" : bound.status().message();
}

TEST(RestPoseOf, WordsAndTimesAloneIsUnderstood) {
  for (const char* const wrong : {"", "t", "-1", "nan", "inf", "1s", "1,5", " 1", "ZERO"}) {
    EXPECT_THAT(ParseRestPose(wrong).status().message(),
                HasSubstr("expected auto, zero, standing, or the seconds"))
        << wrong;
  }
  EXPECT_EQ(ParseRestPose("standing").value().kind, RestPose::Kind::kStanding);
  EXPECT_EQ(ParseRestPose("1.5").value().time_s, 1.5);
}

TEST(BindClipRefuses, WhatItCannotBind) {
  Clip clip = Performed("stand:60", Tangled(), 1);
  EXPECT_THAT(Refusal(clip, "klingon", "auto"), HasSubstr("found dialect klingon"));
  EXPECT_THAT(Refusal(clip, "klingon", "standing"), HasSubstr("found dialect klingon"));
  EXPECT_THAT(Refusal(clip, "canonical", "auto"), HasSubstr("not a T-pose"));
  EXPECT_THAT(Refusal(clip, "auto", "zero"), HasSubstr("(zero pose: "));
  EXPECT_THAT(Refusal(clip, "auto", "7"),
              HasSubstr("found no frame at 7 s, expected 0 to 0.967 s"));
  EXPECT_THAT(Refusal(clip, "auto", "auto", {{"neck", "Neck"}}), HasSubstr("no joint \"Neck\""));
  const std::vector<int> whole = clip.skeleton.parents;
  for (const int c : {body::kLeftLowerLeg, body::kLeftFoot, body::kLeftToes}) {
    clip.skeleton.names[c] = "wheel" + std::to_string(c);
    clip.skeleton.parents[c] = body::kHips;
  }
  const std::string refusal = Refusal(clip, "auto", "auto");
  EXPECT_THAT(refusal, HasSubstr("found no joint named like leftLowerLeg"));
  EXPECT_THAT(refusal, HasSubstr("its joints: hips, spine, chest")) << "to name them by hand";
  EXPECT_THAT(refusal, HasSubstr("wheel"));
  clip.skeleton.parents = whole;
  EXPECT_EQ(Refusal(clip, "auto", "auto", {{"leftLowerLeg", "wheel14"}}), "accepted");
  EXPECT_EQ(Refusal(clip, "auto", "auto"), "accepted") << "the tree alone tells the leg";
}

TEST(BindClip, LeavesToTheDialectWhatItKnows) {
  const Clip clip = Performed("walk:60", {});
  const auto bound = BindClip(clip);
  ASSERT_TRUE(bound.ok()) << bound.status().message();
  EXPECT_EQ(bound.value().dialect, "canonical");
  EXPECT_EQ(bound.value().rest, "");
  for (const Quat& q : bound.value().binding.spec().rest_rotations) {
    EXPECT_LT(body::Angle_rad(q, Quat::Identity()), 1e-6F);
  }
}

// How far bound limbs are from where the performer had them, degrees, the worst of all frames.
float WorstLimb_deg(const Clip& clip, const Clip& truth, const RestPose& rest) {
  const auto bound = BindClip(clip, {.rest = rest});
  EXPECT_TRUE(bound.ok()) << bound.status().message();
  if (!bound.ok()) return 180;
  const auto poses = ToCanonical(clip, bound.value().binding);
  const auto expected = ToCanonical(truth, BindClip(truth).value().binding);
  float worst = 0;
  body::WorldPose is, should;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    body::ForwardKinematics(poses[i], is);
    body::ForwardKinematics(expected[i], should);
    for (const int c : {body::kLeftLowerArm, body::kRightLowerArm, body::kLeftHand,
                        body::kLeftLowerLeg, body::kRightLowerLeg, body::kLeftFoot,
                        body::kRightFoot, body::kLeftToes, body::kRightToes}) {
      const int from = body::kHumanoid[c].parent;
      const Vec3 a = is.positions_m[c] - is.positions_m[from];
      const Vec3 b = should.positions_m[c] - should.positions_m[from];
      worst =
          std::max(worst, std::acos(std::clamp(a.normalized().dot(b.normalized()), -1.0F, 1.0F)));
    }
  }
  return worst * 57.29578F;
}

TEST(BindClip, FindsTheTPoseOfAZeroPoseWithHangingArms) {
  const Clip clip = Performed("walk:60", ArmsDown());
  EXPECT_EQ(BindClip(clip).value().rest, "zero pose");
  EXPECT_LT(WorstLimb_deg(clip, Performed("walk:60", {}), {}), 2);
}

// In a walk no frame stands: each limb is taken from another one.
TEST(BindClip, AClipIsGivenItsTPoseAsZeroPose) {
  const Clip hanging = Performed("walk:10", ArmsDown());
  const auto bound = BindClip(hanging);
  ASSERT_TRUE(bound.ok()) << bound.status().message();
  const Clip straight = WithTPose(hanging, bound.value().binding);
  const auto live = rig::BindDialect(straight.skeleton, "auto");
  ASSERT_TRUE(live.ok()) << live.status().message();
  const auto expected = ToCanonical(hanging, bound.value().binding);
  const auto poses = ToCanonical(straight, live.value());
  ASSERT_EQ(poses.size(), expected.size());
  for (std::size_t i = 0; i < poses.size(); ++i) {
    for (std::size_t j = 0; j < body::kJointCount; ++j) {
      ASSERT_LT(body::Angle_rad(poses[i].rotations[j], expected[i].rotations[j]), 0.01F)
          << i << ", " << j;
    }
  }
}

TEST(BindClip, FindsTheTPoseOfAWalkWhoseZeroPoseTellsNothing) {
  const Clip clip = Performed("walk:60", Tangled());
  const auto bound = BindClip(clip);
  ASSERT_TRUE(bound.ok()) << bound.status().message();
  EXPECT_EQ(bound.value().rest, "straightest frames");
  EXPECT_EQ(bound.value().dialect, "standing");
  EXPECT_LT(WorstLimb_deg(clip, Performed("walk:60", {}), {}), 20);
}

TEST(BindClip, TakesTheFrameThatIsNamed) {
  const Clip clip = Performed("stand:60", Tangled());
  const auto bound = BindClip(clip, {.rest = ParseRestPose("1").value()});
  ASSERT_TRUE(bound.ok()) << bound.status().message();
  EXPECT_EQ(bound.value().rest, "frame at 1 s");
  EXPECT_LT(WorstLimb_deg(clip, Performed("stand:60", {}), ParseRestPose("1").value()), 10);
}

// A thousandth of a metre between the collars' begins says nothing about the trunk.
TEST(BindClip, CollarsThatBeginAtOnePlaceDoNotTurnTheTrunk) {
  Clip clip = Performed("walk:60", ArmsDown());
  const auto expected = ToCanonical(clip, BindClip(clip).value().binding);
  for (const auto& [shoulder, arm, shift] :
       {std::tuple{body::kLeftShoulder, body::kLeftUpperArm, Vec3(0, 0.001F, 0)},
        std::tuple{body::kRightShoulder, body::kRightUpperArm, Vec3(0, -0.001F, 0)}}) {
    const Vec3 whole = clip.skeleton.offsets[shoulder] + clip.skeleton.offsets[arm];
    clip.skeleton.offsets[shoulder] = Vec3(0, 0.15F, 0) + shift;
    clip.skeleton.offsets[arm] = whole - clip.skeleton.offsets[shoulder];
    for (rig::RigPose& frame : clip.frames) {
      frame.translations[shoulder] = clip.skeleton.offsets[shoulder];
      frame.translations[arm] = clip.skeleton.offsets[arm];
    }
  }
  const auto bound = BindClip(clip);
  ASSERT_TRUE(bound.ok()) << bound.status().message();
  EXPECT_EQ(bound.value().remark, "");
  const auto poses = ToCanonical(clip, bound.value().binding);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    ASSERT_LT(
        body::Angle_rad(poses[i].rotations[body::kChest], expected[i].rotations[body::kChest]),
        5 / 57.3F);
  }
}

TEST(BindClip, AMotionWithAnotherUpAxisThanItsZeroPoseStandsUpright) {
  const Clip upright = Performed("walk:60", {});
  Clip clip = upright;
  const Quat turn = About(Vec3::UnitX(), 90);  // from +Y up to +Z up
  for (rig::RigPose& frame : clip.frames) {
    frame.translations[0] = turn * frame.translations[0];
    frame.rotations[0] = turn * frame.rotations[0];
  }
  const auto bound = BindClip(clip);
  ASSERT_TRUE(bound.ok()) << bound.status().message();
  EXPECT_EQ(
      bound.value().remark,
      "the zero pose stands along +Y, the frames along +Z, which is taken for up; if they lie: "
      "--up y");
  const auto expected = ToCanonical(upright, BindClip(upright).value().binding);
  const auto poses = ToCanonical(clip, bound.value().binding);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    ASSERT_LT(body::Angle_rad(poses[i].rotations[0], expected[i].rotations[0]), 1e-3F);
  }
  const auto named = BindClip(clip, {.up = ParseUp("z").value()});
  EXPECT_EQ(named.value().remark, "");
  EXPECT_LT((rig::UpOf(named.value().binding) - Vec3::UnitZ()).norm(), 1e-5F);
  const auto lying = BindClip(clip, {.up = ParseUp("y").value()});
  EXPECT_LT((rig::UpOf(lying.value().binding) - Vec3::UnitY()).norm(), 1e-5F);
  for (const char* const wrong : {"", "-", "+", "w", "zz", "up", "--z"}) {
    EXPECT_THAT(ParseUp(wrong).status().message(), HasSubstr("expected auto, x, y, z")) << wrong;
  }
  EXPECT_FALSE(ParseUp("auto").value());
  EXPECT_LT((*ParseUp("-x").value() + Vec3::UnitX()).norm(), 1e-6F);
}

}  // namespace
}  // namespace styled::clip
