#pragma once

#include <cmath>
#include <memory>
#include <numeric>
#include <utility>
#include <vector>

#include "tests/unit/net/erd/random_weights.h"

namespace styled::erd {

// The steps of one performer for a benchmark: synthetic features, `styles` styles at equal weights.
template <Shape kShape>
struct StepRunOf {
  using Job = StepJobOf<kShape>;
  static constexpr int kFrames = 256;

  std::shared_ptr<const ShapedNetwork<kShape>> network;
  std::vector<Features> frames{kFrames};
  std::vector<net::StyleWeight> active;
  StateOf<kShape> state;
  net::Prediction out;
  int frame = 0;

  StepRunOf(std::shared_ptr<const ShapedNetwork<kShape>> the_network, int styles)
      : network(std::move(the_network)) {
    for (int f = 0; f < kFrames; ++f) {
      for (int i = 0; i < kFeatureCount; ++i) {
        frames[f][i] = 0.5F * std::sin(0.01F * static_cast<float>(f * (1 + i % 7) + 37 * i));
      }
    }
    for (int s = 1; s <= styles; ++s) active.push_back({s, 1.0F / static_cast<float>(styles)});
    network->Start(state);
  }
  const Features& NextFrame() { return frames[frame++ % kFrames]; }
  void Step() { network->Step(NextFrame(), 0, active, state, out); }
};
using StepRun = StepRunOf<kPaper>;

// Simulates other work between two frames at 120 Hz: reads 8 MB, so that the next step finds a cold
// L2 cache.
class OtherWork {
 public:
  int Read() const { return std::accumulate(data_.begin(), data_.end(), 0); }

 private:
  std::vector<int> data_ = std::vector<int>((std::size_t{8} << 20) / sizeof(int), 1);
};

}  // namespace styled::erd
