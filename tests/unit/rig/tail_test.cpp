// Fingers, eyes and jaw of a bound skeleton, in the canonical humanoid's T-pose and back.
#include "model/rig/tail.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/unit/rig/rigs.h"

namespace styled::rig {
namespace {

// A strange rig (other axes, unit and joint frames) with an index finger of three joints behind a
// carpal, a thumb without its first joint, and eyes behind a face.
struct Gloved {
  StrangeRig rig;
  TailMap map = NoTail();
  int carpal = 0;
  std::vector<Vec3> places_m;  // of the tail's joints in the T-pose, canonical axes
};
constexpr int kIndex = kTailLeftThumb + 3;

Gloved MakeGloved(Random& random, float units_per_metre) {
  Gloved made;
  made.rig = MakeStrangeRig(random, units_per_metre);
  BindingSpec& spec = made.rig.spec;
  body::WorldPose rest;
  body::ForwardKinematics(body::Pose(), rest);
  std::vector<Vec3> places(spec.skeleton.names.size());
  for (int c = 0; c < kJointCount; ++c) places[spec.source_joint[c]] = rest.positions_m[c];
  const auto add = [&](const std::string& name, int parent, const Vec3& from_m) {
    const Vec3 offset = spec.canonical_from_source.conjugate() * (units_per_metre * from_m);
    spec.skeleton.names.push_back(name);
    spec.skeleton.parents.push_back(parent);
    spec.skeleton.offsets.push_back(spec.rest_rotations[parent].conjugate() * offset);
    spec.rest_rotations.push_back(random.Turn(3.0F));
    places.push_back(places[parent] + from_m);
    return spec.skeleton.joint_count() - 1;
  };
  const int hand = spec.source_joint[body::kLeftHand], head = spec.source_joint[body::kHead];
  made.carpal = add("carpal", hand, {0.03F, 0, 0.01F});
  int joint = made.carpal;
  for (int i = 0; i < 3; ++i) {
    joint = made.map[kIndex + i] = add("index" + std::to_string(i), joint, {0.03F, 0.001F, 0});
  }
  joint = made.map[kTailLeftThumb + 1] = add("thumb2", hand, {0.02F, -0.01F, 0.03F});
  made.map[kTailLeftThumb + 2] = add("thumb3", joint, {0.02F, 0, 0.02F});
  const int face = add("face", head, {0, 0.05F, 0.05F});
  made.map[kTailLeftEye] = add("eye", face, {0.03F, 0, 0.02F});
  made.map[kTailJaw] = add("jaw", face, {0, -0.05F, 0});
  made.places_m = places;
  return made;
}

Binding Bound(const Gloved& gloved) {
  auto binding = Binding::Make(gloved.rig.spec);
  EXPECT_TRUE(binding.ok()) << binding.status().message();
  return std::move(binding.value());
}

std::vector<Quat> Identities(const Tail& tail) { return {tail.size(), Quat::Identity()}; }

TEST(Tail, LeavesOutWhatTheSkeletonCannotHave) {
  Random random(1);
  const Gloved gloved = MakeGloved(random, 1);
  const Binding binding = Bound(gloved);
  EXPECT_EQ(Tail().size(), 0U);
  EXPECT_EQ(Tail::Make(binding, NoTail()).size(), 0U);
  TailMap wrong = NoTail();
  wrong[kTailLeftEye] = binding.skeleton().joint_count();           // does not exist
  wrong[kTailRightEye] = binding.spec().source_joint[body::kNeck];  // the humanoid's own
  wrong[kTailJaw] = gloved.map[kIndex];                             // not on the head
  wrong[kTailRightThumb] = gloved.map[kTailLeftThumb + 1];          // of the other hand
  wrong[kIndex] = gloved.map[kIndex + 1];                           // in the wrong order
  wrong[kIndex + 1] = gloved.map[kIndex];
  const Tail tail = Tail::Make(binding, wrong);
  ASSERT_EQ(tail.size(), 1U);
  EXPECT_EQ(tail.joints()[0].joint, kIndex);
  TailMap left = NoTail();
  left[kIndex] = gloved.map[kIndex + 1];
  EXPECT_EQ(tail.map(), left);
}

TEST(Tail, StandsInTheTPoseWhereTheBonesAre) {
  Random random(2);
  for (const float units_per_metre : {1.0F, 100.0F}) {
    const Gloved gloved = MakeGloved(random, units_per_metre);
    const Binding binding = Bound(gloved);
    const Tail tail = Tail::Make(binding, gloved.map);
    ASSERT_EQ(tail.size(), 7U);
    EXPECT_EQ(tail.map(), gloved.map);
    // The T-pose as local rotations.
    RigPose pose(binding.skeleton());
    const auto& rest = binding.spec().rest_rotations;
    for (std::size_t j = 0; j < rest.size(); ++j) {
      const int parent = binding.skeleton().parents[j];
      pose.rotations[j] = parent < 0 ? rest[j] : rest[parent].conjugate() * rest[j];
    }
    auto read = Identities(tail);
    tail.Read(pose.rotations, read);
    for (std::size_t i = 0; i < tail.size(); ++i) {
      EXPECT_LT(Angle_rad(read[i], Quat::Identity()), 1e-3F);
      const Tail::Joint& joint = tail.joints()[i];
      const int source = gloved.map[joint.joint];
      const int above = joint.parent < kJointCount
                            ? binding.spec().source_joint[joint.parent]
                            : gloved.map[tail.joints()[joint.parent - kJointCount].joint];
      const Vec3 expected = gloved.places_m[source] - gloved.places_m[above];
      EXPECT_LT((joint.offset_m - expected).norm(), 1e-5F) << kTailNames[joint.joint];
    }
  }
}

// The rotations from Read are the change from the T-pose relative to the hand's, composed along the
// finger.
TEST(Tail, ReadsTheChangeRelativeToTheHandWhateverIsBetween) {
  Random random(3);
  const Gloved gloved = MakeGloved(random, 100);
  const Binding binding = Bound(gloved);
  const Tail tail = Tail::Make(binding, gloved.map);
  std::vector<Vec3> positions;
  std::vector<Quat> worlds;
  for (int round = 0; round < 20; ++round) {
    const RigPose pose = AnyRigPose(binding.skeleton(), random, 1);
    WorldTransforms(binding.skeleton(), pose, positions, worlds);
    const auto change = [&](int source) {
      const Quat& axes = binding.spec().canonical_from_source;
      return axes * (worlds[source] * binding.spec().rest_rotations[source].conjugate()) *
             axes.conjugate();
    };
    auto read = Identities(tail);
    tail.Read(pose.rotations, read);
    std::vector<Quat> world(kJointCount + tail.size());
    for (int c = 0; c < kJointCount; ++c) world[c] = change(binding.spec().source_joint[c]);
    for (std::size_t i = 0; i < tail.size(); ++i) {
      const Tail::Joint& joint = tail.joints()[i];
      world[kJointCount + i] = world[joint.parent] * read[i];
      EXPECT_LT(Angle_rad(world[kJointCount + i], change(gloved.map[joint.joint])), 2e-3F);
      EXPECT_NEAR(read[i].norm(), 1, 1e-5F);
    }
  }
}

TEST(Tail, IsContinuousInSign) {
  Random random(4);
  const Gloved gloved = MakeGloved(random, 1);
  const Binding binding = Bound(gloved);
  const Tail tail = Tail::Make(binding, gloved.map);
  RigPose pose = AnyRigPose(binding.skeleton(), random, 1);
  auto read = Identities(tail);
  tail.Read(pose.rotations, read);
  const auto before = read;
  for (Quat& rotation : pose.rotations) rotation.coeffs() = -rotation.coeffs();
  tail.Read(pose.rotations, read);
  for (std::size_t i = 0; i < tail.size(); ++i) EXPECT_GT(before[i].dot(read[i]), 0.99F);
}

// Two strange rigs have the same fingers where one writes what the other reads, and nothing else
// of the second moves.
TEST(Tail, WritesOntoAnotherSkeletonWhatWasRead) {
  Random random(5);
  const Gloved from = MakeGloved(random, 1), to = MakeGloved(random, 100);
  const Binding reading = Bound(from), writing = Bound(to);
  TailMap shared = from.map;
  shared[kIndex] = -1;  // the second lacks it: its own stays, the next one turns as much
  const Tail source = Tail::Make(reading, Both(from.map, shared));
  const Tail target = Tail::Make(writing, Both(to.map, shared));
  ASSERT_EQ(source.size(), 6U);
  ASSERT_EQ(target.size(), 6U);
  for (int round = 0; round < 20; ++round) {
    const RigPose pose = AnyRigPose(reading.skeleton(), random, 1);
    RigPose written = AnyRigPose(writing.skeleton(), random, 1);
    const RigPose before = written;
    auto read = Identities(source), again = Identities(target);
    source.Read(pose.rotations, read);
    target.Write(read, written.rotations);
    target.Read(written.rotations, again);
    for (std::size_t i = 0; i < read.size(); ++i) EXPECT_LT(Angle_rad(read[i], again[i]), 2e-3F);
    for (std::size_t j = 0; j < before.rotations.size(); ++j) {
      const auto* const end = target.map().end();
      if (std::find(target.map().begin(), end, static_cast<int>(j)) != end) continue;
      EXPECT_EQ(written.rotations[j].coeffs(), before.rotations[j].coeffs());
    }
  }
}

}  // namespace
}  // namespace styled::rig
