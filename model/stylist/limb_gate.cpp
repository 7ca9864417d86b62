#include "model/stylist/limb_gate.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "model/base/smooth.h"
#include "model/stylist/tuning.h"

namespace styled::stylist {
namespace {

using body::kJointCount;
using body::Quat;
using body::Vec3;

constexpr std::size_t Index(Limb limb) { return static_cast<std::size_t>(limb); }

constexpr auto kLimbOf = [] {
  std::array<std::size_t, kJointCount> limbs{};
  for (int joint = 0; joint < kJointCount; ++joint) {
    limbs[static_cast<std::size_t>(joint)] = static_cast<std::size_t>(LimbOf(body::PartOf(joint)));
  }
  return limbs;
}();

// Joints whose positions show the pose of a limb. Other joints are fixed within their limb or
// redundant, and some rigs' toes turn over.
constexpr bool IsMeasured(int joint) {
  switch (joint) {
    case body::kChest:
    case body::kNeck:
    case body::kHead:
    case body::kLeftLowerArm:
    case body::kLeftHand:
    case body::kRightLowerArm:
    case body::kRightHand:
    case body::kLeftLowerLeg:
    case body::kLeftFoot:
    case body::kRightLowerLeg:
    case body::kRightFoot:
      return true;
    default:
      return false;
  }
}

constexpr PerLimb kMeasured = [] {
  PerLimb counts{};
  for (int joint = 0; joint < kJointCount; ++joint) {
    if (IsMeasured(joint)) counts[kLimbOf[static_cast<std::size_t>(joint)]] += 1;
  }
  return counts;
}();

const net::GateBounds::Range& RangeOf(std::size_t limb, const net::GateBounds& bounds) {
  switch (static_cast<Limb>(limb)) {
    case Limb::kLeftArm:
    case Limb::kRightArm:
      return bounds.arms;
    case Limb::kTrunk:
      return bounds.trunk;
    default:
      return bounds.legs;
  }
}

// A chain of joints, from the joint that its limb is attached to.
struct Chain {
  std::array<Vec3, kJointCount> places_m;
  std::array<Quat, kJointCount> rotations;

  explicit Chain(std::span<const Quat, kJointCount> local) {
    places_m[body::kHips].setZero();
    rotations[body::kHips] = local[body::kHips];
    for (std::size_t joint = 1; joint < kJointCount; ++joint) {
      const auto parent = static_cast<std::size_t>(body::kHumanoid[joint].parent);
      const Vec3 offset_m = body::Offset(static_cast<int>(joint));
      const bool begins = kLimbOf[joint] != kLimbOf[parent];
      places_m[joint] = begins ? offset_m : places_m[parent] + rotations[parent] * offset_m;
      rotations[joint] = begins ? local[joint] : rotations[parent] * local[joint];
    }
  }
};

}  // namespace

PerLimb LimbErrors_m(std::span<const Quat, kJointCount> input,
                     std::span<const Quat, kJointCount> reconstruction) noexcept {
  const Chain is(input);
  const Chain found(reconstruction);
  PerLimb errors_m{};
  for (std::size_t joint = 0; joint < kJointCount; ++joint) {
    if (!IsMeasured(static_cast<int>(joint))) continue;
    errors_m[kLimbOf[joint]] += (found.places_m[joint] - is.places_m[joint]).norm();
  }
  for (std::size_t limb = 0; limb < kLimbCount; ++limb) errors_m[limb] /= kMeasured[limb];
  return errors_m;
}

// The quantile by the rule of Robbins and Monro: up and down at speeds whose ratio is the share of
// frames below it.
PerLimb LimbGate::Unusual(const PerLimb& errors_m, float dt_s) noexcept {
  constexpr float kArms_m = tuning::kGateKnown_m + tuning::kGateMostUsual_m;
  constexpr float kLegs_m = tuning::kGateKnown_m;
  constexpr PerLimb kMost_m{kArms_m, kArms_m, kArms_m, kLegs_m, kLegs_m};
  PerLimb unusual_m;
  for (std::size_t limb = 0; limb < kLimbCount; ++limb) {
    float& usual_m = usual_m_[limb];
    const bool below = errors_m[limb] < usual_m;
    const float speed = below ? tuning::kGateQuantile - 1 : tuning::kGateQuantile;
    usual_m = std::clamp(usual_m + speed * tuning::kGateLearn_m_s * dt_s, tuning::kGateKnown_m,
                         kMost_m[limb]);
    unusual_m[limb] = errors_m[limb] - (usual_m - tuning::kGateKnown_m);
  }
  return unusual_m;
}

void LimbGate::Mirror() noexcept {
  for (PerLimb* const figures : {&usual_m_, &held_m_, &led_, &weights_}) {
    std::swap((*figures)[Index(Limb::kLeftArm)], (*figures)[Index(Limb::kRightArm)]);
    std::swap((*figures)[Index(Limb::kLeftLeg)], (*figures)[Index(Limb::kRightLeg)]);
  }
}

void LimbGate::Hold(const PerLimb& errors_m, bool first, const net::GateBounds& bounds) noexcept {
  for (std::size_t limb = 0; limb < kLimbCount; ++limb) {
    // Beyond the end nothing changes: a limb's largest error must not delay its return.
    const float most_m = RangeOf(limb, bounds).end_m + tuning::kGateBand_m;
    const float error_m = errors_m[limb] <= most_m ? errors_m[limb] : most_m;  // NaN: the largest
    float& held_m = held_m_[limb];
    held_m = first ? error_m : std::clamp(held_m, error_m, error_m + tuning::kGateBand_m);
  }
}

PerLimb LimbGate::Targets(const net::GateBounds& bounds) const noexcept {
  PerLimb targets;
  for (std::size_t limb = 0; limb < kLimbCount; ++limb) {
    const net::GateBounds::Range& range = RangeOf(limb, bounds);
    targets[limb] = 1 - SmoothStep(held_m_[limb], range.begin_m, range.end_m);
  }
  const float arms = std::min(targets[Index(Limb::kLeftArm)], targets[Index(Limb::kRightArm)]);
  float& trunk = targets[Index(Limb::kTrunk)];
  trunk = std::min(trunk, 1 - tuning::kGateTrunkWithArms * (1 - arms));
  return targets;
}

// Two one-pole filters, the first of another time constant for either direction, each exact for a
// target that is held over the frame. One critically damped filter would carry the speed of a fade
// out into the slow return.
void LimbGate::Follow(const PerLimb& errors_m, float dt_s, bool first,
                      const net::GateBounds& bounds) noexcept {
  Hold(Unusual(errors_m, dt_s), first, bounds);
  const PerLimb targets = Targets(bounds);
  if (first) led_ = weights_ = targets;
  const float close_s = tuning::kGateClose_s;
  const float open_s = tuning::kGateOpen_s;
  const float close_left = std::exp(-dt_s / close_s);
  const float open_left = std::exp(-dt_s / open_s);
  for (std::size_t limb = 0; limb < kLimbCount; ++limb) {
    const float target = targets[limb];
    const float led = led_[limb] - target;
    const float apart = weights_[limb] - target;
    if (led > 0) {
      led_[limb] = target + led * close_left;
      weights_[limb] = target + (apart + led * dt_s / close_s) * close_left;
    } else {
      const float part = led * open_s / (open_s - close_s);
      led_[limb] = target + led * open_left;
      weights_[limb] = target + part * open_left + (apart - part) * close_left;
    }
    weights_[limb] = std::clamp(weights_[limb], 0.0F, 1.0F);
  }
}

bool LimbGate::reduces() const {
  return std::any_of(weights_.begin(), weights_.end(), [](float weight) { return weight < 1; });
}

}  // namespace styled::stylist
