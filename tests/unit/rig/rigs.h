#pragma once

#include <string>
#include <utility>
#include <vector>

#include "model/rig/binding.h"
#include "tests/unit/body/random_pose.h"

namespace styled::rig {

using body::Angle_rad;
using body::kHumanoid;
using body::kJointCount;
using body::Random;

// The canonical humanoid as a source skeleton; joint c is canonical joint c.
inline Skeleton HumanoidSkeleton() {
  Skeleton skeleton;
  for (int c = 0; c < kJointCount; ++c) {
    skeleton.names.emplace_back(kHumanoid[c].name);
    skeleton.parents.push_back(kHumanoid[c].parent);
    skeleton.offsets.push_back(body::Offset(c));
  }
  return skeleton;
}

// Hangs what is below the left upper leg from the hips under names that say nothing, so that
// neither the tree nor names find the lower leg.
inline void LoseLeftLeg(Skeleton& skeleton) {
  for (const int c : {body::kLeftLowerLeg, body::kLeftFoot, body::kLeftToes}) {
    skeleton.names[static_cast<std::size_t>(c)] = "wheel" + std::to_string(c);
    skeleton.parents[static_cast<std::size_t>(c)] = body::kHips;
  }
}

inline BindingSpec HumanoidSpec() {
  BindingSpec spec;
  spec.skeleton = HumanoidSkeleton();
  for (int c = 0; c < kJointCount; ++c) spec.source_joint[c] = c;
  spec.rest_rotations.assign(kJointCount, Quat::Identity());
  return spec;
}

// The same body as another rig: other axes, another unit, arbitrary joint frames at rest, a locator
// above the hips, a twist joint in each upper arm, and a finger.
struct StrangeRig {
  BindingSpec spec;
  int locator = 0, twist = -1, finger = -1;
};
inline StrangeRig MakeStrangeRig(Random& random, float units_per_metre) {
  StrangeRig rig;
  const Quat canonical_from_source = random.Turn(3.0F);
  rig.spec.canonical_from_source = canonical_from_source;
  Skeleton& skeleton = rig.spec.skeleton;
  std::vector<Vec3> positions;  // T-pose, source axes and units
  const auto add = [&](const std::string& name, int parent, const Vec3& position_m) {
    skeleton.names.push_back(name);
    skeleton.parents.push_back(parent);
    positions.push_back(units_per_metre * (canonical_from_source.conjugate() * position_m));
    rig.spec.rest_rotations.push_back(random.Turn(3.0F));
    return skeleton.joint_count() - 1;
  };
  body::WorldPose rest;
  body::ForwardKinematics(body::Pose(), rest);
  rig.locator = add("locator", -1, Vec3(0.3F, 0.1F, -0.2F));
  for (int c = 0; c < kJointCount; ++c) {
    int parent = c == 0 ? rig.locator : rig.spec.source_joint[kHumanoid[c].parent];
    if (c == body::kLeftLowerArm || c == body::kRightLowerArm) {
      const Vec3 half = 0.5F * (rest.positions_m[c] + rest.positions_m[c - 1]);
      parent = rig.twist = add("twist", parent, half);
    }
    rig.spec.source_joint[c] = add(std::string(kHumanoid[c].name), parent, rest.positions_m[c]);
  }
  rig.finger = add("finger", rig.spec.source_joint[body::kLeftHand],
                   rest.positions_m[body::kLeftHand] + Vec3(0.1F, 0, 0));
  for (int joint = 0; joint < skeleton.joint_count(); ++joint) {
    const int parent = skeleton.parents[joint];
    skeleton.offsets.push_back(parent < 0 ? positions[joint]
                                          : rig.spec.rest_rotations[parent].conjugate() *
                                                (positions[joint] - positions[parent]));
  }
  return rig;
}

// A random pose of a rig, with its root at any place.
inline RigPose AnyRigPose(const Skeleton& skeleton, Random& random, float reach) {
  RigPose pose(skeleton);
  for (Quat& q : pose.rotations) q = random.Turn(3.0F);
  pose.translations[0] += random.Vector(reach);
  return pose;
}

}  // namespace styled::rig
