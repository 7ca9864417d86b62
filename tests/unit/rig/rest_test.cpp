#include <gtest/gtest.h>

#include <cmath>

#include "model/rig/binding.h"
#include "tests/unit/rig/rigs.h"

namespace styled::rig {
namespace {

constexpr float kQuarter = 1.57079633F;

// A standing performer: arms hanging with slightly bent elbows, knees a little bent, feet flat and
// turned outward. `yaw_rad`: the heading.
body::Pose Standing(float yaw_rad) {
  const auto about = [](const Vec3& axis, float angle) {
    return Quat(Eigen::AngleAxisf(angle, axis));
  };
  body::Pose pose;
  pose.rotations[body::kHips] = about(Vec3::UnitY(), yaw_rad);
  pose.rotations[body::kLeftUpperArm] = about(Vec3::UnitZ(), -1.3F);
  pose.rotations[body::kRightUpperArm] = about(Vec3::UnitZ(), 1.3F);
  pose.rotations[body::kLeftLowerArm] = about(Vec3::UnitY(), -0.3F);
  pose.rotations[body::kRightLowerArm] = about(Vec3::UnitY(), 0.3F);
  for (auto [upper, lower, foot, out] :
       {std::tuple{body::kLeftUpperLeg, body::kLeftLowerLeg, body::kLeftFoot, 0.2F},
        std::tuple{body::kRightUpperLeg, body::kRightLowerLeg, body::kRightFoot, -0.3F}}) {
    pose.rotations[upper] = about(Vec3::UnitX(), -0.1F);
    pose.rotations[lower] = about(Vec3::UnitX(), 0.2F);
    pose.rotations[foot] = about(Vec3::UnitX(), -0.1F) * about(Vec3::UnitY(), out);
  }
  return pose;
}

std::vector<Quat> RestOf(const StrangeRig& rig, const body::Pose& standing) {
  const Binding truth = Binding::Make(rig.spec).value();
  RigPose received(rig.spec.skeleton), source(rig.spec.skeleton);
  for (int joint = 1; joint < rig.spec.skeleton.joint_count(); ++joint) {
    received.rotations[joint] =
        rig.spec.rest_rotations[rig.spec.skeleton.parents[joint]].conjugate() *
        rig.spec.rest_rotations[joint];
  }
  truth.Unbind(standing, received, source);
  return RestBySwing(rig.spec.skeleton, rig.spec.source_joint, source,
                     rig.spec.canonical_from_source);
}

TEST(RestBySwing, ATPoseStaysThatTPose) {
  Random random(1);
  for (int round = 0; round < 20; ++round) {
    const StrangeRig rig = MakeStrangeRig(random, 100);
    const std::vector<Quat> rest = RestOf(rig, body::Pose());
    for (int c = 0; c < kJointCount; ++c) {
      const int joint = rig.spec.source_joint[c];
      EXPECT_LT(Angle_rad(rest[joint], rig.spec.rest_rotations[joint]), 1e-3) << kHumanoid[c].name;
    }
  }
}

TEST(RestBySwing, EveryBonePointsAlongItsTPoseDirectionForAnyHeading) {
  Random random(2);
  for (float yaw : {0.0F, 0.5F, -2.0F, 3.1F}) {
    const StrangeRig rig = MakeStrangeRig(random, 100);
    BindingSpec spec = rig.spec;
    spec.rest_rotations = RestOf(rig, Standing(yaw));
    std::vector<Vec3> positions(spec.skeleton.offsets);
    for (int joint = 1; joint < spec.skeleton.joint_count(); ++joint) {
      const int parent = spec.skeleton.parents[joint];
      positions[joint] =
          positions[parent] + spec.rest_rotations[parent] * spec.skeleton.offsets[joint];
    }
    for (int c = 1; c < kJointCount; ++c) {
      const int parent = kHumanoid[c].parent;
      const Vec3 bone = spec.canonical_from_source *
                        (positions[spec.source_joint[c]] - positions[spec.source_joint[parent]]);
      const float angle =
          std::acos(std::min(1.0F, bone.normalized().dot(body::Offset(c).normalized())));
      EXPECT_LT(angle, 2e-3) << kHumanoid[c].name << " facing " << yaw;
    }
  }
}

TEST(RestBySwing, KeepsElbowsAndKneesHingedAboutTheAxisTheyHave) {
  Random random(3);
  const StrangeRig rig = MakeStrangeRig(random, 100);
  BindingSpec spec = rig.spec;
  spec.rest_rotations = RestOf(rig, Standing(0));
  const Binding found = Binding::Make(spec).value();
  const Binding truth = Binding::Make(rig.spec).value();
  // The true body bends its elbow and its knee; through the found binding the same hinges must
  // bend.
  body::Pose bent = Standing(0), seen;
  bent.rotations[body::kLeftLowerArm] = Quat(Eigen::AngleAxisf(-kQuarter, Vec3::UnitY()));
  bent.rotations[body::kLeftLowerLeg] = Quat(Eigen::AngleAxisf(kQuarter, Vec3::UnitX()));
  RigPose source(rig.spec.skeleton);
  truth.Unbind(bent, RigPose(rig.spec.skeleton), source);
  found.Bind(source, seen);
  const Vec3 elbow = body::Log(seen.rotations[body::kLeftLowerArm]).normalized();
  const Vec3 knee = body::Log(seen.rotations[body::kLeftLowerLeg]).normalized();
  EXPECT_GT(elbow.dot(-Vec3::UnitY()), 0.95F);
  EXPECT_GT(knee.dot(Vec3::UnitX()), 0.95F);
}

TEST(RestBySwing, HandsToesAndFingersInheritTheSwingAboveThem) {
  Random random(4);
  const StrangeRig rig = MakeStrangeRig(random, 100);
  const std::vector<Quat> rest = RestOf(rig, Standing(0));
  const auto swing = [&](int joint) {  // from the true rest pose to the found one
    return rest[joint] * rig.spec.rest_rotations[joint].conjugate();
  };
  // Neither hand nor finger was rotated against the lower arm, so all three have the same error.
  const int lower_arm = rig.spec.source_joint[body::kLeftLowerArm];
  EXPECT_LT(Angle_rad(swing(lower_arm), swing(rig.spec.source_joint[body::kLeftHand])), 1e-3);
  EXPECT_LT(Angle_rad(swing(lower_arm), swing(rig.finger)), 1e-3);
  EXPECT_LT(Angle_rad(swing(rig.spec.source_joint[body::kLeftFoot]),
                      swing(rig.spec.source_joint[body::kLeftToes])),
            1e-3);
}

TEST(RestBySwing, GivesFlatFeetAnIdentityWhateverTheirShape) {
  // A foot that slopes down more steeply than the canonical one.
  BindingSpec spec = HumanoidSpec();
  spec.skeleton.offsets[body::kLeftToes] = Vec3(0, -0.13F, 0.07F);
  spec.rest_rotations =
      RestBySwing(spec.skeleton, spec.source_joint, RigPose(spec.skeleton), Quat::Identity());
  EXPECT_LT(Angle_rad(spec.rest_rotations[body::kLeftFoot], Quat::Identity()), 1e-5);
}

TEST(RestBySwing, StepsOverBonesOfNoLength) {
  // As in CMU's files: spine at the hips, neck and shoulders at the chest's end.
  BindingSpec spec = HumanoidSpec();
  spec.skeleton.offsets[body::kSpine].setZero();
  spec.skeleton.offsets[body::kLeftShoulder] = spec.skeleton.offsets[body::kRightShoulder] =
      Vec3(0, 0.15F, 0);
  for (const Quat& q :
       RestBySwing(spec.skeleton, spec.source_joint, RigPose(spec.skeleton), Quat::Identity())) {
    EXPECT_LT(Angle_rad(q, Quat::Identity()), 1e-4);
  }
}

TEST(RestBySwing, DoesWithHipsAndLegsAlone) {
  BindingSpec spec = HumanoidSpec();
  for (int c = 0; c < kJointCount; ++c) {
    if (c != body::kHips && c < body::kLeftUpperLeg) spec.source_joint[c] = -1;
  }
  for (const Quat& q :
       RestBySwing(spec.skeleton, spec.source_joint, RigPose(spec.skeleton), Quat::Identity())) {
    EXPECT_TRUE(q.coeffs().allFinite());
  }
}

}  // namespace
}  // namespace styled::rig
