#include "daemon/perform/performer/binding.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "daemon/looks/refusal.h"
#include "daemon/runtime/clock.h"
#include "model/rig/calibration.h"

namespace styled::pipeline {
Status PerformerBinding::Accept(const source::SourceFrame& frame, const Profile& profile,
                                const rig::JointNames& names) {
  v1::Body body;
  if (!source::ReadBody(frame, body)) {
    return Status::Error("body: not a styled.v1.Body");
  }
  auto skeleton = ReadSkeleton(body);
  if (!skeleton.ok()) return skeleton.status();
  std::swap(given_, body);
  Status status = Bind(profile, names);
  const bool wait = !status.ok() && !bound_ && rig::CanCalibrate(skeleton.value(), names).ok();
  if (!status.ok() && !wait) {
    std::swap(given_, body);
    return status;
  }
  history_ = std::make_unique<PoseHistory>(skeleton.value());
  if (wait) received_ = rig::RigPose(skeleton.value());
  crc_ = frame.body_crc;
  if (!wait) return status;
  return Status::Error(status.message() +
                       "; the performer is not styled until stylectl calibrate " + profile.id +
                       " --pose t");
}

// Binds the body in given_ with the profile's calibration. After an error nothing changes.
Status PerformerBinding::Bind(const Profile& profile, const rig::JointNames& names) {
  auto bound = BindBody(given_, profile.rest, names);
  if (!bound.ok()) return bound.status();
  bound_ = std::move(bound.value());
  if (fingers_.any()) {
    bound_->binding =
        std::make_shared<const rig::Binding>(rig::WithFingers(*bound_->binding, fingers_));
  }
  received_ = rig::RigPose(bound_->binding->skeleton());
  return Status::Ok();
}

Status PerformerBinding::Forget(Profile& profile, const rig::JointNames& names) {
  const auto before = std::exchange(profile.rest, std::nullopt);
  const Status status = Bind(profile, names);
  if (status.ok()) return status;
  profile.rest = before;
  return Refused(v1::CODE_BAD_POSE, "without a calibration " + status.message());
}

Result<v1::CalibrateReply> PerformerBinding::Calibrate(const v1::Calibrate& request,
                                                       Profile& profile,
                                                       const rig::JointNames& names,
                                                       std::int64_t now_ns) {
  constexpr std::int64_t kLive_ns = 300 * runtime::kMillisecond_ns;  // rigs send at 24 Hz or more
  if (!has_body() || now_ns - history_->last_ns() > kLive_ns) {
    return Refused(v1::CODE_NOT_READY,
                   profile.id + ": no frame in the last 0.3 s, expected a performer who is live");
  }
  v1::CalibrateReply result;
  if (request.clear()) {
    Status status = Forget(profile, names);
    return status.ok() ? Result<v1::CalibrateReply>(result) : status;
  }
  constexpr float kStill_rad = 0.09F;  // 5 degrees
  const auto moved = history_->Moved();
  if (moved.radians > kStill_rad) {
    return Refused(v1::CODE_NOT_READY,
                   given_.names(static_cast<int>(moved.joint)) + " turned by " +
                       std::to_string(std::lround(moved.radians * 57.3F)) +
                       " degrees within 0.4 s, expected a performer who stands still");
  }
  const auto skeleton = ReadSkeleton(given_);
  auto made = rig::Calibrate(
      skeleton.value(), history_->pose(),
      request.pose() == v1::Calibrate::POSE_N ? rig::StandingPose::kN : rig::StandingPose::kT,
      names);
  if (!made.ok()) return Refused(v1::CODE_BAD_POSE, made.status().message());
  const rig::Calibrated& calibrated = made.value();
  const auto before =
      std::exchange(profile.rest, KeptRest{SkeletonHash(skeleton.value()), calibrated.mirrored,
                                           calibrated.spec.canonical_from_source,
                                           calibrated.spec.rest_rotations});
  if (const Status status = Bind(profile, names); !status.ok()) {
    profile.rest = before;
    return Refused(v1::CODE_BAD_POSE, status.message());
  }
  result.set_worst_joint(calibrated.bones.front().joint);
  result.set_worst_degrees(calibrated.bones.front().degrees);
  result.set_left_handed(calibrated.mirrored);
  return result;
}

bool PerformerBinding::Receive(const source::SourceFrame& frame, std::int64_t receive_ns) noexcept {
  const int joints = given_.names_size();
  if (!source::CopyPose(frame, joints, received_)) return false;
  std::fill(received_.rotations.begin() + joints, received_.rotations.end(), rig::Quat::Identity());
  history_->Add(received_, receive_ns);
  return true;
}

}  // namespace styled::pipeline
