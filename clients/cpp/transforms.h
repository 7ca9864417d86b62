#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "proto/styled/v1/body.pb.h"
#include "proto/styled/v1/frame.pb.h"

namespace styled::client {

// Pose of a joint in the world of its skeleton, in the units and axes of Body (canonical humanoid:
// metres, +Y up, +Z forward, +X the body's left). `rotation` is world from joint, unit length.
struct Transform {
  Eigen::Vector3f position = Eigen::Vector3f::Zero();
  Eigen::Quaternionf rotation = Eigen::Quaternionf::Identity();
};

// Largest accepted J. A larger body is considered a damaged message.
inline constexpr int kMaxJoints = 1024;

enum class BodyError {
  kNone,
  kJoints,   // J < 1 or J > kMaxJoints
  kSizes,    // lengths of parents, offsets or rest do not match J (J, 3*J, 4*J or 0)
  kParents,  // joint 0 is not the only root, or a parent does not precede its child
  kNumbers,  // an offset is not finite
};

enum class FrameError {
  kNone,
  kOtherBody,  // the frame's hash or output differs from the body's
  // Length of rotations is not 4*J, of root_position not 3, or of a prop's pose not 3 and 4.
  kSizes,
  kNumbers,  // not finite, or a rotation of zero length
};

// Checks a body once, so that WorldTransforms may rely on it. Any thread; allocates nothing.
[[nodiscard]] BodyError Validate(const v1::Body& body) noexcept;

// Checks `frame` against `body`, which must have passed Validate. Any thread; allocates nothing.
[[nodiscard]] FrameError Validate(const v1::Frame& frame, const v1::Body& body) noexcept;

// Forward kinematics: `out[j]` is joint j of `body` in `frame`, J entries in the body's order.
// `body` must have passed Validate. Resizes `out`, so that only the first frame allocates. On an
// error `out` is unchanged. Any thread. Pinned by tests/unit/clients/transforms_test.cpp.
[[nodiscard]] FrameError WorldTransforms(const v1::Body& body, const v1::Frame& frame,
                                         std::vector<Transform>& out);

}  // namespace styled::client
