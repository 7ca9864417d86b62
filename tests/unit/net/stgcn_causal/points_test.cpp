#include "model/net/stgcn_causal/points.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "model/synthetic/performer.h"
#include "tests/unit/net/stgcn_causal/random_weights.h"

namespace styled::stgcn_causal {
namespace {

using net::StyleCode;
using net::StyleWeight;
using stgcn::kCode;
using stgcn::kFeatureCount;

constexpr int kWidth = 16;

class Points : public testing::Test {
 protected:
  Points() : network(CausalNetwork(RandomWeights(3, kWidth, 1))) {}

  StyleCode Mean(int domain) const {
    const stgcn::Code& code = network->space().mean_code(domain);
    return {code.begin(), code.end()};
  }
  // A styled walk in one style of weight `weight`.
  static std::vector<Features> Walk(const Network& network, int style, float weight) {
    synthetic::Performer performer(synthetic::Options{});
    State state = network.MakeState();
    stgcn::HeadingState heading;
    std::vector<Features> out;
    const StyleWeight active[] = {{style, weight}};
    for (int frame = 0; frame < 40; ++frame) {
      body::Pose pose;
      performer.Pose(frame / 30.0, pose);
      Features features;
      stgcn::ComputeFeatures(pose, network.features(), heading, features);
      Output output;
      network.Step(features, 0, active, state, output);
      out.push_back(output.styled);
    }
    return out;
  }
  static float Furthest(const std::vector<Features>& a, const std::vector<Features>& b) {
    float most = 0;
    for (std::size_t frame = 0; frame < a.size(); ++frame) {
      for (std::size_t i = 0; i < kFeatureCount; ++i) {
        most = std::max(most, std::abs(a[frame][i] - b[frame][i]));
      }
    }
    return most;
  }

  std::shared_ptr<const Network> network;
};

TEST_F(Points, ACodeHasOneOfThreeSizes) {
  const PointSpace& points = network->points();
  EXPECT_EQ(points.full_size(), 64U + 147U + 18U * kWidth);
  for (const std::size_t size : {std::size_t{64}, std::size_t{211}, points.full_size()}) {
    EXPECT_TRUE(points.IsSize(size)) << size;
    for (const std::size_t wrong : {size - 1, size + 1}) EXPECT_FALSE(points.IsSize(wrong));
  }
  EXPECT_FALSE(points.IsSize(0));
}

// The same style said in the three ways moves alike, and is the file's own.
TEST_F(Points, ZerosAddNothing) {
  const std::vector<Features> own = Walk(*network, 2, 1);
  for (const std::size_t size :
       {std::size_t{64}, std::size_t{211}, network->points().full_size()}) {
    StyleCode code = Mean(2);
    code.resize(size);
    const auto with = network->With(3, {.name = "mine"}, code);
    EXPECT_EQ(Furthest(Walk(*with, 3, 1), own), 0) << size;
  }
}

// The bias is in deviations, of the output alone, and as large as the style's weight.
TEST_F(Points, ABiasShiftsTheOutput) {
  StyleCode code = Mean(2);
  code.resize(211);
  constexpr std::size_t kJoint = body::kHead;
  constexpr std::size_t kAt = kJoint * stgcn::kChannels + 4;
  code[kCode + kAt] = 0.5F;
  const auto with = network->With(3, {.name = "mine"}, code);
  // One deviation: what 1 instead of 0.5 adds.
  StyleCode more = code;
  more[kCode + kAt] = 1.5F;
  const auto further = network->With(3, {.name = "mine"}, more);
  const auto own = Walk(*network, 2, 1), half = Walk(*with, 3, 1), large = Walk(*further, 3, 1);
  const auto weak = Walk(*further, 3, 0.5F), weak_own = Walk(*network, 2, 0.5F);
  for (std::size_t frame = 0; frame < own.size(); ++frame) {
    const float deviation = large[frame][kAt] - half[frame][kAt];
    EXPECT_NEAR(half[frame][kAt] - own[frame][kAt], deviation / 2, 1e-5);
    EXPECT_NEAR(weak[frame][kAt] - weak_own[frame][kAt], 0.75F * deviation, 1e-5);
    EXPECT_NE(deviation, 0);
    Features same = half[frame];
    same[kAt] = own[frame][kAt];
    EXPECT_EQ(same, own[frame]);
  }
}

// Values added to scale and shift have the effect of a code with those affine maps.
TEST_F(Points, ScaleAndShiftOfAnotherStyleAreThatStyle) {
  const PointSpace& points = network->points();
  const auto one = points.PointOf(Mean(1)), two = points.PointOf(Mean(2));
  StyleCode code = Mean(1);
  code.resize(points.full_size());
  for (std::size_t i = 0; i < points.bias(); ++i) code[211 + i] = (*two)[i] - (*one)[i];
  const auto with = network->With(3, {.name = "mine"}, code);
  EXPECT_LT(Furthest(Walk(*with, 3, 1), Walk(*network, 2, 1)), 1e-4);
  EXPECT_GT(Furthest(Walk(*with, 3, 1), Walk(*network, 1, 1)), 1e-3);
}

}  // namespace
}  // namespace styled::stgcn_causal
