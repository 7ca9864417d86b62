#include "model/rig/mirror.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "model/rig/calibration.h"
#include "model/rig/dialect_rests.h"
#include "model/rig/dialects.h"
#include "model/rig/hands.h"
#include "model/rig/wrists.h"
#include "tests/unit/rig/random_bodies.h"
#include "tests/unit/rig/rigs.h"

namespace styled::rig {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

MirrorMap MapOf(const Binding& binding) {
  return {binding, FindTail(binding.skeleton(), binding.spec().source_joint)};
}

RigPose MirrorOf(const MirrorMap& map, const Skeleton& skeleton, const RigPose& pose) {
  RigPose mirrored(skeleton);
  map.Apply(pose, mirrored);
  return mirrored;
}

bool BothSidesHave(const Binding& binding, int c) {
  return binding.spec().source_joint[c] >= 0 &&
         binding.spec().source_joint[body::MirrorJoint(c)] >= 0;
}

// Joints that one side lacks leave their turn to the next one, so that world rotations are
// compared.
void ExpectTheCanonicalMirror(const Binding& binding, Random& random) {
  const MirrorMap map = MapOf(binding);
  for (int round = 0; round < 20; ++round) {
    const RigPose pose = AnyRigPose(binding.skeleton(), random, 2 / binding.scale());
    body::Pose expected, got;
    binding.Bind(pose, expected);
    body::Mirror(expected, expected);
    binding.Bind(MirrorOf(map, binding.skeleton(), pose), got);
    EXPECT_LT((got.hips_position_m - expected.hips_position_m).norm(), 2e-5);
    body::WorldPose expected_world, got_world;
    body::ForwardKinematics(expected, expected_world);
    body::ForwardKinematics(got, got_world);
    for (int c = 0; c < kJointCount; ++c) {
      if (!BothSidesHave(binding, c)) continue;
      EXPECT_LT(Angle_rad(got_world.rotations[c], expected_world.rotations[c]), 1e-5)
          << kHumanoid[c].name;
    }
  }
}

void ExpectTwiceIsOnce(const Binding& binding, Random& random) {
  const MirrorMap map = MapOf(binding);
  const RigPose pose = AnyRigPose(binding.skeleton(), random, 2 / binding.scale());
  const RigPose twice = MirrorOf(map, binding.skeleton(), MirrorOf(map, binding.skeleton(), pose));
  EXPECT_LT((twice.translations[0] - pose.translations[0]).norm() * binding.scale(), 2e-5);
  for (std::size_t j = 0; j < pose.rotations.size(); ++j) {
    // Not only the same rotation: the same sign.
    EXPECT_LT((twice.rotations[j].coeffs() - pose.rotations[j].coeffs()).norm(), 1e-5)
        << binding.skeleton().names[j];
  }
}

// A second person beside the first has no mirror image, and names that mean nothing may call other
// joints fingers.
bool IsSymmetric(const RandomBody& body) {
  return body.built.find("two people") == std::string::npos &&
         body.built.find("names shuffled") == std::string::npos;
}

Binding BindBodyOf(const RandomBody& body) {
  BindingSpec spec;
  spec.skeleton = body.skeleton;
  spec.source_joint = body.joint;
  spec.rest_rotations.assign(body.skeleton.names.size(), Quat::Identity());
  auto binding = Binding::Make(std::move(spec));
  EXPECT_TRUE(binding.ok()) << body.built << ": " << binding.status().message();
  return std::move(binding.value());
}

TEST(MirrorMap, TheBoundPoseIsTheCanonicalMirrorOnStrangeRigs) {
  Random random(1);
  for (int rig = 0; rig < 20; ++rig) {
    SCOPED_TRACE(rig);
    // Its locator is beside the middle line, and one hand has a finger.
    StrangeRig strange = MakeStrangeRig(random, rig % 2 == 0 ? 100 : 0.5F);
    ExpectTheCanonicalMirror(Binding::Make(strange.spec).value(), random);
  }
}

TEST(MirrorMap, TheBoundPoseIsTheCanonicalMirrorOnBodiesOfAllTools) {
  Random random(2);
  int bodies = 0;
  for (unsigned seed = 0; seed < 200; ++seed) {
    const RandomBody body = MakeRandomBody(seed);
    if (body.skeleton.joint_count() > kMaxSourceJoints) continue;
    SCOPED_TRACE(body.built);
    ExpectTheCanonicalMirror(BindBodyOf(body), random);
    ++bodies;
  }
  EXPECT_GT(bodies, 150);
}

TEST(MirrorMap, TheBoundPoseIsTheCanonicalMirrorInDialects) {
  Random random(3);
  for (const char* dialect : {"vrm", "canonical", "mixamo"}) {
    ExpectTheCanonicalMirror(BindDialect(HumanoidSkeleton(), dialect).value(), random);
  }
  // Z up, centimetres.
  Eigen::Matrix3f axes;
  axes << 0, 1, 0, 0, 0, 1, 1, 0, 0;  // canonical from source
  Skeleton xsens = HumanoidSkeleton();
  for (Vec3& offset : xsens.offsets) offset = 100 * (Quat(axes).conjugate() * offset);
  ExpectTheCanonicalMirror(BindDialect(xsens, "xsens").value(), random);
  // Rests of its own for each joint.
  Skeleton rokoko = HumanoidSkeleton();
  const auto rest = [](int c) {
    const RestRow& row = kRokokoRest[c];
    return Quat(row.w, row.x, row.y, row.z).normalized();
  };
  for (int c = 1; c < kJointCount; ++c) {
    rokoko.offsets[c] = rest(kHumanoid[c].parent).conjugate() * body::Offset(c);
  }
  ExpectTheCanonicalMirror(BindDialect(rokoko, "rokoko").value(), random);
}

// As the daemon holds one after a calibration: the skeleton and the poses are reflected at x = 0.
TEST(MirrorMap, TheBoundPoseIsTheCanonicalMirrorOnALeftHandedRig) {
  Skeleton skeleton = HumanoidSkeleton();
  for (Vec3& offset : skeleton.offsets) offset = Vec3(-offset.x(), offset.z(), offset.y());
  skeleton.offsets[body::kHips] = Vec3::Zero();
  auto calibrated = Calibrate(skeleton, RigPose(skeleton), StandingPose::kT);
  ASSERT_TRUE(calibrated.ok()) << calibrated.status().message();
  Random random(4);
  const Binding binding = Binding::Make(calibrated.value().spec).value();
  ExpectTheCanonicalMirror(binding, random);
  ExpectTwiceIsOnce(binding, random);
}

// The tree may begin at a foot: then no left joint has the way up of its right one.
TEST(MirrorMap, TheBoundPoseIsTheCanonicalMirrorIfTheTreeBeginsAtAFoot) {
  body::WorldPose rest;
  body::ForwardKinematics(body::Pose(), rest);
  BindingSpec spec;
  const std::array<int, 4> leg{body::kLeftFoot, body::kLeftLowerLeg, body::kLeftUpperLeg,
                               body::kHips};
  const auto add = [&](int c, int parent_joint) {
    spec.source_joint[static_cast<std::size_t>(c)] = spec.skeleton.joint_count();
    spec.skeleton.names.emplace_back(kHumanoid[c].name);
    spec.skeleton.parents.push_back(
        parent_joint < 0 ? -1 : spec.source_joint[static_cast<std::size_t>(parent_joint)]);
    const Vec3 from = parent_joint < 0 ? Vec3(Vec3::Zero()) : rest.positions_m[parent_joint];
    spec.skeleton.offsets.push_back(rest.positions_m[c] - from);
    spec.rest_rotations.push_back(Quat::Identity());
  };
  for (std::size_t i = 0; i < leg.size(); ++i) add(leg[i], i == 0 ? -1 : leg[i - 1]);
  for (int c = 1; c < kJointCount; ++c) {
    if (std::find(leg.begin(), leg.end(), c) == leg.end()) add(c, kHumanoid[c].parent);
  }
  Random random(5);
  ExpectTheCanonicalMirror(Binding::Make(spec).value(), random);
}

TEST(MirrorMap, TwiceGivesThePoseBack) {
  Random random(6);
  int bodies = 0;
  for (unsigned seed = 0; seed < 200; ++seed) {
    const RandomBody body = MakeRandomBody(seed);
    if (body.skeleton.joint_count() > kMaxSourceJoints || !IsSymmetric(body)) continue;
    SCOPED_TRACE(body.built);
    ExpectTwiceIsOnce(BindBodyOf(body), random);
    ++bodies;
  }
  EXPECT_GT(bodies, 100);
  StrangeRig strange = MakeStrangeRig(random, 100);
  const auto hand = strange.spec.skeleton.parents[static_cast<std::size_t>(strange.finger)];
  EXPECT_EQ(hand, strange.spec.source_joint[body::kLeftHand]);
  const Binding with_one_finger = Binding::Make(strange.spec).value();
  const MirrorMap map = MapOf(with_one_finger);
  EXPECT_EQ(map.pair(strange.finger), -1);
  // A finger on one hand has nothing to be mirrored from; everything else comes back.
  const RigPose pose = AnyRigPose(with_one_finger.skeleton(), random, 100);
  const RigPose twice =
      MirrorOf(map, with_one_finger.skeleton(), MirrorOf(map, with_one_finger.skeleton(), pose));
  for (int j = 0; j < with_one_finger.skeleton().joint_count(); ++j) {
    const auto at = static_cast<std::size_t>(j);
    const double apart = Angle_rad(twice.rotations[at], pose.rotations[at]);
    if (j == strange.finger) {
      EXPECT_GT(apart, 0.01);
    } else {
      EXPECT_LT(apart, 1e-5) << with_one_finger.skeleton().names[at];
    }
  }
}

TEST(MirrorMap, OnTheHumanoidItIsTheCanonicalMirrorBitForBit) {
  const Binding binding = Binding::Make(HumanoidSpec()).value();
  Random random(7);
  const body::Pose pose = random.AnyPose();
  RigPose given(binding.skeleton());
  std::copy(pose.rotations.begin(), pose.rotations.end(), given.rotations.begin());
  given.translations[0] = pose.hips_position_m;
  const RigPose mirrored = MirrorOf(MapOf(binding), binding.skeleton(), given);
  body::Pose expected;
  body::Mirror(pose, expected);
  for (std::size_t c = 0; c < kJointCount; ++c) {
    EXPECT_EQ(mirrored.rotations[c].coeffs(), expected.rotations[c].coeffs()) << c;
  }
  EXPECT_EQ(mirrored.translations[0], expected.hips_position_m);
}

// Twists, fingers, hair, skirts, wings and ends: every joint has the pair with the exchanged side.
TEST(MirrorMap, JointsBeyondTheHumanoidArePairedByTheirPlace) {
  int checked = 0;
  for (unsigned seed = 0; seed < 300; ++seed) {
    const RandomBody body = MakeRandomBody(seed);
    if (body.skeleton.joint_count() > kMaxSourceJoints || !IsSymmetric(body)) continue;
    const Binding binding = BindBodyOf(body);
    const MirrorMap map = MapOf(binding);
    std::vector<Vec3> places;
    std::vector<Quat> rotations;
    WorldTransforms(body.skeleton, RigPose(body.skeleton), places, rotations);
    for (int j = 0; j < body.skeleton.joint_count(); ++j) {
      ASSERT_GE(map.pair(j), 0) << body.built << ": " << body.skeleton.names[j];
      EXPECT_EQ(map.pair(map.pair(j)), j) << body.built << ": " << body.skeleton.names[j];
      const Vec3 expected = Mirrored(places[static_cast<std::size_t>(j)]);
      const Vec3& found = places[static_cast<std::size_t>(map.pair(j))];
      EXPECT_LT((found - expected).norm() * binding.scale(), 1e-4)
          << body.built << ": " << body.skeleton.names[j] << " and "
          << body.skeleton.names[map.pair(j)];
      ++checked;
    }
  }
  EXPECT_GT(checked, 10000);
}

// The humanoid with more joints; returns the new joint's number.
int AddJoint(BindingSpec& spec, const std::string& name, int parent, const Vec3& offset) {
  spec.skeleton.names.push_back(name);
  spec.skeleton.parents.push_back(parent);
  spec.skeleton.offsets.push_back(offset);
  spec.rest_rotations.push_back(Quat::Identity());
  return spec.skeleton.joint_count() - 1;
}

TEST(MirrorMap, AJointElsewhereIsNoPairAndTheNearestIsTaken) {
  BindingSpec spec = HumanoidSpec();
  const int left = AddJoint(spec, "badge", body::kChest, {0.08F, 0.1F, 0.1F});
  const int near = AddJoint(spec, "pin", body::kChest, {-0.085F, 0.1F, 0.1F});
  const int nearer = AddJoint(spec, "button", body::kChest, {-0.079F, 0.1F, 0.1F});
  const int far = AddJoint(spec, "bag", body::kHips, {0.3F, 0, 0});
  const int tie = AddJoint(spec, "tie", body::kChest, {0, -0.1F, 0.1F});
  const MirrorMap map = MapOf(Binding::Make(spec).value());
  EXPECT_EQ(map.pair(left), nearer);
  EXPECT_EQ(map.pair(nearer), left);
  EXPECT_EQ(map.pair(near), -1);
  EXPECT_EQ(map.pair(far), -1);
  EXPECT_EQ(map.pair(tie), tie);
}

// As in CMU's skeletons: both legs and the back hang from joints at the place of the hips.
TEST(MirrorMap, HelpersAtThePlaceOfTheirParentArePairedByTheLimbsBelowThem) {
  BindingSpec spec;
  int left = -1, right = -1, back = -1;
  for (int c = 0; c < kJointCount; ++c) {
    int parent = c == 0 ? -1 : spec.source_joint[kHumanoid[c].parent];
    if (c == body::kSpine) parent = back = AddJoint(spec, "back", parent, Vec3::Zero());
    if (c == body::kLeftUpperLeg) parent = left = AddJoint(spec, "left", parent, Vec3::Zero());
    if (c == body::kRightUpperLeg) parent = right = AddJoint(spec, "right", parent, Vec3::Zero());
    spec.source_joint[c] = AddJoint(spec, std::string(kHumanoid[c].name), parent, body::Offset(c));
  }
  const Binding binding = Binding::Make(spec).value();
  const MirrorMap map = MapOf(binding);
  EXPECT_EQ(map.pair(left), right);
  EXPECT_EQ(map.pair(right), left);
  EXPECT_EQ(map.pair(back), back);
  Random random(12);
  ExpectTheCanonicalMirror(binding, random);
  ExpectTwiceIsOnce(binding, random);
}

// The left lower arm hangs from a twist joint, the right one from the upper arm itself.
TEST(MirrorMap, AJointOnOneSideAloneIsComposed) {
  body::WorldPose rest;
  body::ForwardKinematics(body::Pose(), rest);
  BindingSpec spec;
  int twist = -1;
  for (int c = 0; c < kJointCount; ++c) {
    int parent = c == 0 ? -1 : spec.source_joint[kHumanoid[c].parent];
    Vec3 offset = body::Offset(c);
    if (c == body::kLeftLowerArm) {
      offset *= 0.5F;
      parent = twist = AddJoint(spec, "twist", parent, offset);
    }
    spec.source_joint[c] = AddJoint(spec, std::string(kHumanoid[c].name), parent, offset);
  }
  const Binding binding = Binding::Make(spec).value();
  Random random(8);
  ExpectTheCanonicalMirror(binding, random);
  const MirrorMap map = MapOf(binding);
  EXPECT_EQ(map.pair(twist), -1);
  const RigPose mirrored =
      MirrorOf(map, binding.skeleton(), AnyRigPose(binding.skeleton(), random, 1));
  EXPECT_LT(Angle_rad(mirrored.rotations[static_cast<std::size_t>(twist)], Quat::Identity()), 1e-6)
      << "it follows the upper arm rigidly";
}

TEST(MirrorMap, FingersChangeHands) {
  const Binding plain = Binding::Make(HumanoidSpec()).value();
  const Binding binding = WithFingers(plain, TailSet().set());
  const MirrorMap map = MapOf(binding);
  const Tail tail = Tail::Make(binding, FindTail(binding.skeleton(), binding.spec().source_joint));
  ASSERT_EQ(tail.size(), 2U * kHandTail);
  Random random(9);
  const RigPose pose = AnyRigPose(binding.skeleton(), random, 1);
  std::vector<Quat> before(tail.size(), Quat::Identity()), after = before;
  tail.Read(pose.rotations, before);
  tail.Read(MirrorOf(map, binding.skeleton(), pose).rotations, after);
  for (std::size_t i = 0; i < kHandTail; ++i) {
    for (const auto& [from, to] : {std::pair{i, i + kHandTail}, std::pair{i + kHandTail, i}}) {
      EXPECT_LT(Angle_rad(after[to], Mirrored(before[from])), 1e-5)
          << kTailNames[static_cast<std::size_t>(tail.joints()[to].joint)];
    }
  }
}

TEST(MirrorMap, AJointThatIsNotTrackedIsUntrackedInItsPairAlone) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    const RandomBody body = MakeRandomBody(seed);
    if (body.skeleton.joint_count() > kMaxSourceJoints) continue;
    const Binding binding = BindBodyOf(body);
    const MirrorMap map = MapOf(binding);
    Random random(seed);
    const RigPose pose = AnyRigPose(binding.skeleton(), random, 1);
    for (int j = 0; j < binding.skeleton().joint_count(); ++j) {
      RigPose broken = pose;
      broken.rotations[static_cast<std::size_t>(j)].coeffs().setConstant(kNan);
      const RigPose mirrored = MirrorOf(map, binding.skeleton(), broken);
      EXPECT_TRUE(mirrored.translations[0].allFinite());
      for (int k = 0; k < binding.skeleton().joint_count(); ++k) {
        EXPECT_EQ(mirrored.rotations[static_cast<std::size_t>(k)].coeffs().allFinite(),
                  map.pair(k) != j)
            << body.built << ": " << body.skeleton.names[j] << ", " << body.skeleton.names[k];
      }
    }
  }
}

// Each joint turns by two turns, so that its quaternion passes every sign.
TEST(MirrorMap, SignsStayContinuous) {
  Random random(10);
  StrangeRig strange = MakeStrangeRig(random, 100);
  const Binding binding = Binding::Make(strange.spec).value();
  const MirrorMap map = MapOf(binding);
  const RigPose start = AnyRigPose(binding.skeleton(), random, 1);
  std::vector<Vec3> axes;
  for (std::size_t j = 0; j < start.rotations.size(); ++j) {
    axes.push_back(random.Vector(1).normalized());
  }
  RigPose last = MirrorOf(map, binding.skeleton(), start);
  for (int i = 1; i <= 360; ++i) {
    RigPose pose = start;
    for (std::size_t j = 0; j < axes.size(); ++j) {
      const float half_rad = static_cast<float>(i) * 0.0174533F;
      Quat turn;
      turn.w() = std::cos(half_rad);
      turn.vec() = std::sin(half_rad) * axes[j];
      pose.rotations[j] = start.rotations[j] * turn;
    }
    const RigPose mirrored = MirrorOf(map, binding.skeleton(), pose);
    for (std::size_t j = 0; j < axes.size(); ++j) {
      ASSERT_GT(mirrored.rotations[j].dot(last.rotations[j]), 0.9F) << i << " " << j;
    }
    last = mirrored;
  }
}

TEST(MirrorMap, AnObjectIsReflectedLikeTheBody) {
  Random random(11);
  for (int round = 0; round < 20; ++round) {
    StrangeRig strange = MakeStrangeRig(random, 100);
    const Binding binding = Binding::Make(strange.spec).value();
    const MirrorMap map = MapOf(binding);
    const Vec3 position = random.Vector(200);
    const Quat rotation = random.Turn(3);
    const Placed placed = ToCanonical(binding, position, rotation);
    const Placed got = ToCanonical(binding, map.Reflected(position), map.Reflected(rotation));
    EXPECT_LT((got.position_m - Mirrored(placed.position_m)).norm(), 1e-5);
    EXPECT_LT(Angle_rad(got.rotation, Mirrored(placed.rotation)), 1e-5);
    EXPECT_LT(Angle_rad(map.Reflected(Quat::Identity()), Quat::Identity()), 1e-6);
  }
  // Along an axis of the skeleton, signs change and nothing else does.
  Eigen::Matrix3f axes;
  axes << 0, 1, 0, 0, 0, 1, 1, 0, 0;  // canonical from source: left is +y
  Skeleton xsens = HumanoidSkeleton();
  for (Vec3& offset : xsens.offsets) offset = Quat(axes).conjugate() * offset;
  const MirrorMap map = MapOf(BindDialect(xsens, "xsens").value());
  const Vec3 position(0.1F, 0.2F, 0.3F);
  EXPECT_EQ(map.Reflected(position), Vec3(0.1F, -0.2F, 0.3F));
  const Quat rotation(0.7F, 0.1F, 0.5F, -0.5F);
  EXPECT_EQ(map.Reflected(rotation).coeffs(), Quat(0.7F, -0.1F, 0.5F, 0.5F).coeffs());
}

}  // namespace
}  // namespace styled::rig
