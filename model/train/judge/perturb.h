#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "model/train/judge/stream.h"

namespace styled::judge {

// Faults of live rigs that training recordings do not show. Deterministic by seed, one draw per
// clip.
enum class Perturbation {
  kRest,    // every joint's rest pose off by a constant rotation of 5 to 15 degrees
  kNoise,   // white noise on every rotation (0.5 degrees rms) and on the hips (2 mm rms)
  kDrift,   // the heading drifts by 20 degrees a minute, the hips by 5 cm/s
  kFloor,   // the floor is 10 cm too high or too low
  kFrozen,  // one limb joint keeps its first rotation
  kLegs,    // steps 15 % too long or too short: the performer's legs differ from the binding's
  kCount
};

struct PerturbationName {
  std::string_view key, text;
};
inline constexpr std::array<PerturbationName, static_cast<std::size_t>(Perturbation::kCount)>
    kPerturbations{{{"rest", "rest poses off by 5 to 15 degrees"},
                    {"noise", "sensor noise, 0.5 degrees and 2 mm"},
                    {"drift", "heading drifts 20 degrees a minute, hips 5 cm/s"},
                    {"floor", "floor 10 cm off"},
                    {"frozen", "one limb joint frozen"},
                    {"legs", "steps 15 % too long or too short"}}};

Poses Perturb(Perturbation kind, const Poses& poses, double rate_hz, std::uint64_t seed);

}  // namespace styled::judge
