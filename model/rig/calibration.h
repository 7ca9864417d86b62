#pragma once

#include <string>
#include <vector>

#include "model/rig/binding.h"
#include "model/rig/dialects.h"

namespace styled::rig {

// How a performer stands while the rig is calibrated: looking ahead, soles flat on the floor, arms
// sideways with palms down (T), or hanging with palms at the thighs (N).
enum class StandingPose { kT, kN };

// How far a bone stood from where the pose has it.
struct BoneAngle {
  std::string joint;  // the source's name
  float degrees = 0;
};

struct Calibrated {
  // The rig's axes are left-handed (rare: decoders make what they know right-handed): `spec` is of
  // the skeleton mirrored through x = 0, and poses are to be mirrored on the way in and out.
  bool mirrored = false;
  BindingSpec spec;
  std::vector<BoneAngle> bones;  // of those judged, the worst first
};

// A binding for a skeleton of unknown rest pose, from one pose of a performer who stands as asked:
// the up axis is the source axis nearest to the spine, left is from limb to limb, forward is where
// the performer looks (+Z of the canonical humanoid from then on), a skeleton whose toes point
// backward is left-handed and mirrored, and the rest rotations are RestBySwing's of this very pose.
// Joints are mapped by name (MapJoints). Refuses what names do not map, and a bone more than 30
// degrees off: the error names the worst joint and what was expected. Allocates; any thread. Pinned
// by tests/unit/rig/calibration_test.cpp.
Result<Calibrated> Calibrate(const Skeleton& skeleton, const RigPose& standing, StandingPose pose,
                             const JointNames& given = {});

// The binding of a skeleton without a performer (an avatar's), from the pose that its file has
// it in: upright, soles flat on the floor, and in the T-pose (`t_pose`), or with its arms anywhere:
// then RestBySwing makes the T-pose. Axes are found as Calibrate does. Refuses what a binding
// refuses, a back or a leg more than 30 degrees off, in the T-pose an arm too, and left-handed
// axes.
Result<Binding> BindStanding(const Skeleton& skeleton,
                             const std::array<int, body::kJointCount>& source_joint,
                             const RigPose& standing, bool t_pose);

// Whether it has the joints for it; the error names those that are missing.
Status CanCalibrate(const Skeleton& skeleton, const JointNames& given = {});

}  // namespace styled::rig
