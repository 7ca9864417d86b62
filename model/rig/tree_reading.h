#pragma once

#include <array>
#include <limits>
#include <optional>
#include <vector>

#include "model/body/humanoid.h"
#include "model/rig/name_reading.h"
#include "model/rig/skeleton.h"

// Reads a skeleton's tree as a humanoid: pairs of limbs, a trunk, a head. Part of FindHumanoid
// (rig/find_humanoid.h), which chooses among the readings. Allocates; one thread.
namespace styled::rig {

// Per canonical joint the skeleton's; -1 if it has none.
using JointMap = std::array<int, body::kJointCount>;
// Joints set by hand; -1 says that the skeleton has none.
using GivenJoints = std::array<std::optional<int>, body::kJointCount>;

// The parts of the trunk, from the hips to the head.
constexpr bool IsTrunk(Part part) { return part <= Part::kHead; }
inline constexpr std::uint16_t kTrunkParts =
    (1U << (static_cast<unsigned>(Part::kHead) + 1U)) - 1U;  // as bits of a NameReading

enum Kind { kArm, kLeg };
// The joints of a limb, from the trunk outwards: a shoulder if it is an arm, the two long bones, a
// hand or a foot, toes if it is a leg.
enum Place { kFirst, kUpper, kLower, kEnd, kTip, kPlaces };

struct Limb {
  std::array<int, kPlaces> joints{-1, -1, -1, -1, -1};
  float score = 0, upper = 0, lower = 0;  // lengths in source units
  int side = 0;                           // the sum of what its names say, see NameReading
};
// Two limbs that begin at two children of one joint.
struct LimbPair {
  Limb a, b;
  int parent = -1, root_a = -1, root_b = -1;
  float score = 0;
};
struct TreeReading {
  LimbPair arms, legs;
  int hips = -1, neck = -1, head = -1;
  int other_head = -1;  // the best head on another branch, and how far it is behind
  float head_lead = std::numeric_limits<float>::infinity();
  float score = -std::numeric_limits<float>::infinity();
};

// Which part of the names counts: all they say; only that a joint is a helper (hair, the end of a
// bone); nothing but the ends of bones.
enum class NameUse { kAll, kHelpers, kNone };

// The likely readings of a skeleton whose parents precede their children, the best first. Scores
// are log-likelihoods up to a constant: of two readings that differ by 1, one is e times as likely.
// `named`: what tables of conventions say. Joints given by hand always count.
std::vector<TreeReading> ReadTree(const Skeleton& skeleton, const std::vector<NameReading>& names,
                                  const JointMap& named, NameUse use, const GivenJoints& given);

}  // namespace styled::rig
