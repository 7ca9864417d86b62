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

// What NatNet's skeletons mean: which bones they are made of, and where those are. Pipeline
// thread. Pinned by tests/unit/natnet/skeleton_test.cpp.
namespace styled::source {

// How a server was told to stream; its packets do not say.
struct NatNetConvention {
  bool local = false;  // bones count from their parents, not from the volume's origin
  bool z_up = false;   // the volume's up is +Z, not +Y
  friend bool operator==(const NatNetConvention&, const NatNetConvention&) = default;
};

// A skeleton as it was described, made +Y up.
class NatNetSkeleton {
 public:
  // Errors: no bones, several roots, a parent that there is not, a circle.
  static Result<NatNetSkeleton> Make(const natnet::SkeletonDescription& description);

  // Names without the skeleton's own before them; +Y up, metres, rest rotations identity.
  const rig::RigBody& body() const { return body_; }

  // Local rotations, and the root's place, of `bones` in `convention`. A bone that is missing, not
  // tracked (where `flags` may be believed) or no rotation is NaN in its joint, and in global
  // coordinates in its children. An untracked root leaves `pose.translations` alone.
  STYLED_REALTIME void Convert(const natnet::Skeleton& bones, NatNetConvention convention,
                               bool flags, rig::RigPose& pose) noexcept;

  // Adds, for each convention (index 2 * local + z_up), how far the bones stand from where the
  // description has them if the convention holds: metres, summed over bones. A bone that is not
  // finite is passed over.
  STYLED_REALTIME void AddMisfits(const natnet::Skeleton& bones, bool flags,
                                  std::array<float, 4>& misfits) const noexcept;

 private:
  // The bone of joint `j`; null where there is none to be used.
  const natnet::Bone* Find(const natnet::Skeleton& bones, std::size_t j, bool flags) const noexcept;

  rig::RigBody body_;
  std::vector<std::int32_t> ids_;    // per joint
  std::vector<std::size_t> places_;  // of the joint's bone in the description, so in frames
  std::vector<rig::Quat> world_;     // Convert()'s own
};

// Finds the convention by what fits the skeletons' measures, frame after frame: whoever stands at a
// server may change it at any time.
class NatNetConventionFinder {
 public:
  // "auto", or what is fixed: "global", "local"; "y", "z".
  NatNetConventionFinder(const std::string& coordinates, const std::string& up);

  // The misfits of one frame. True where the convention is another from now on: at the first frame
  // that tells, then when ten in a row tell otherwise.
  STYLED_REALTIME bool Take(const std::array<float, 4>& misfits) noexcept;
  // False before any frame told, unless there is nothing to find.
  bool known() const { return known_; }
  NatNetConvention convention() const { return {(current_ & 2U) != 0, (current_ & 1U) != 0}; }

 private:
  std::array<bool, 4> allowed_{};
  std::size_t current_ = 0, other_ = 0;
  int others_ = 0;  // frames in a row that told `other_`
  bool known_ = false;
};

}  // namespace styled::source
