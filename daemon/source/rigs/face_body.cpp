#include "daemon/source/rigs/face_body.h"

#include <algorithm>
#include <cmath>

#include "model/body/pose.h"
#include "proto/rigs/types.h"

namespace styled::source {
namespace {

using rig::Quat;
using rig::Vec3;

constexpr int kLeftEye = body::kJointCount, kRightEye = kLeftEye + 1;

// ARKit's eyes turn by 35 degrees at a weight of 1: the slope of the eyes' rotations over their
// shapes is 0.61 rad in a recording of Live Link Face, and 35.5 degrees in the sample on
// iFacialMocap's page for developers.
constexpr float kGaze_rad = 0.61F;
// The neck's share of a turned head. Half of a turn of the head is that of the upper two vertebrae,
// which is the head's joint here; the rest spreads over the neck, of which the trunk takes a part.
constexpr float kNeckShare = 0.4F;
// A number that no head has is one of another program.
constexpr float kMost_rad = 100;

Quat About(const Vec3& axis, float angle_rad) { return Quat(Eigen::AngleAxisf(angle_rad, axis)); }
Quat X(float angle_rad) { return About(Vec3::UnitX(), angle_rad); }
Quat Y(float angle_rad) { return About(Vec3::UnitY(), angle_rad); }
Quat Z(float angle_rad) { return About(Vec3::UnitZ(), angle_rad); }

rig::RigBody Body() {
  rig::RigBody made;
  const auto add = [&](std::string_view name, int parent, const Vec3& offset) {
    made.skeleton.names.emplace_back(name);
    made.skeleton.parents.push_back(parent);
    made.skeleton.offsets.push_back(offset);
  };
  for (int j = 0; j < body::kJointCount; ++j) {
    const body::JointRow& row = body::kHumanoid[static_cast<std::size_t>(j)];
    add(row.name, row.parent, body::Offset(j));
  }
  add("leftEye", body::kHead, {0.03F, 0.06F, 0.08F});
  add("rightEye", body::kHead, {-0.03F, 0.06F, 0.08F});
  made.rest.assign(made.skeleton.names.size(), Quat::Identity());
  made.metres_per_unit = 1;
  made.dialect = rigs::kSlimeVr.dialect;
  return made;
}

// With arms that hang, or hands at a desk; looked at in pictures, not measured.
rig::RigPose PoseOf(const rig::RigBody& body, bool seated) {
  rig::RigPose pose(body.skeleton);
  const float forward_rad = seated ? -0.45F : -0.05F, elbow_rad = seated ? 1.1F : 0.25F;
  pose.rotations[body::kLeftUpperArm] = X(forward_rad) * Z(seated ? -1.25F : -1.4F);
  pose.rotations[body::kRightUpperArm] = X(forward_rad) * Z(seated ? 1.25F : 1.4F);
  pose.rotations[body::kLeftLowerArm] = Y(-elbow_rad);
  pose.rotations[body::kRightLowerArm] = Y(elbow_rad);
  const float hip_rad = seated ? -1.45F : -0.04F, knee_rad = seated ? 1.45F : 0.08F;
  for (const int upper : {int{body::kLeftUpperLeg}, int{body::kRightUpperLeg}}) {
    pose.rotations[static_cast<std::size_t>(upper)] = X(hip_rad);
    pose.rotations[static_cast<std::size_t>(upper) + 1] = X(knee_rad);
    pose.rotations[static_cast<std::size_t>(upper) + 2] = X(-hip_rad - knee_rad);
  }
  // The ankles as high as in the T-pose.
  const float leg_m = -body::Offset(body::kLeftLowerLeg).y();
  pose.translations.front().y() -= leg_m * (2 - std::cos(hip_rad) - std::cos(hip_rad + knee_rad));
  return pose;
}

}  // namespace

FaceBody::FaceBody(const config::Source& config)
    : stream_(config.performer.empty() ? config.name : config.performer),
      body_(Body()),
      pose_(PoseOf(body_, config.body == "seated")) {
  stream_.ReserveFace();
}

void FaceBody::Send(const Frame& frame, std::span<const float, arkit::kShapes> shapes,
                    const Face& face, Outbox& out) {
  if (!stream_.has_body()) stream_.SetBody(body_, out);  // leaves the hot section
  const Vec3 angles(frame.pitch_rad, frame.yaw_rad, frame.roll_rad);
  if (angles.allFinite() && angles.cwiseAbs().maxCoeff() < kMost_rad) {
    head_ = Y(frame.yaw_rad) * X(frame.pitch_rad) * Z(frame.roll_rad);
  }
  const Quat head = straight_.conjugate() * head_;
  const Quat neck = Quat::Identity().slerp(kNeckShare, head);
  pose_.rotations[body::kNeck] = neck;
  pose_.rotations[body::kHead] = (neck.conjugate() * head).normalized();
  const auto weight = [&](std::string_view name) {
    const auto shape = arkit::Find(name);
    const float value = shape ? shapes[*shape] : 0;
    return std::isfinite(value) ? std::clamp(value, 0.0F, 1.0F) : 0.0F;
  };
  const auto turn = [&](int eye, float left, float down) {
    pose_.rotations[static_cast<std::size_t>(eye)] = Y(kGaze_rad * left) * X(kGaze_rad * down);
  };
  turn(kLeftEye, weight("eyeLookOutLeft") - weight("eyeLookInLeft"),
       weight("eyeLookDownLeft") - weight("eyeLookUpLeft"));
  turn(kRightEye, weight("eyeLookInRight") - weight("eyeLookOutRight"),
       weight("eyeLookDownRight") - weight("eyeLookUpRight"));
  PerformerStream::FrameInfo info;
  info.source_time_ns = frame.source_time_ns;
  info.now_ns = frame.now_ns;
  info.lost = frame.lost;
  info.face = &face;
  stream_.Send(pose_, info, out);
}

Status FaceBody::Calibrate(Calibration what) {
  switch (what) {
    case Calibration::kFull:
      straight_ = head_;
      return Status::Ok();
    case Calibration::kYaw: {
      const Vec3 ahead = head_ * Vec3::UnitZ();
      straight_ = Y(std::atan2(ahead.x(), ahead.z()));
      return Status::Ok();
    }
    case Calibration::kMounting:
      break;
  }
  return Status::Error("a face has no second pose; expected the pose looking straight ahead");
}

}  // namespace styled::source
