// The views of critics of a part of a window.

#include "model/train/erd/views.h"

#include <gtest/gtest.h>

namespace styled::train::style_erd {
namespace {

using torch::Tensor;

constexpr int64_t kJoints = 21, kPositions = 3 * kJoints;

double Largest(const Tensor& a, const Tensor& b) { return (a - b).abs().max().item<double>(); }

TEST(ViewsTest, MovementDoesNotDependOnPostureOrSpeed) {
  torch::manual_seed(1);
  const Tensor window = torch::randn({24, 2, 2 * kPositions});
  const Tensor moved = window + torch::randn({1, 2, 2 * kPositions});
  EXPECT_LT(Largest(Seen(window, View::kMovement), Seen(moved, View::kMovement)), 1e-5);
  const Tensor wider = window.narrow(2, 30, 3).mul(2.0);
  Tensor other = window.clone();
  other.narrow(2, 30, 3).copy_(wider);
  EXPECT_GT(Largest(Seen(window, View::kMovement), Seen(other, View::kMovement)), 0.5);
}

TEST(ViewsTest, LegsAreTheEightJointsBelowTheHips) {
  const Tensor window =
      torch::arange(24 * 2 * 2 * kPositions).to(torch::kFloat32).view({24, 2, -1});
  const Tensor legs = Seen(window, View::kLegs);
  ASSERT_EQ(legs.size(2), FeaturesOf(View::kLegs));
  ASSERT_EQ(legs.size(2), 48);
  EXPECT_EQ(Largest(legs.narrow(2, 0, 24), window.narrow(2, 3 * 13, 24)), 0);
  EXPECT_EQ(Largest(legs.narrow(2, 24, 24), window.narrow(2, kPositions + 3 * 13, 24)), 0);
}

TEST(ViewsTest, TheWholeIsAsItIs) {
  const Tensor window = torch::randn({24, 2, 2 * kPositions});
  EXPECT_EQ(Largest(Seen(window, View::kWhole), window), 0);
  EXPECT_EQ(FeaturesOf(View::kWhole), window.size(2));
  EXPECT_EQ(FeaturesOf(View::kMovement), window.size(2));
}

}  // namespace
}  // namespace styled::train::style_erd
