#include "model/net/phase/dynamics.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "model/base/smooth.h"
#include "model/gait/tuning.h"
#include "model/net/phase/tuning.h"

namespace styled::phase {
namespace {

using body::Quat;
using body::Vec3;
using gait::Vectors;

bool IsArm(int joint) { return joint >= body::kLeftShoulder && joint <= body::kRightHand; }
bool IsTrunk(int joint) { return joint >= body::kSpine && joint <= body::kHead; }
// Neck, head and arms can lag and hold; hips and legs carry the body.
bool IsLoose(int joint) { return IsArm(joint) || joint == body::kNeck || joint == body::kHead; }

// A sum of sines of these frequencies, within -1 .. 1; `place` decides their phases.
template <std::size_t kCount>
float Noise(const std::array<double, kCount>& hz, double time_s, int place) noexcept {
  double sum = 0;
  for (std::size_t k = 0; k < kCount; ++k) {
    // Golden-ratio phases are different at every place.
    const double turns = hz[k] * time_s + 0.6180339887 * (place + 1) * static_cast<double>(k + 1);
    sum += std::sin(static_cast<double>(gait::tuning::kTurn_rad) * (turns - std::floor(turns)));
  }
  return static_cast<float>(sum / kCount);
}

// Rotation vectors of shaking and drifting.
Vec3 Shake(int joint, double time_s, float tremor_rad, float wander_rad) noexcept {
  Vec3 turn = Vec3::Zero();
  for (int axis = 0; axis < 3; ++axis) {
    const int place = 3 * joint + axis;
    if (tremor_rad != 0 && IsLoose(joint)) {
      const float share = IsArm(joint) ? 1 : tuning::kHeadShakes;
      turn[axis] +=
          share * tremor_rad * tuning::kThroughLowPass * Noise(tuning::kTremor_hz, time_s, place);
    }
    if (wander_rad != 0 &&
        (IsTrunk(joint) || joint == body::kLeftUpperArm || joint == body::kRightUpperArm)) {
      turn[axis] += wander_rad * Noise(tuning::kWander_hz, time_s, place);
    }
  }
  return turn;
}

}  // namespace

void Dynamics::Follow(const gait::Rotations& own, const DynamicValues& values, double time_s,
                      float dt_s, Vectors& turns) noexcept {
  if (values.moves()) {
    FollowMovement(own, values, time_s, dt_s, turns);
  } else {
    Reset();
  }
  if (values.tremor_rad == 0 && values.wander_rad == 0) return;
  for (int joint = body::kSpine; joint <= body::kRightHand; ++joint) {
    turns.segment<3>(3 * joint) += Shake(joint, time_s, values.tremor_rad, values.wander_rad);
  }
}

// own = mean exp(movement); what is shown is mean exp(gain movement'), where movement' follows the
// movement late, or stands still and then catches up.
void Dynamics::FollowMovement(const gait::Rotations& own, const DynamicValues& values,
                              double time_s, float dt_s, Vectors& turns) noexcept {
  if (!active_) {
    active_ = true;
    mean_ = own;
    value_.setZero();
    rate_.setZero();
    frozen_.setZero();
    frozen_until_s_ = 0;
  }
  const Vectors movement = gait::VectorsAbout(mean_, own);
  const float share = DecayShare(dt_s, tuning::kMovementMean_s);
  // A clock that jumped, back or far ahead, ends a hold.
  if (time_s >= frozen_until_s_ || frozen_until_s_ - time_s > static_cast<double>(values.hold_s)) {
    frozen_ = movement;
    frozen_until_s_ = time_s + static_cast<double>(values.hold_s);
  }
  const float snap = DecayShare(dt_s, tuning::kSnap_s);
  // A spring of damping 0.5 overshoots by 16 %; its delay is 1 / frequency.
  const float frequency = 1 / std::max(values.lag_s, tuning::kLeastLag_s);
  constexpr int kSubsteps = 4;  // stable down to the least lag at 30 Hz
  for (int step = 0; values.lag_s > 0 && values.hold_s <= 0 && step < kSubsteps; ++step) {
    const float dt = dt_s / kSubsteps;
    rate_ += dt * frequency * (frequency * (movement - value_) - rate_);
    value_ += dt * rate_;
  }
  if (values.hold_s > 0) value_ += snap * (frozen_ - value_);
  const float gain = std::max(0.0F, 1 + values.energy);
  for (int joint = body::kSpine; joint <= body::kRightHand; ++joint) {
    const auto j = static_cast<std::size_t>(joint);
    const bool late = IsLoose(joint) && (values.lag_s > 0 || values.hold_s > 0);
    const Vec3 shown =
        gain * (late ? gait::VectorOf(value_, joint) : gait::VectorOf(movement, joint));
    turns.segment<3>(3 * joint) += body::Log(own[j].conjugate() * mean_[j] * body::Exp(shown));
    mean_[j] = (mean_[j] * body::Exp(share * gait::VectorOf(movement, joint))).normalized();
  }
}

void Dynamics::Carry(Checkpoint& c) noexcept {
  c(active_);
  if (!active_) return;
  c(mean_, value_, rate_, frozen_, frozen_until_s_);
  if (!c.reads() || !c.ok()) return;
  const bool turns = std::all_of(mean_.begin(), mean_.end(), [](const Quat& rotation) {
    return std::abs(rotation.norm() - 1) <= 1e-3F;
  });
  if (!turns || !value_.allFinite() || !rate_.allFinite() || !frozen_.allFinite() ||
      !std::isfinite(frozen_until_s_)) {
    c.Refuse();
  }
}

}  // namespace styled::phase
