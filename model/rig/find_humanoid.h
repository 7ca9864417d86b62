#pragma once

#include <array>
#include <span>
#include <string>

#include "model/base/status.h"
#include "model/rig/dialects.h"
#include "model/rig/skeleton.h"

// Finds the canonical humanoid in a skeleton of any tool: by its tree first, by names where the
// tree leaves a choice.
namespace styled::rig {

struct HumanoidMap {
  std::array<int, body::kJointCount> joint;  // the skeleton's, per canonical joint; -1: it has none
  // 0 to 1: how far this reading is ahead of the next one. 1 where joints are given by hand.
  float confidence = 0;
  std::string reason;  // "by names and the tree", ...: a clause for users
  // What a user should know though the map is made: sides or names that contradict the tree, a
  // trunk without a joint. Sentences; "" if nothing.
  std::string remark;
};

// The tree: two pairs of limbs of like lengths, one at the hips, one at the chest, and a head above
// the chest. Each limb is read as (shoulder,) upper, lower, end (, toes), wherever helper joints
// lie between; lengths and names score each reading, and the best one is taken. Names decide which
// side is left; without them the toes, or knees that bend forward, in `poses` (the zero pose if
// empty). Joints `given` by hand are fixed.
//
// Where the names of several joints contradict the tree, the tree alone decides, with a remark. A
// skeleton without such a tree (hands alone, names alone) is mapped by names (MapJointNames), with
// confidence 0.
//
// Errors: those of `given` (MapJoints), and a doubt: a second reading as good as the first, or
// sides that nothing tells. Such an error names the joints and says how to give them. At most 1,024
// joints are read as a tree. 0.2 ms
// for 21 joints, 20 ms for 256 of the worst trees that were tried.
// Allocates; any thread. Pinned by tests/unit/rig/find_humanoid_test.cpp.
Result<HumanoidMap> FindHumanoid(const Skeleton& skeleton, const JointNames& given = {},
                                 std::span<const RigPose> poses = {});

}  // namespace styled::rig
