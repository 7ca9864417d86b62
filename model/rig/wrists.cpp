#include "model/rig/wrists.h"

#include <algorithm>

namespace styled::rig {
namespace {

constexpr std::array kHands{body::kLeftHand, body::kRightHand};

}  // namespace

Placed ToCanonical(const Binding& binding, const Vec3& position, const Quat& rotation) noexcept {
  const Quat& canonical_from_source = binding.spec().canonical_from_source;
  return {binding.scale() * (canonical_from_source * position),
          canonical_from_source * rotation * canonical_from_source.conjugate()};
}

void FromCanonical(const Binding& binding, const Placed& placed, Vec3& position,
                   Quat& rotation) noexcept {
  const Quat& canonical_from_source = binding.spec().canonical_from_source;
  position = canonical_from_source.conjugate() * (placed.position_m / binding.scale());
  rotation =
      (canonical_from_source.conjugate() * placed.rotation * canonical_from_source).normalized();
}

Wrists::Wrists(const Binding& binding) : binding_(&binding) {
  for (std::size_t side = 0; side < kHands.size(); ++side) {
    const int hand = binding.spec().source_joint[kHands[side]];
    for (int up = hand; up >= 0; up = binding.skeleton().parents[static_cast<std::size_t>(up)]) {
      chains_[side].push_back(static_cast<std::size_t>(up));
    }
    std::reverse(chains_[side].begin(), chains_[side].end());
  }
}

WristPair Wrists::Read(const Vec3& root, std::span<const Quat> rotations) const noexcept {
  WristPair wrists;
  for (std::size_t side = 0; side < kHands.size(); ++side) {
    if (chains_[side].empty()) continue;
    Vec3 position = root;
    Quat rotation = Quat::Identity();
    for (const std::size_t joint : chains_[side]) {
      if (joint > 0) position += rotation * binding_->skeleton().offsets[joint];
      rotation = rotation * rotations[joint];
    }
    const Quat& rest = binding_->spec().rest_rotations[chains_[side].back()];
    wrists[side] = ToCanonical(*binding_, position, (rotation * rest.conjugate()).normalized());
  }
  return wrists;
}

WristPair WristsOf(const body::Pose& pose) noexcept {
  body::WorldPose world;
  body::ForwardKinematics(pose, world);
  WristPair wrists;
  for (std::size_t side = 0; side < kHands.size(); ++side) {
    const auto hand = static_cast<std::size_t>(kHands[side]);
    wrists[side] = Placed{world.positions_m[hand], world.rotations[hand]};
  }
  return wrists;
}

}  // namespace styled::rig
