#pragma once

#include <torch/torch.h>

// Differentiable counterparts of model/body for whole batches. Quaternions are x,y,z,w in the last
// dimension, joints (21, in the order of body::Joint) in the one before it; any leading dimensions.
namespace styled::train {

// a ∘ b, and the inverse of a unit quaternion.
torch::Tensor Multiply(const torch::Tensor& a, const torch::Tensor& b);
torch::Tensor Conjugate(const torch::Tensor& q);

// Rotation vector (radians) of a unit quaternion, along the shorter way round; differentiable at 0.
torch::Tensor LogQuaternion(const torch::Tensor& q);

// The unit quaternion of a rotation vector. Not differentiable at 0.
torch::Tensor ExpQuaternion(const torch::Tensor& rotation_rad);

// A unit quaternion's rotation made `factor` times as large, along the shorter way round. `factor`
// broadcasts against q's [..., 1]. Not differentiable at 0.
torch::Tensor ScaleRotation(const torch::Tensor& q, const torch::Tensor& factor);

// The squared half angle between two rotations, arccos(|a·b|)² (eq. 2), by its series in 1 - |a·b|:
// the gradient stays finite where the rotations agree.
torch::Tensor SquaredHalfAngle(const torch::Tensor& a, const torch::Tensor& b);

// Flips every quaternion onto the hemisphere of `reference`.
torch::Tensor ToHemisphere(const torch::Tensor& q, const torch::Tensor& reference);

// Joint positions (m) relative to the hips, [..., 21, 3], of local rotations [..., 21, 4] over the
// canonical humanoid's offsets.
torch::Tensor HipsRelativePositions(const torch::Tensor& rotations);

// Velocities (m/s) of time-major positions [T, B, 21, 3] that stand in each frame's own heading
// frame, for frames 1..T-1: [T-1, B, 21, 3]. yaw_change_rad [T, B] and hips_step_m [T, B, 3] are
// the performer's (FillWindow); `lift_m` [T, B] raises the whole body. The features' own v is this
// with lift 0; tests/unit/train/geometry_test.cpp holds them together.
torch::Tensor WorldVelocities(const torch::Tensor& positions, const torch::Tensor& yaw_change_rad,
                              const torch::Tensor& hips_step_m, const torch::Tensor& lift_m,
                              double rate_hz);

// Height (m) of the lowest of feet and toes relative to the hips: [..., 21, 3] -> [...].
torch::Tensor LowestFoot(const torch::Tensor& positions);

}  // namespace styled::train
