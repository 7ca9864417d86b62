#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string_view>

#include "model/base/checkpoint.h"
#include "model/base/realtime.h"
#include "model/body/parts.h"
#include "model/body/pose.h"
#include "model/net/gate_bounds.h"

namespace styled::stylist {

// The limbs whose motion a network can know or not know independently. Head and torso are one,
// because the spine moves both.
enum class Limb : std::uint8_t { kLeftArm, kRightArm, kTrunk, kLeftLeg, kRightLeg };
inline constexpr int kLimbCount = 5;
inline constexpr std::array<std::string_view, kLimbCount> kLimbNames{
    "left-arm", "right-arm", "trunk", "left-leg", "right-leg"};
constexpr Limb LimbOf(body::Part part) {
  switch (part) {
    case body::Part::kLeftArm:
      return Limb::kLeftArm;
    case body::Part::kRightArm:
      return Limb::kRightArm;
    case body::Part::kLeftLeg:
      return Limb::kLeftLeg;
    case body::Part::kRightLeg:
      return Limb::kRightLeg;
    default:
      return Limb::kTrunk;
  }
}

// A figure per limb, by Limb.
using PerLimb = std::array<float, kLimbCount>;

// The distance of `reconstruction` from `input`, per limb: mean distance of its joints, m. Both are
// rotations by body::Joint, the hips' relative to the same heading. Arms are compared in the
// chest's frame and legs in the hips', so that no limb has the error of another; hands and feet
// count by their position, not their rotation.
STYLED_REALTIME PerLimb
LimbErrors_m(std::span<const body::Quat, body::kJointCount> input,
             std::span<const body::Quat, body::kJointCount> reconstruction) noexcept;

// Decides how much of the style each limb shows, by how well the network reconstructs it: 1 for
// acts like those that it was trained on, 0 for a punch, in which the style change of an arm is as
// large as in a wave but points anywhere. For one limb:
//   - an arm or the trunk may have a larger error than usual at its best, on another rig or if rest
//     poses are inaccurate. This error is learnt within a minute and does not count, up to
//     kGateMostUsual_m. Not of legs: kicks would lose height;
//   - a bad reconstruction counts at once; a better one only once it is kGateBand_m better, so that
//     the gate does not flutter (hysteresis);
//   - the weight is 1 below the limb's begin, 0 above its end, smooth between (net::GateBounds);
//   - it falls within a time constant of kGateClose_s and returns within kGateOpen_s, with
// continuous speed, and without falling on once the error is small again. An arm is carried by the
// trunk: when an arm shows none of the style, the trunk shows at most 1 - kGateTrunkWithArms of it,
// because a styled back would turn the punch. Only the past is used. Value type, no allocation; one
// thread at a time. Pinned by tests/unit/stylist/limb_gate_test.cpp.
class LimbGate {
 public:
  // Evaluates one frame, `dt_s` after the one before. `first`: there was none; no smoothing. An
  // error that is not finite counts as an unknown limb. The usual error is kept; Reset clears it.
  // `bounds`: the network's.
  STYLED_REALTIME void Follow(const PerLimb& errors_m, float dt_s, bool first,
                              const net::GateBounds& bounds = {}) noexcept;
  STYLED_REALTIME void Reset() noexcept { *this = LimbGate(); }
  // The following frames are those of the same performer with left and right exchanged.
  STYLED_REALTIME void Mirror() noexcept;

  // 0 .. 1: the share of the style that the limb shows.
  float weight(Limb limb) const { return weights_[static_cast<std::size_t>(limb)]; }
  const PerLimb& weights() const { return weights_; }
  // Whether some limb's style is withheld.
  bool reduces() const;
  // See model/base/checkpoint.h.
  STYLED_REALTIME void Carry(Checkpoint& c) noexcept { c(usual_m_, held_m_, led_, weights_); }

 private:
  PerLimb Unusual(const PerLimb& errors_m, float dt_s) noexcept;
  void Hold(const PerLimb& errors_m, bool first, const net::GateBounds& bounds) noexcept;
  PerLimb Targets(const net::GateBounds& bounds) const noexcept;

  PerLimb usual_m_{};           // a low quantile of the errors so far, at least kGateKnown_m
  PerLimb held_m_{};            // the error that is used
  PerLimb led_{1, 1, 1, 1, 1};  // the first of two one-pole filters; the second gives weights_
  PerLimb weights_{1, 1, 1, 1, 1};
};

}  // namespace styled::stylist
