#include "model/rig/binding.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "tests/unit/rig/rigs.h"

namespace styled::rig {
namespace {

using testing::HasSubstr;

constexpr double kHundredthDegree_rad = 0.01 * 3.14159265 / 180;

std::string Refusal(BindingSpec spec) {
  const Result<Binding> result = Binding::Make(std::move(spec));
  return result.ok() ? "accepted" : result.status().message();
}

TEST(BindingRefuses, AnEmptySkeleton) { EXPECT_THAT(Refusal({}), HasSubstr("no joints")); }

TEST(BindingRefuses, MoreJointsThanTheStackHolds) {
  BindingSpec spec = HumanoidSpec();
  while (spec.skeleton.joint_count() < kMaxSourceJoints) {
    spec.skeleton.names.emplace_back("finger");
    spec.skeleton.parents.push_back(body::kLeftHand);
    spec.skeleton.offsets.emplace_back(Vec3::Zero());
    spec.rest_rotations.push_back(Quat::Identity());
  }
  EXPECT_EQ(Refusal(spec), "accepted");
  spec.skeleton.names.emplace_back("one more");
  spec.skeleton.parents.push_back(0);
  spec.skeleton.offsets.emplace_back(Vec3::Zero());
  spec.rest_rotations.push_back(Quat::Identity());
  EXPECT_THAT(Refusal(spec), HasSubstr("found 257 joints, expected at most 256"));
}

TEST(BindingRefuses, VectorsOfDifferentLengths) {
  BindingSpec spec = HumanoidSpec();
  spec.skeleton.offsets.pop_back();
  EXPECT_THAT(Refusal(spec), HasSubstr("20 offsets"));
  spec = HumanoidSpec();
  spec.skeleton.parents.pop_back();
  EXPECT_THAT(Refusal(spec), HasSubstr("20 parents"));
  spec = HumanoidSpec();
  spec.rest_rotations.pop_back();
  EXPECT_THAT(Refusal(spec), HasSubstr("20 rest rotations"));
}

TEST(BindingRefuses, AParentThatDoesNotPrecedeItsChild) {
  BindingSpec spec = HumanoidSpec();
  spec.skeleton.parents[body::kSpine] = body::kChest;
  EXPECT_THAT(Refusal(spec), HasSubstr("joint 1 (spine): found parent 2"));
  spec = HumanoidSpec();
  spec.skeleton.parents[body::kSpine] = -1;
  EXPECT_THAT(Refusal(spec), HasSubstr("found parent -1, expected an earlier joint"));
  spec = HumanoidSpec();
  spec.skeleton.parents[0] = 0;
  EXPECT_THAT(Refusal(spec), HasSubstr("expected -1"));
}

TEST(BindingRefuses, AnOffsetThatIsNoLength) {
  for (float bad :
       {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(), -1e7F}) {
    BindingSpec spec = HumanoidSpec();
    spec.skeleton.offsets[body::kHead].y() = bad;
    EXPECT_THAT(Refusal(spec), HasSubstr("head: found an offset"));
  }
}

TEST(BindingRefuses, ARestRotationThatIsNotOfUnitLength) {
  BindingSpec spec = HumanoidSpec();
  spec.rest_rotations[body::kNeck].coeffs() *= 1.1F;
  EXPECT_THAT(Refusal(spec), HasSubstr("rest rotation of neck: found length 1.1"));
  spec.rest_rotations[body::kNeck].coeffs().setConstant(std::numeric_limits<float>::quiet_NaN());
  EXPECT_THAT(Refusal(spec), HasSubstr("rest rotation of neck"));
  spec = HumanoidSpec();
  spec.canonical_from_source.coeffs().setZero();
  EXPECT_THAT(Refusal(spec), HasSubstr("canonical_from_source"));
}

TEST(BindingRefuses, EachRequiredJointThatIsMissingByName) {
  for (int c : {body::kHips, body::kHead, body::kLeftUpperArm, body::kLeftLowerArm,
                body::kRightUpperArm, body::kRightLowerArm, body::kLeftUpperLeg,
                body::kLeftLowerLeg, body::kRightUpperLeg, body::kRightLowerLeg}) {
    BindingSpec spec = HumanoidSpec();
    spec.source_joint[c] = -1;
    EXPECT_EQ(Refusal(spec),
              "binding: found no source joint for " + std::string(kHumanoid[c].name));
  }
}

TEST(BindingRefuses, ASourceJointThatDoesNotExistOrIsGivenTwice) {
  BindingSpec spec = HumanoidSpec();
  spec.source_joint[body::kNeck] = kJointCount;
  EXPECT_THAT(Refusal(spec), HasSubstr("neck: found source joint 21, expected -1 to 20"));
  spec = HumanoidSpec();
  spec.source_joint[body::kNeck] = -2;
  EXPECT_THAT(Refusal(spec), HasSubstr("found source joint -2"));
  spec = HumanoidSpec();
  spec.source_joint[body::kNeck] = body::kHead;
  EXPECT_THAT(Refusal(spec), HasSubstr("found source joint head for neck and for head"));
}

TEST(BindingRefuses, ABodyWithoutFeetBelowItsHips) {
  BindingSpec spec = HumanoidSpec();
  for (int c : {body::kLeftFoot, body::kLeftToes, body::kRightFoot, body::kRightToes}) {
    spec.source_joint[c] = -1;
  }
  EXPECT_THAT(Refusal(spec), HasSubstr("no foot or toes below the hips"));
  spec = HumanoidSpec();
  spec.canonical_from_source = Quat(0, 0, 0, 1);  // upside down
  EXPECT_THAT(Refusal(spec), HasSubstr("no foot or toes below the hips"));
}

TEST(Binding, ScaleIsHipsHeightOverHipsHeight) {
  BindingSpec spec = HumanoidSpec();
  EXPECT_NEAR(Binding::Make(spec).value().scale(), 1, 1e-6);
  for (Vec3& offset : spec.skeleton.offsets) offset *= 250;
  EXPECT_NEAR(Binding::Make(spec).value().scale(), 0.004, 1e-6);
  // Without toes, ankle heights are compared.
  spec.source_joint[body::kLeftToes] = spec.source_joint[body::kRightToes] = -1;
  EXPECT_NEAR(Binding::Make(spec).value().scale(), 0.004, 1e-6);
}

TEST(Binding, TheCanonicalBodysBindingChangesNothing) {
  const Binding binding = Binding::Make(HumanoidSpec()).value();
  Random random(1);
  for (int round = 0; round < 100; ++round) {
    const RigPose source = AnyRigPose(binding.skeleton(), random, 10);
    body::Pose pose;
    binding.Bind(source, pose);
    EXPECT_TRUE(pose.hips_position_m.isApprox(source.translations[0], 1e-5F));
    for (int c = 0; c < kJointCount; ++c) {
      EXPECT_LT(Angle_rad(pose.rotations[c], source.rotations[c]), 1e-5);
      EXPECT_GE(pose.rotations[c].w(), 0);
    }
  }
}

TEST(Binding, TheRestPoseBecomesTheCanonicalRestPose) {
  Random random(2);
  for (int round = 0; round < 50; ++round) {
    const StrangeRig rig = MakeStrangeRig(random, 100);
    const Binding binding = Binding::Make(rig.spec).value();
    EXPECT_NEAR(binding.scale(), 0.01, 1e-6);
    RigPose rest(rig.spec.skeleton);
    for (int joint = 0; joint < rig.spec.skeleton.joint_count(); ++joint) {
      const int parent = rig.spec.skeleton.parents[joint];
      rest.rotations[joint] =
          parent < 0 ? rig.spec.rest_rotations[joint]
                     : rig.spec.rest_rotations[parent].conjugate() * rig.spec.rest_rotations[joint];
    }
    body::Pose pose;
    binding.Bind(rest, pose);
    EXPECT_NEAR((pose.hips_position_m - Vec3(0, 0.98F, 0)).norm(), 0, 1e-5);
    for (const Quat& q : pose.rotations) EXPECT_LT(Angle_rad(q, Quat::Identity()), 1e-5);
  }
}

TEST(Binding, ThereAndBackIsWithinAHundredthOfADegreeAndATenthOfAMillimetre) {
  Random random(3);
  for (int round = 0; round < 100; ++round) {
    const StrangeRig rig = MakeStrangeRig(random, 100);
    const Binding binding = Binding::Make(rig.spec).value();
    const RigPose source = AnyRigPose(rig.spec.skeleton, random, 1000);  // 10 m
    body::Pose pose;
    RigPose back(rig.spec.skeleton);
    binding.Bind(source, pose);
    binding.Unbind(pose, source, back);
    for (int joint = 0; joint < rig.spec.skeleton.joint_count(); ++joint) {
      EXPECT_LT(Angle_rad(back.rotations[joint], source.rotations[joint]), kHundredthDegree_rad);
      EXPECT_GE(back.rotations[joint].dot(source.rotations[joint]), 0) << "sign as received";
      EXPECT_LT((back.translations[joint] - source.translations[joint]).norm(), 0.01);  // cm
    }
    for (int joint : {rig.locator, rig.twist, rig.finger}) {
      EXPECT_EQ(back.rotations[joint].coeffs(), source.rotations[joint].coeffs()) << "untouched";
      EXPECT_EQ(back.translations[joint], source.translations[joint]) << "untouched";
    }
  }
}

TEST(Binding, BackAndThereGivesAnyCanonicalPoseBack) {
  Random random(4);
  for (int round = 0; round < 100; ++round) {
    const StrangeRig rig = MakeStrangeRig(random, 0.5F);
    const Binding binding = Binding::Make(rig.spec).value();
    const body::Pose wanted = random.AnyPose();
    const RigPose received = AnyRigPose(rig.spec.skeleton, random, 1);
    RigPose out(rig.spec.skeleton);
    body::Pose got;
    binding.Unbind(wanted, received, out);
    binding.Bind(out, got);
    EXPECT_LT((got.hips_position_m - wanted.hips_position_m).norm(), 1e-4);
    for (int c = 0; c < kJointCount; ++c) {
      EXPECT_LT(Angle_rad(got.rotations[c], wanted.rotations[c]), kHundredthDegree_rad);
    }
  }
}

// With the twist joint at rest, the rig's joints must be where the canonical ones are.
TEST(Binding, TheRigsJointsAreWhereTheCanonicalOnesAre) {
  Random random(5);
  for (int round = 0; round < 50; ++round) {
    const StrangeRig rig = MakeStrangeRig(random, 100);
    const Skeleton& skeleton = rig.spec.skeleton;
    const Binding binding = Binding::Make(rig.spec).value();
    RigPose received(skeleton);
    for (int joint = 1; joint < skeleton.joint_count(); ++joint) {
      received.rotations[joint] = rig.spec.rest_rotations[skeleton.parents[joint]].conjugate() *
                                  rig.spec.rest_rotations[joint];
    }
    const body::Pose pose = random.AnyPose();
    RigPose out(skeleton);
    binding.Unbind(pose, received, out);
    std::vector<Vec3> positions;
    std::vector<Quat> rotations;
    WorldTransforms(skeleton, out, positions, rotations);
    body::WorldPose world;
    body::ForwardKinematics(pose, world);
    for (int c = 0; c < kJointCount; ++c) {
      const Vec3 position_m =
          binding.scale() * (rig.spec.canonical_from_source * positions[rig.spec.source_joint[c]]);
      EXPECT_LT((position_m - world.positions_m[c]).norm(), 1e-4) << kHumanoid[c].name;
    }
  }
}

TEST(Binding, ComposesAJointThatTheHumanoidLacksIntoTheNextOneBelow) {
  Random random(6);
  const StrangeRig rig = MakeStrangeRig(random, 1);
  const Binding binding = Binding::Make(rig.spec).value();
  RigPose source = AnyRigPose(rig.spec.skeleton, random, 1);
  body::Pose before, after;
  binding.Bind(source, before);
  source.rotations[rig.twist] = source.rotations[rig.twist] * random.Turn(1);  // the right one
  binding.Bind(source, after);
  for (int c = 0; c < kJointCount; ++c) {
    const double changed_rad = Angle_rad(before.rotations[c], after.rotations[c]);
    if (c == body::kRightLowerArm) {
      EXPECT_GT(changed_rad, 0.01);
    } else {
      EXPECT_LT(changed_rad, 1e-5) << kHumanoid[c].name;
    }
  }
}

TEST(Binding, LeavesJointsThatTheSourceLacksAtRestAndKeepsTheirTurnsGoingOut) {
  BindingSpec spec = HumanoidSpec();
  for (int c : {body::kSpine, body::kNeck, body::kLeftShoulder}) spec.source_joint[c] = -1;
  const Binding binding = Binding::Make(spec).value();
  Random random(7);
  const RigPose source = AnyRigPose(spec.skeleton, random, 1);
  body::Pose pose;
  binding.Bind(source, pose);
  for (int c : {body::kSpine, body::kNeck, body::kLeftShoulder}) {
    EXPECT_EQ(pose.rotations[c].coeffs(), Quat::Identity().coeffs());
  }
  // A rotation of the missing spine must still reach the chest.
  RigPose straight(spec.skeleton), out(spec.skeleton);
  body::Pose bent;
  bent.rotations[body::kSpine] = random.Turn(1);
  binding.Unbind(bent, straight, out);
  EXPECT_LT(Angle_rad(out.rotations[body::kSpine], Quat::Identity()), 1e-6) << "as received";
  EXPECT_LT(Angle_rad(out.rotations[body::kChest], bent.rotations[body::kSpine]), 1e-5);
}

TEST(Binding, MovingAndTurningTheSourceMovesAndTurnsTheHipsOnly) {
  Random random(8);
  for (int round = 0; round < 50; ++round) {
    const StrangeRig rig = MakeStrangeRig(random, 100);
    const Binding binding = Binding::Make(rig.spec).value();
    const RigPose source = AnyRigPose(rig.spec.skeleton, random, 100);
    const Quat turn = random.Turn(3);
    const Vec3 shift_m = random.Vector(3);
    const Quat to_source = rig.spec.canonical_from_source.conjugate();
    const Quat source_turn = to_source * turn * rig.spec.canonical_from_source;
    RigPose moved = source;
    moved.rotations[0] = source_turn * source.rotations[0];
    moved.translations[0] =
        source_turn * source.translations[0] + to_source * shift_m / binding.scale();
    body::Pose a, b;
    binding.Bind(source, a);
    binding.Bind(moved, b);
    EXPECT_LT((turn * a.hips_position_m + shift_m - b.hips_position_m).norm(), 1e-4);
    EXPECT_LT(Angle_rad(turn * a.rotations[0], b.rotations[0]), 1e-5);
    for (int c = 1; c < kJointCount; ++c) {
      EXPECT_LT(Angle_rad(a.rotations[c], b.rotations[c]), 1e-5);
    }
  }
}

TEST(Binding, AMirroredPoseBecomesTheMirroredPose) {
  const Binding binding = Binding::Make(HumanoidSpec()).value();
  Random random(9);
  for (int round = 0; round < 50; ++round) {
    const body::Pose pose = random.AnyPose();
    body::Pose mirrored, got;
    body::Mirror(pose, mirrored);
    RigPose out(binding.skeleton());
    binding.Unbind(mirrored, RigPose(binding.skeleton()), out);
    binding.Bind(out, got);
    body::Mirror(got, got);
    for (int c = 0; c < kJointCount; ++c) {
      EXPECT_LT(Angle_rad(got.rotations[c], pose.rotations[c]), 1e-5);
    }
  }
}

}  // namespace
}  // namespace styled::rig
