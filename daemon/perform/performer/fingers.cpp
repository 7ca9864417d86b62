#include "daemon/perform/performer/fingers.h"

#include <utility>

namespace styled::pipeline {

rig::TailSet JointsOf(std::span<FingerLayer* const> layers) {
  rig::TailSet joints;
  for (const FingerLayer* const layer : layers) joints |= layer->wanted();
  return joints;
}

Fingers::Fingers(std::vector<FingerLayer*> layers, const rig::Binding& binding)
    : layers_(std::move(layers)) {
  const rig::TailSet wanted = JointsOf(layers_);
  rig::TailMap map = rig::FindTail(binding.skeleton(), binding.spec().source_joint);
  for (std::size_t t = 0; t < map.size(); ++t) {
    if (!wanted[t]) map[t] = -1;
  }
  tail_ = rig::Tail::Make(binding, map);
  own_.assign(tail_.size(), rig::Quat::Identity());
  read_ = shown_ = own_;
}

std::string Fingers::HandsWithoutPlace() const {
  rig::TailSet placed;
  for (const rig::Tail::Joint& joint : tail_.joints())
    placed.set(static_cast<std::size_t>(joint.joint));
  const rig::TailSet wanted = JointsOf(layers_);
  std::string hands;
  for (const auto& [hand, name] :
       {std::pair{body::kLeftHand, "left"}, {body::kRightHand, "right"}}) {
    const rig::TailSet fingers = rig::FingersOf(hand);
    if ((wanted & fingers).none() || (placed & fingers).any()) continue;
    hands += (hands.empty() ? "" : " and ") + std::string(name);
  }
  return hands;
}

void Fingers::Apply(std::int64_t elapsed_ns, rig::RigPose& pose) noexcept {
  if (layers_.empty()) return;
  const std::int64_t step_ns = elapsed_ns - std::exchange(elapsed_ns_, elapsed_ns);
  for (FingerLayer* const layer : layers_) layer->Advance(step_ns);
  tail_.Read(pose.rotations, read_);
  for (std::size_t i = 0; i < tail_.size(); ++i) {
    if (read_[i].coeffs().allFinite()) {
      own_[i] = read_[i];
    } else {
      read_[i] = own_[i];
    }
    rig::Quat shown = own_[i];
    bool given = false;
    for (auto layer = layers_.rbegin(); layer != layers_.rend(); ++layer) {
      given = (*layer)->Over(tail_.joints()[i].joint, shown) || given;
    }
    if (!given) continue;
    if (shown.dot(shown_[i]) < 0) shown.coeffs() = -shown.coeffs();
    shown_[i] = shown;
    tail_.Write(i, shown, pose.rotations);
  }
}

}  // namespace styled::pipeline
