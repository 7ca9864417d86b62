#pragma once

#include <string>
#include <vector>

#include "model/rig/binding.h"
#include "model/rig/dialects.h"

namespace styled::rig {

// How the performer stands during calibration: looking ahead, soles flat on the floor; arms
// sideways with palms down (T), or hanging with palms at the thighs (N).
enum class StandingPose { kT, kN };

// The angle between a bone and its expected direction.
struct BoneAngle {
  std::string joint;  // the source's name of it
  float degrees = 0;
};

struct Calibrated {
  // The rig's axes are left-handed (rare: decoders convert known ones). `spec` then describes the
  // skeleton mirrored through x = 0, and poses must be mirrored on the way in and out.
  bool mirrored = false;
  BindingSpec spec;
  std::vector<BoneAngle> bones;  // the bones that were checked, the worst first
};

// Makes a binding for a skeleton of unknown rest pose, from one pose of a performer who stands as
// requested. The up axis is the source axis nearest to the spine; left is from limb to limb;
// forward is where the performer looks, and becomes the canonical +Z. A skeleton whose toes point
// backward is left-handed and is mirrored. The rest rotations are RestBySwing's for this pose.
// Joints are found by MapJoints. Refuses a skeleton whose joints are not found, a bone more than 30
// degrees off, what Binding::Make refuses, and a bone that then points elsewhere than on the
// humanoid (WrongBone); the error names the worst joint and what was expected. Allocates; any
// thread. Pinned by tests/unit/rig/calibration_test.cpp.
Result<Calibrated> Calibrate(const Skeleton& skeleton, const RigPose& standing, StandingPose pose,
                             const JointNames& given = {});

// Makes the binding of an avatar, a skeleton without a performer, from the pose in its file:
// upright, soles flat on the floor, in the T-pose (`t_pose`) or with its arms anywhere, in which
// case RestBySwing finds the T-pose. Finds the axes as Calibrate does. Refuses what Binding::Make
// refuses, a back or a leg more than 30 degrees off, in a T-pose also an arm, and left-handed axes.
// `worst_deg`, if given, is how far the worst of these is off, where the binding is made.
// Allocates; any thread.
Result<Binding> BindStanding(const Skeleton& skeleton,
                             const std::array<int, body::kJointCount>& source_joint,
                             const RigPose& standing, bool t_pose, float* worst_deg = nullptr);

// Whether the skeleton has the joints that Calibrate needs; the error names the missing ones.
Status CanCalibrate(const Skeleton& skeleton, const JointNames& given = {});
Status CanCalibrate(const std::array<int, body::kJointCount>& map);

}  // namespace styled::rig
