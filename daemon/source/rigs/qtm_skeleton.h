#pragma once

#include <cstdint>
#include <vector>

#include "model/base/realtime.h"
#include "model/base/status.h"
#include "model/rig/skeleton.h"
#include "proto/rigs/qtm/frame.h"
#include "proto/rigs/qtm/parameters.h"

namespace styled::source {

// The rotation from QTM's axes, of which `up` points upwards, to +Y up. Right-handed both.
rig::Quat YUpFrom(qtm::Axis up);

// A skeleton as QTM describes it, made +Y up. Pipeline thread. Pinned by
// tests/unit/qtm/skeleton_test.cpp.
class QtmSkeleton {
 public:
  // Errors: no segments, more than qtm::kMaxSegments, several roots, two segments of one name or
  // id, a T-pose without a rotation.
  static Result<QtmSkeleton> Make(const qtm::SkeletonDescription& description, qtm::Axis up);

  // Millimetres; the rest rotations come from the description's T-pose, so any known joint names
  // are accepted.
  const rig::RigBody& body() const { return body_; }

  // Converts local rotations and the root's position. A joint whose segment is missing or not
  // tracked becomes NaN; a root that is not tracked leaves `pose.translations` unchanged. Returns
  // false if `segments` has none of this skeleton's ids and therefore belongs to another skeleton.
  STYLED_REALTIME bool Convert(const qtm::SkeletonPose& segments,
                               rig::RigPose& pose) const noexcept;

  friend bool operator==(const QtmSkeleton& a, const QtmSkeleton& b) {
    return a.ids_ == b.ids_ && a.body_ == b.body_;  // body_ depends on y_up_
  }

 private:
  const qtm::Segment* Find(const qtm::SkeletonPose& segments, std::size_t joint) const noexcept;

  rig::RigBody body_;
  rig::Quat y_up_ = rig::Quat::Identity();
  std::vector<std::uint32_t> ids_;  // per joint
};

}  // namespace styled::source
