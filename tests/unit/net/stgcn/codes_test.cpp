#include "model/net/stgcn/codes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "tests/unit/net/stgcn/random_weights.h"

namespace styled::stgcn {
namespace {

struct CodesTest : testing::Test {
  WeightsFile file = RandomWeights(4, 16, 1);
  std::shared_ptr<const Network> network = NetworkOf(file);
  Scratch scratch;
};

float Apart(const Code& a, const Code& b) { return (a - b).cwiseAbs().maxCoeff(); }

TEST_F(CodesTest, ASeedIsAlwaysTheSameNoise) {
  EXPECT_EQ(NoiseOf(7), NoiseOf(7));
  // Computed by another program: what every machine must give.
  EXPECT_NEAR(NoiseOf(1)[0], -0.034267, 1e-5);
  EXPECT_NEAR(NoiseOf(1)[15], 0.928037, 1e-5);
  double sum = 0, squares = 0;
  std::set<float> firsts;
  constexpr int kSeeds = 2000;
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    const Noise noise = NoiseOf(seed);
    firsts.insert(noise[0]);
    sum += static_cast<double>(noise.sum());
    squares += static_cast<double>(noise.squaredNorm());
  }
  EXPECT_EQ(firsts.size(), kSeeds);
  EXPECT_NEAR(sum / (kSeeds * kNoise), 0, 0.03);
  EXPECT_NEAR(squares / (kSeeds * kNoise), 1, 0.04);
}

TEST_F(CodesTest, TheAmountGoesFromTheMeanToTheMappingNetworks) {
  const Code& mean = network->space().mean_code(2);
  const Code noise = NoiseCode(network->space(), 5, 2);
  EXPECT_EQ(noise, network->space().MapNoise(NoiseOf(5), 2));
  EXPECT_LT(Apart(Varied(network->space(), 5, 2, 0), mean), 1e-7F);
  EXPECT_LT(Apart(Varied(network->space(), 5, 2, 1), noise), 1e-6F);
  EXPECT_LT(Apart(Varied(network->space(), 5, 2, 0.5F), 0.5F * (mean + noise)), 1e-6F);
  EXPECT_GT(Apart(Varied(network->space(), 6, 2, 1), noise), 1e-2F);
}

TEST_F(CodesTest, StrengthGoesFromNeutralThroughTheCodeAndBeyond) {
  const Code& neutral = network->space().mean_code(0);
  const Code& old = network->space().mean_code(3);
  EXPECT_EQ(AtStrength(network->space(), old, 0), neutral);
  EXPECT_LT(Apart(AtStrength(network->space(), old, 1), old), 1e-6F);
  EXPECT_LT(Apart(AtStrength(network->space(), old, 1.5F) - old, 0.5F * (old - neutral)), 1e-6F);
}

TEST_F(CodesTest, AMixIsBetweenItsCodesAndNeutralTakesTheRest) {
  const Code &neutral = network->space().mean_code(0), &a = network->space().mean_code(1),
             &b = network->space().mean_code(2);
  const std::array<WeightedCode, 2> whole{{{a, 0.25F}, {b, 0.75F}}}, half{{{a, 0.25F}, {b, 0.25F}}};
  EXPECT_LT(Apart(Mixed(network->space(), whole), 0.25F * a + 0.75F * b), 1e-6F);
  EXPECT_LT(Apart(Mixed(network->space(), half), 0.25F * a + 0.25F * b + 0.5F * neutral), 1e-6F);
  EXPECT_EQ(Mixed(network->space(), {}), neutral);
}

TEST_F(CodesTest, TheNearestDomainAndItsDistance) {
  EXPECT_EQ(Nearest(network->space(), network->space().mean_code(2)).style, 2);
  EXPECT_EQ(Nearest(network->space(), network->space().mean_code(2)).distance, 0);
  const Code far = network->space().mean_code(1) + Code::Constant(100);
  const net::NearestStyle nearest = Nearest(network->space(), far);
  double between = 0, least = 1e9;
  for (int a = 0; a < 4; ++a) {
    least = std::min(least, static_cast<double>((far - network->space().mean_code(a)).norm()));
    for (int b = 0; b < a; ++b) {
      between += static_cast<double>(
                     (network->space().mean_code(a) - network->space().mean_code(b)).norm()) /
                 6;
    }
  }
  EXPECT_NEAR(static_cast<double>(nearest.distance), least / between, 1e-3);
  EXPECT_GT(nearest.distance, 10);
}

TEST_F(CodesTest, AFarCodeIsPulledInAndANearOneStays) {
  const Code near = network->space().mean_code(1) + Code::Constant(1e-3F);
  EXPECT_EQ(PulledIn(network->space(), near), near);
  const Code far = network->space().mean_code(1) + Code::Constant(100);
  const Code& mean = network->space().mean_code(Nearest(network->space(), far).style);
  const Code pulled = PulledIn(network->space(), far);
  EXPECT_NEAR(Nearest(network->space(), pulled).distance, kFarthest, 1e-3F);
  const float share = (pulled - mean).norm() / (far - mean).norm();
  EXPECT_LT(Apart(pulled, mean + share * (far - mean)), 1e-4F) << "straight toward the mean";
}

TEST_F(CodesTest, WithOneDomainThereIsNoDistanceBetween) {
  const auto alone = NetworkOf(RandomWeights(1, 16, 2));
  EXPECT_EQ(Nearest(alone->space(), Code::Ones()).distance, 0);
  EXPECT_EQ(PulledIn(alone->space(), Code::Ones()), Code::Ones());
}

}  // namespace
}  // namespace styled::stgcn
