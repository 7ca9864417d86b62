#include "model/net/stgcn_causal/space.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "model/synthetic/performer.h"
#include "tests/unit/net/stgcn_causal/random_weights.h"

namespace styled::stgcn_causal {
namespace {

using net::StyleCode;
using stgcn::Features;
using stgcn::kCode;
using stgcn::kFeatureCount;

std::vector<body::Pose> Walk(int frames) {
  synthetic::Performer performer(synthetic::Options{});
  std::vector<body::Pose> poses(static_cast<std::size_t>(frames));
  for (int i = 0; i < frames; ++i) performer.Pose(i / 30.0, poses[static_cast<std::size_t>(i)]);
  return poses;
}

class Space : public testing::Test {
 protected:
  Space() : network(CausalNetwork(RandomWeights(4, 16, 1))), space(network) {}

  static net::StyleSource Example(const std::vector<body::Pose>& poses, float weight = 1) {
    return {.style = -1, .seed = {}, .reference = poses, .weight = weight};
  }
  // The mean of what `poses` become in a style, or, with number 0, of themselves.
  Features MeanOf(const Network& with, const std::vector<body::Pose>& poses, int number) const {
    State state = with.MakeState(), again = with.MakeState();
    stgcn::HeadingState heading;
    Features sum{};
    const net::StyleWeight active[] = {{number, 1.0F}};
    for (std::size_t i = 0; i < poses.size(); ++i) {
      Features features;
      Output neutral, out;
      stgcn::ComputeFeatures(poses[i], with.features(), heading, features);
      with.Step(features, 0, {}, state, neutral);
      with.Step(neutral.reconstruction, 0, active, again, out);
      if (i < 32) continue;
      for (std::size_t k = 0; k < sum.size(); ++k) {
        sum[k] +=
            (number == 0 ? features[k] : out.styled[k]) / static_cast<float>(poses.size() - 32);
      }
    }
    return sum;
  }

  std::shared_ptr<const Network> network;
  ExampleSpace space;
};

TEST_F(Space, CodesOfStylesAndOfChanceHaveNoBias) {
  for (const net::StyleSource& source :
       {net::StyleSource{.style = 2}, net::StyleSource{.style = 2, .seed = 7}}) {
    const StyleCode code = space.MakeCode({.sources = {source}});
    EXPECT_EQ(code, network->space().MakeCode({.sources = {source}}));
    EXPECT_TRUE(space.IsCode(code));
  }
  EXPECT_FALSE(space.IsCode(StyleCode(100)));
  EXPECT_FALSE(space.IsCode({}));
}

// The network's output for an example, made neutral and styled again, stands as the example does.
TEST_F(Space, AnExampleStandsWhereItStood) {
  const std::vector<body::Pose> example = Walk(120);
  const StyleCode code = space.MakeCode({.sources = {Example(example)}});
  ASSERT_EQ(code.size(), static_cast<std::size_t>(kCode) + kFeatureCount);
  const StyleCode alone(code.begin(), code.begin() + kCode);
  const Features wanted = MeanOf(*network, example, 0);
  const auto off = [&](const StyleCode& style) {
    const Features found = MeanOf(*network->With(4, {.name = "mine"}, style), example, 4);
    float most = 0;
    for (std::size_t k = 0; k < found.size(); ++k) {
      most = std::max(most, std::abs(found[k] - wanted[k]));
    }
    return most;
  };
  EXPECT_LT(off(code), 1e-3F);
  EXPECT_GT(off(alone), 0.05F);  // random weights
}

TEST_F(Space, TheBiasIsAsLargeAsWeightAndStrength) {
  const std::vector<body::Pose> example = Walk(90);
  const StyleCode whole = space.MakeCode({.sources = {Example(example)}});
  const StyleCode part =
      space.MakeCode({.sources = {Example(example, 0.5F)}, .amount = 1, .strength = 0.6F});
  for (std::size_t i = kCode; i < whole.size(); ++i) EXPECT_NEAR(part[i], 0.3F * whole[i], 1e-5);
}

TEST_F(Space, ADifferenceIsNeutralPlusWhatTheTwoDifferBy) {
  const std::vector<body::Pose> example = Walk(90);
  const StyleCode style = space.MakeCode({.sources = {Example(example)}});
  const StyleCode neutral = space.MakeCode({.sources = {{.style = 0}}});
  const StyleCode none = space.Difference(style, style);
  ASSERT_EQ(none.size(), style.size());
  for (std::size_t i = 0; i < none.size(); ++i) {
    EXPECT_NEAR(none[i], i < neutral.size() ? neutral[i] : 0, 1e-5) << i;
  }
  const StyleCode one = space.MakeCode({.sources = {{.style = 1}}});
  const StyleCode two = space.MakeCode({.sources = {{.style = 2}}});
  const StyleCode between = space.Difference(two, one);
  for (std::size_t i = 0; i < neutral.size(); ++i) {
    EXPECT_NEAR(between[i], neutral[i] + two[i] - one[i], 1e-5);
  }
}

TEST_F(Space, WhatIsFarOutIsLimited) {
  StyleCode code = space.MakeCode({.sources = {{.style = 1}}});
  code.resize(network->points().full_size(), 1e30F);
  const StyleCode limited = space.Limited(code);
  ASSERT_EQ(limited.size(), code.size());
  for (std::size_t i = kCode; i < limited.size(); ++i) EXPECT_EQ(limited[i], kMaxStandardized);
}

TEST_F(Space, AnExampleOfTheFewestFramesIsEnough) {
  const std::vector<body::Pose> example = Walk(space.least_frames());
  const StyleCode code = space.MakeCode({.sources = {Example(example)}});
  for (const float number : code) EXPECT_TRUE(std::isfinite(number));
}

}  // namespace
}  // namespace styled::stgcn_causal
