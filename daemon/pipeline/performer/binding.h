#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "daemon/pipeline/body_binding.h"
#include "daemon/pipeline/pose_history.h"
#include "daemon/pipeline/profile.h"
#include "daemon/source/source_frame.h"
#include "model/base/realtime.h"
#include "model/base/status.h"
#include "model/rig/dialects.h"
#include "proto/styled/v1/body.pb.h"
#include "proto/styled/v1/control.pb.h"

namespace styled::pipeline {

// A performer's body: the message of the rig, its binding to the canonical humanoid where the rest
// pose is known, and the poses that came on it. One per performer, pipeline thread. Everything but
// Receive allocates. Pinned by tests/unit/daemon/pipeline_test.cpp and
// tests/e2e/calibrate_test.cpp.
class PerformerBinding {
 public:
  // Takes over a new body and binds it. An error changes nothing, except where no body was bound
  // and the joints at least are known: then the performer waits() for a calibration. `names`: the
  // source's joints by hand.
  Status Accept(const source::SourceFrame& body, const Profile& profile,
                const rig::JointNames& names);
  // What control.proto says of Calibrate, for rigs that have a skeleton: writes profile.rest and
  // binds anew. Any code but CODE_OK changes nothing and gives the reply a reason.
  v1::Code Calibrate(const v1::Calibrate& request, Profile& profile, const rig::JointNames& names,
                     std::int64_t now_ns, v1::Reply& reply);

  bool has_body() const { return history_ != nullptr; }
  bool waits() const { return has_body() && !bound_; }
  bool bound() const { return bound_.has_value(); }
  const BoundBody& body() const { return *bound_; }  // where bound()
  const v1::Body& given() const { return given_; }
  std::uint32_t crc() const { return crc_; }

  // Copies a frame's pose and remembers it. False where it has another joint count than the body.
  STYLED_REALTIME bool Receive(const source::SourceFrame& frame, std::int64_t receive_ns) noexcept;
  // The last pose received, as it came; may be swapped with another of the skeleton's size.
  rig::RigPose& received() noexcept { return received_; }

 private:
  Status Bind(const Profile& profile, const rig::JointNames& names);
  v1::Code Forget(Profile& profile, const rig::JointNames& names, v1::Reply& reply);

  v1::Body given_;                        // as the rig sent it
  std::unique_ptr<PoseHistory> history_;  // of its skeleton
  rig::RigPose received_;
  std::optional<BoundBody> bound_;
  std::uint32_t crc_ = 0;
};

}  // namespace styled::pipeline
