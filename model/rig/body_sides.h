#pragma once

#include <span>
#include <vector>

#include "model/rig/skeleton.h"
#include "model/rig/tree_reading.h"

// Which limbs are the left ones. Part of FindHumanoid (rig/find_humanoid.h). Allocates; one thread.
namespace styled::rig {

// Where the joints of a skeleton are in some poses (the zero pose if empty).
class Places {
 public:
  Places(const Skeleton& skeleton, std::span<const RigPose> poses);

  // How far leg a of a reading is to the left of leg b, as toes or bent knees have it: the mean
  // over the poses, -1 to 1; 0 if nothing tells.
  float LeftOf(const TreeReading& reading) const;
  // Whether the first limbs of both pairs are on one side: the mean cosine between their lines.
  float Alike(const LimbPair& p, const LimbPair& q) const;

 private:
  std::vector<std::vector<Vec3>> positions_;
};

// Puts the left limbs of both pairs first: by names, else by toes or knees. Returns whether
// something tells them.
bool PutLeftFirst(TreeReading& reading, const Places& places);

}  // namespace styled::rig
