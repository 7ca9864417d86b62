#include "model/rig/grip.h"

#include <algorithm>
#include <cmath>

#include "model/base/smooth.h"

namespace styled::rig {
namespace {

// A hand's pull falls with the fourth power of its distance beyond this one, the size of a fist.
constexpr float kFist_m = 0.05F;

}  // namespace

Grip GripOf(const Placed& object, const WristPair& wrists, Hand hand) noexcept {
  Grip grip;
  if (hand == Hand::kLeft || hand == Hand::kRight) {
    const std::size_t side = hand == Hand::kLeft ? kLeftWrist : kRightWrist;
    if (wrists[side]) grip.share[side] = 1;
    return grip;
  }
  if (hand == Hand::kNone) return grip;
  std::array<float, 2> pull{};
  float nearest = 0;
  for (std::size_t side = 0; side < pull.size(); ++side) {
    if (!wrists[side]) continue;
    const float squared = (object.position_m - wrists[side]->position_m).squaredNorm();
    const float holds = 1 - SmoothStep(std::sqrt(squared), kHeld_m, kLetGo_m);
    nearest = std::max(nearest, holds);
    const float near = 1 / (squared + kFist_m * kFist_m);
    pull[side] = holds * near * near;
  }
  if (nearest <= 0) return grip;
  for (std::size_t side = 0; side < pull.size(); ++side) {
    grip.share[side] = nearest * pull[side] / (pull[0] + pull[1]);
  }
  return grip;
}

Placed Carry(const Placed& object, const Grip& grip, const WristPair& from,
             const WristPair& to) noexcept {
  Vec3 position = Vec3::Zero();
  Eigen::Vector4f rotation = Eigen::Vector4f::Zero();
  float held = 0;
  for (std::size_t side = 0; side < grip.share.size(); ++side) {
    const float share = grip.share[side];
    if (share <= 0 || !from[side] || !to[side]) continue;
    const Quat turn = to[side]->rotation * from[side]->rotation.conjugate();
    position +=
        share * (to[side]->position_m + turn * (object.position_m - from[side]->position_m));
    const Quat turned = turn * object.rotation;
    const float sign = turned.dot(object.rotation) < 0 ? -1.0F : 1.0F;
    rotation += sign * share * turned.coeffs();
    held += share;
  }
  if (held <= 0) return object;
  const float free = std::max(0.0F, 1 - held);
  Quat mixed;
  mixed.coeffs() = rotation + free * object.rotation.coeffs();
  // Two hands that turn it by opposite quarter turns cancel out.
  if (mixed.squaredNorm() < 1e-6F) mixed = object.rotation;
  return {position + free * object.position_m, mixed.normalized()};
}

}  // namespace styled::rig
