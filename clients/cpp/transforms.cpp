#include "clients/cpp/transforms.h"

#include <cmath>

namespace styled::client {
namespace {

bool IsPosition(const float* p) noexcept {
  return std::isfinite(p[0]) && std::isfinite(p[1]) && std::isfinite(p[2]);
}

bool IsRotation(const float* q) noexcept {
  const float square = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
  return std::isfinite(square) && square >= 1e-12F;
}

}  // namespace

BodyError Validate(const v1::Body& body) noexcept {
  const int joints = body.names_size();
  if (joints < 1 || joints > kMaxJoints) return BodyError::kJoints;
  if (body.parents_size() != joints || body.offsets_size() != 3 * joints) return BodyError::kSizes;
  if (body.rest_size() != 0 && body.rest_size() != 4 * joints) return BodyError::kSizes;
  if (body.parents(0) != -1) return BodyError::kParents;
  for (int joint = 1; joint < joints; ++joint) {
    if (body.parents(joint) < 0 || body.parents(joint) >= joint) return BodyError::kParents;
  }
  for (const float offset : body.offsets()) {
    if (!std::isfinite(offset)) return BodyError::kNumbers;
  }
  return BodyError::kNone;
}

FrameError Validate(const v1::Frame& frame, const v1::Body& body) noexcept {
  if (frame.body_hash() != body.hash() || frame.output() != body.output()) {
    return FrameError::kOtherBody;
  }
  const int joints = body.names_size();
  if (frame.root_position_size() != 3 || frame.rotations_size() != 4 * joints) {
    return FrameError::kSizes;
  }
  for (const v1::Prop& prop : frame.props()) {
    if (prop.position_size() != 3 || prop.rotation_size() != 4) return FrameError::kSizes;
  }
  if (!IsPosition(frame.root_position().data())) return FrameError::kNumbers;
  for (int joint = 0; joint < joints; ++joint) {
    if (!IsRotation(frame.rotations().data() + 4 * joint)) return FrameError::kNumbers;
  }
  for (const v1::Prop& prop : frame.props()) {
    if (!IsPosition(prop.position().data()) || !IsRotation(prop.rotation().data())) {
      return FrameError::kNumbers;
    }
  }
  return FrameError::kNone;
}

FrameError WorldTransforms(const v1::Body& body, const v1::Frame& frame,
                           std::vector<Transform>& out) {
  if (const FrameError error = Validate(frame, body); error != FrameError::kNone) return error;
  const int joints = body.names_size();
  out.resize(joints);
  const auto local = [&frame](int joint) {
    const float* q = frame.rotations().data() + 4 * joint;
    return Eigen::Quaternionf(q[3], q[0], q[1], q[2]).normalized();
  };
  out[0].position = Eigen::Map<const Eigen::Vector3f>(frame.root_position().data());
  out[0].rotation = local(0);
  for (int joint = 1; joint < joints; ++joint) {
    const Transform& parent = out[body.parents(joint)];
    const Eigen::Map<const Eigen::Vector3f> offset(body.offsets().data() + 3 * joint);
    out[joint].position = parent.position + parent.rotation * offset;
    out[joint].rotation = parent.rotation * local(joint);
  }
  return FrameError::kNone;
}

}  // namespace styled::client
