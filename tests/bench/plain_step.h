#pragma once

#include <array>
#include <memory>
#include <span>

#include "tests/unit/net/erd/random_weights.h"

namespace styled::erd {

// The network's step as plain Eigen code of fixed sizes, compiled with the build's default flags.
// It is the reference for measuring Network::Step's own kernels. One performer; neutral input; the
// styles given at construction are in force from the first step on.
class PlainStep {
 public:
  PlainStep(const WeightsFile& file, std::span<const net::StyleWeight> active);
  ~PlainStep();
  void Step(const Features& features, net::Prediction& out) noexcept;

 private:
  struct Weights;
  std::unique_ptr<Weights> weights_;
  std::vector<net::StyleWeight> active_;
  BranchState neutral_;
  std::array<BranchState, net::kMaxActive> branches_;
};

}  // namespace styled::erd
