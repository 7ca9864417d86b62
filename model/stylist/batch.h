#pragma once

#include <cstddef>
#include <span>

#include "model/base/realtime.h"
#include "model/stylist/predictor.h"

namespace styled::stylist {

// One performer's frame in a batch: what its network steps read and write. Owns nothing.
struct BatchEntry {
  Predictor* predictor = nullptr;
  const body::Pose* input = nullptr;  // canonical
  const Mixer* mixer = nullptr;
  const StyleDelta* near = nullptr;  // see Predictor::Accept
  net::Performer performer;          // without a neutral: not known
};

// Runs every network step that is due for these frames, with the results of each performer alone,
// bit for bit. Performers that share a network share the reading of its weights. At most kMost
// entries; instantiated for 1, so that a single performer does not pay for a batch's arrays, and
// for net::kTogether. No allocation. Pinned by tests/unit/stylist/stylist_test.cpp.
template <std::size_t kMost>
STYLED_REALTIME void StepTogether(std::span<const BatchEntry> entries) noexcept;

}  // namespace styled::stylist
