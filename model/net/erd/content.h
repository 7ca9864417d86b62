#pragma once

#include <span>

#include "model/base/realtime.h"
#include "model/net/erd/network.h"
#include "model/net/erd/weights.h"

// The content input of a network that takes one: as the caller knows the content, or as the causal
// recognizer does from the frames so far (equations in FORMAT.md). Nothing here
// allocates or throws. Pinned by tests/unit/net/erd/content_test.cpp.
namespace styled::erd {

// One performer's content in a step.
template <Shape kShape>
struct ContentJob {
  const float* u = nullptr;  // the standardized features
  int content = net::kContentRecognized;
  StateOf<kShape>* state = nullptr;
  const float* bias = nullptr;                  // of the encoder's first layer
  PackedVector<kShape.encoder>* out = nullptr;  // the same with the content's part
};

// Before the encoder: starts the neutral branch of a new state as the content's, advances the
// recognizer by one frame, whatever the content, and writes `out`. At most net::kTogether jobs; a
// job's result does not depend on the others, bit for bit.
template <Shape kShape>
STYLED_REALTIME void AddContents(const Kernels& kernels, const ContentWeights<kShape>& weights,
                                 std::span<const ContentJob<kShape>> jobs) noexcept;

template <Shape kShape>
STYLED_REALTIME void StartRecognizer(const ContentWeights<kShape>& weights,
                                     RecognizerStateOf<kShape>& state) noexcept;

// P of the last frame; `shares` has one for each content.
template <Shape kShape>
STYLED_REALTIME void Recognized(const Kernels& kernels, const ContentWeights<kShape>& weights,
                                const RecognizerStateOf<kShape>& state,
                                std::span<float> shares) noexcept;

}  // namespace styled::erd
