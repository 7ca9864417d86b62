#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "model/body/humanoid.h"

namespace styled::body {

// The body parts that can be styled separately. Hands belong to the arms, feet to the legs, the
// hips to the torso. A part is styled by its joints' local rotations, so styled arms stay attached
// to a torso as captured.
enum class Part : std::uint8_t { kHead, kTorso, kLeftArm, kRightArm, kLeftLeg, kRightLeg };
inline constexpr int kPartCount = 6;
inline constexpr std::array<std::string_view, kPartCount> kPartNames{
    "head", "torso", "left-arm", "right-arm", "left-leg", "right-leg"};

constexpr Part PartOf(int joint) {
  if (joint == kNeck || joint == kHead) return Part::kHead;
  if (joint <= kChest) return Part::kTorso;
  if (joint <= kLeftHand) return Part::kLeftArm;
  if (joint <= kRightHand) return Part::kRightArm;
  return joint <= kLeftToes ? Part::kLeftLeg : Part::kRightLeg;
}

// A set of parts, one bit each.
using Parts = std::uint8_t;
inline constexpr Parts kAllParts = (1U << kPartCount) - 1;
constexpr Parts Bit(Part part) { return static_cast<Parts>(1U << static_cast<unsigned>(part)); }

// Parses a comma-separated list. Each word is one of kPartNames, "arms", "legs", "upper" (head,
// torso and arms) or "all". Empty if any word is unknown.
std::optional<Parts> FindParts(std::string_view list);
// The words that FindParts accepts, for messages.
inline constexpr std::string_view kPartWords =
    "head, torso, left-arm, right-arm, left-leg, right-leg, arms, legs, upper, all";
// The inverse of FindParts: "left-arm,right-arm", or "all".
std::string PartsText(Parts parts);

}  // namespace styled::body
