#pragma once

#include <cstddef>
#include <span>

#include "model/base/realtime.h"
#include "model/stylist/predictor.h"

namespace styled::stylist {

// One performer's frame among others: what its network steps read and write. Nothing is owned.
struct BatchEntry {
  Predictor* predictor = nullptr;
  const body::Pose* input = nullptr;  // canonical
  const Mixer* mixer = nullptr;
  const StyleDelta* near = nullptr;  // see Predictor::Accept
};

// Runs every step that is due for these frames, bit for bit as each performer alone: performers who
// share a network share the reading of its weights. At most kMost entries; instantiated for 1,
// which keeps a single performer's frame free of the arrays that a batch needs, and kMaxBatch. No
// allocation.
inline constexpr std::size_t kMaxBatch = 8;  // Stylist::kTogether
template <std::size_t kMost>
STYLED_REALTIME void StepTogether(std::span<const BatchEntry> entries) noexcept;

}  // namespace styled::stylist
