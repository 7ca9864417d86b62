#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "proto/styled/v1/body.pb.h"
#include "proto/styled/v1/frame.pb.h"

namespace styled::client {

// Where a joint is in its skeleton's world: body units and axes, as Body says (canonical humanoid:
// metres, +Y up, +Z forward, +X the body's left). `rotation` is world from joint, unit length.
struct Transform {
  Eigen::Vector3f position = Eigen::Vector3f::Zero();
  Eigen::Quaternionf rotation = Eigen::Quaternionf::Identity();
};

// Largest J that is believed; a body beyond it is taken for a damaged message.
inline constexpr int kMaxJoints = 1024;

enum class BodyError {
  kNone,
  kJoints,   // no joint, or more than kMaxJoints
  kSizes,    // parents, offsets or rest do not belong to J joints (J, 3*J, 4*J or none)
  kParents,  // joint 0 is not the only root, or a parent does not precede its child
  kNumbers,  // an offset is not finite
};

enum class FrameError {
  kNone,
  kOtherBody,  // the frame's hash or output is not the body's
  kSizes,      // rotations are not 4*J, or root_position not 3
  kNumbers,    // not finite, or a rotation of zero length
};

// Checks a body once, so that WorldTransforms may trust it. Any thread; allocates nothing.
[[nodiscard]] BodyError Validate(const v1::Body& body) noexcept;

// Checks `frame` against `body`, which must have passed Validate. Any thread; allocates nothing.
[[nodiscard]] FrameError Validate(const v1::Frame& frame, const v1::Body& body) noexcept;

// Forward kinematics: `out[j]` is joint j of `body` in `frame`, J entries in the body's order.
// `body` must have passed Validate. Resizes `out`, so allocates for the first frame only; leaves it
// as it was on an error. Any thread. Pinned by tests/unit/clients/transforms_test.cpp.
[[nodiscard]] FrameError WorldTransforms(const v1::Body& body, const v1::Frame& frame,
                                         std::vector<Transform>& out);

}  // namespace styled::client
