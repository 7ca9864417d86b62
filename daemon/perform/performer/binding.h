#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "daemon/looks/profile.h"
#include "daemon/perform/performer/body_binding.h"
#include "daemon/perform/performer/pose_history.h"
#include "daemon/source/source_frame.h"
#include "model/base/realtime.h"
#include "model/base/status.h"
#include "model/rig/dialects.h"
#include "model/rig/hands.h"
#include "proto/styled/v1/body.pb.h"
#include "proto/styled/v1/control.pb.h"

namespace styled::pipeline {

// A performer's body: the rig's message, its binding to the canonical humanoid if the rest pose is
// known, and its received poses. One per performer, pipeline thread. Everything but Receive
// allocates. Pinned by tests/unit/daemon/pipeline/pipeline_test.cpp and
// tests/e2e/calibrate_test.cpp.
class PerformerBinding {
 public:
  // Finger joints that the bound body has even where the rig's body lacks them (rig::WithFingers).
  // Call before the first body.
  void WantFingers(const rig::TailSet& fingers) { fingers_ = fingers; }
  // Adopts a new body and binds it. After an error nothing changes, with one exception: if no body
  // was bound and at least the joints are recognized, the performer waits() for a calibration.
  // `names`: the source's joint names set by hand.
  Status Accept(const source::SourceFrame& body, const Profile& profile,
                const rig::JointNames& names);
  // Executes Calibrate (control.proto) for rigs with a skeleton: writes profile.rest and binds
  // again. After an error, which has a code, nothing is changed.
  Result<v1::CalibrateReply> Calibrate(const v1::Calibrate& request, Profile& profile,
                                       const rig::JointNames& names, std::int64_t now_ns);

  bool has_body() const { return history_ != nullptr; }
  bool waits() const { return has_body() && !bound_; }
  bool bound() const { return bound_.has_value(); }
  const BoundBody& body() const { return *bound_; }  // requires bound()
  const v1::Body& given() const { return given_; }
  std::uint32_t crc() const { return crc_; }

  // Copies a frame's pose. Returns false if its joint count differs from the body's.
  STYLED_REALTIME bool Receive(const source::SourceFrame& frame, std::int64_t receive_ns) noexcept;
  // The last pose as received; joints that the rig lacks have the T-pose's rotations. May be
  // swapped with another pose of the bound skeleton.
  rig::RigPose& received() noexcept { return received_; }

 private:
  Status Bind(const Profile& profile, const rig::JointNames& names);
  Status Forget(Profile& profile, const rig::JointNames& names);

  v1::Body given_;                        // as the rig sent it
  std::unique_ptr<PoseHistory> history_;  // of given_'s skeleton
  rig::RigPose received_;
  std::optional<BoundBody> bound_;
  rig::TailSet fingers_;
  std::uint32_t crc_ = 0;
};

}  // namespace styled::pipeline
