#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "model/base/realtime.h"
#include "model/base/status.h"
#include "model/rig/skeleton.h"
#include "proto/rigs/natnet/frame.h"
#include "proto/rigs/natnet/model.h"

// Interprets NatNet's skeletons: their bones and their poses. Pipeline thread. Pinned by
// tests/unit/natnet/skeleton_test.cpp.
namespace styled::source {

// The server's streaming settings, which its packets do not state.
struct NatNetConvention {
  bool local = false;  // bones are relative to their parents, not to the volume
  bool z_up = false;   // the volume is +Z up, not +Y up
  friend bool operator==(const NatNetConvention&, const NatNetConvention&) = default;
};

// A described skeleton, converted to +Y up.
class NatNetSkeleton {
 public:
  // Errors: no bones, several roots, an unknown parent, a cycle.
  static Result<NatNetSkeleton> Make(const natnet::SkeletonDescription& description);

  // Joint names without the skeleton's own name as prefix; +Y up, metres, identity rest rotations.
  const rig::RigBody& body() const { return body_; }

  // Converts `bones`, given in `convention`, to local rotations and the root's position. A joint
  // becomes NaN if its bone is missing, is not tracked (considered only if `flags` is set) or has
  // no valid rotation; in global coordinates its children become NaN, too. An untracked root leaves
  // `pose.translations` unchanged.
  STYLED_REALTIME void Convert(const natnet::Skeleton& bones, NatNetConvention convention,
                               bool flags, rig::RigPose& pose) noexcept;

  // Adds to misfits[2 * local + z_up], for each convention, the distance of the bones from their
  // described offsets if the convention held: metres, summed over bones. Bones that are not finite
  // are skipped.
  STYLED_REALTIME void AddMisfits(const natnet::Skeleton& bones, bool flags,
                                  std::array<float, 4>& misfits) const noexcept;

 private:
  // The bone of joint `j`; null if it cannot be used.
  const natnet::Bone* Find(const natnet::Skeleton& bones, std::size_t j, bool flags) const noexcept;

  rig::RigBody body_;
  std::vector<std::int32_t> ids_;  // bone ids, per joint
  // Index of the joint's bone in the description, and usually in frames.
  std::vector<std::size_t> places_;
  std::vector<rig::Quat> world_;  // workspace of Convert()
};

// The pose of a rigid body, which is always global: +Y up, metres.
STYLED_REALTIME void ConvertRigidBody(const natnet::Bone& body, NatNetConvention convention,
                                      rig::Vec3& position, rig::Quat& rotation) noexcept;

// Detects the convention in every frame, by how well each convention reproduces the skeletons' bone
// lengths: an operator may change it on the server at any time.
class NatNetConventionFinder {
 public:
  // Each argument is "auto" or a fixed value: "global", "local"; "y", "z".
  NatNetConventionFinder(const std::string& coordinates, const std::string& up);

  // Evaluates the misfits of one frame. Returns true if the convention changes: at the first
  // conclusive frame, later when ten conclusive frames in a row agree on another one.
  STYLED_REALTIME bool Evaluate(const std::array<float, 4>& misfits) noexcept;
  // False before the first conclusive frame, unless both settings are fixed.
  bool known() const { return known_; }
  NatNetConvention convention() const { return {(current_ & 2U) != 0, (current_ & 1U) != 0}; }

 private:
  std::array<bool, 4> allowed_{};
  std::size_t current_ = 0, other_ = 0;
  int others_ = 0;  // consecutive conclusive frames for `other_`
  bool known_ = false;
};

}  // namespace styled::source
