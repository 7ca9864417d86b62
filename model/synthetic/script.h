#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "model/base/status.h"

namespace styled::synthetic {

// The motions of the synthetic performer.
enum class Motion : std::uint8_t {
  kStand,
  kWalk,
  kRun,
  kTurnLeft,  // a walking turn
  kTurnRight,
  kWaveLeft,
  kWaveRight,
  kWaveBoth,
  kRaiseLeft,
  kRaiseRight,
  kRaiseBoth,
  kCount
};

// "stand", "walk", "run", "turn-left", "wave-both", ...: the words that ParseScript() accepts.
std::string_view Name(Motion motion) noexcept;

struct ScriptItem {
  Motion motion = Motion::kStand;
  double seconds = 1;
};

// Parses "stand:2,walk:5,turn-left:3": motions and their seconds (0.1 .. 3600; 4 if omitted). "" is
// an empty script. Errors name the item and what was expected.
Result<std::vector<ScriptItem>> ParseScript(std::string_view text);

}  // namespace styled::synthetic
