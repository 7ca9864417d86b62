#include "model/net/stgcn_causal/variations.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "model/net/stgcn/codes.h"
#include "model/synthetic/performer.h"
#include "tests/unit/net/stgcn_causal/random_weights.h"

namespace styled::stgcn_causal {
namespace {

using net::StyleCode;
using net::StyleWeight;
using net::VariationWeight;
using stgcn::kFeatureCount;

constexpr int kDomains = 4;
constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

using Walked = std::vector<Output>;

class VariationsTest : public testing::Test {
 protected:
  static Walked Walk(const Network& network, const std::vector<StyleWeight>& styles,
                     const std::vector<VariationWeight>& variations, int input_style = 0) {
    synthetic::Performer performer(synthetic::Options{});
    State state = network.MakeState();
    stgcn::HeadingState heading;
    Walked out(40);
    for (std::size_t frame = 0; frame < out.size(); ++frame) {
      body::Pose pose;
      performer.Pose(static_cast<double>(frame) / 30, pose);
      Features features;
      stgcn::ComputeFeatures(pose, network.features(), heading, features);
      network.Step(features, input_style, styles, state, out[frame], variations);
    }
    return out;
  }
  static float Furthest(const Walked& a, const Walked& b) {
    float most = 0;
    for (std::size_t frame = 0; frame < a.size(); ++frame) {
      for (std::size_t i = 0; i < kFeatureCount; ++i) {
        most = std::max(most, std::abs(a[frame].styled[i] - b[frame].styled[i]));
        EXPECT_EQ(a[frame].reconstruction[i], b[frame].reconstruction[i]);
      }
    }
    return most;
  }
  // mean + Σ weight (variation - mean), by MakeCode.
  StyleCode CodeOf(int domain, const std::vector<VariationWeight>& variations) const {
    const stgcn::Code& mean = network->space().mean_code(domain);
    StyleCode code(mean.begin(), mean.end());
    for (const VariationWeight& one : variations) {
      net::StyleRequest request;
      request.sources = {{.style = domain, .seed = one.variation, .reference = {}}};
      const StyleCode varied = network->space().MakeCode(request);
      for (std::size_t i = 0; i < code.size(); ++i) {
        code[i] += one.weight * (varied[i] - mean[static_cast<Eigen::Index>(i)]);
      }
    }
    return code;
  }
  std::shared_ptr<const Network> With(const StyleCode& code) const {
    net::StyleInfo other;
    other.name = "other";
    return network->With(network->style_count(), other, code);
  }

  std::shared_ptr<const Network> network = CausalNetwork(RandomWeights(kDomains, 16, 1));
};

TEST_F(VariationsTest, AnInvalidVariationIsIgnored) {
  const Walked plain = Walk(*network, {{2, 1}}, {});
  for (const VariationWeight bad :
       {VariationWeight{0, 1}, VariationWeight{100, 1}, VariationWeight{7, kNaN},
        VariationWeight{7, -1}, VariationWeight{7, 0}, VariationWeight{65535, 1}}) {
    EXPECT_EQ(Furthest(Walk(*network, {{2, 1}}, {bad}), plain), 0)
        << bad.variation << " " << bad.weight;
  }
  EXPECT_GT(Furthest(Walk(*network, {{2, 1}}, {{7, 1}}), plain), 1e-2F) << "the negative control";
}

TEST_F(VariationsTest, WeightsAreLimitedAsThoseOfStyles) {
  const Walked most = Walk(*network, {{2, 1}}, {{7, 1.5F}});
  EXPECT_LT(Furthest(Walk(*network, {{2, 1}}, {{7, 1e9F}}), most), 1e-5F);
  EXPECT_LT(Furthest(Walk(*network, {{2, 1}}, {{7, 1.5F}, {7, 1.5F}}), most), 1e-4F);
  const std::vector<VariationWeight> many(200, {7, 0.01F});
  EXPECT_LT(Furthest(Walk(*network, {{2, 1}}, many), Walk(*network, {{2, 1}}, {{7, 0.99F}})), 1e-4F)
      << "the first 99";
}

TEST_F(VariationsTest, AVariationIsTheStyleThatMakeCodeGivesForItsNumber) {
  for (int domain = 1; domain < kDomains; ++domain) {
    for (const std::vector<VariationWeight>& variations : std::vector<std::vector<VariationWeight>>{
             {{1, 1.0F}}, {{7, 0.8F}}, {{99, 1.5F}}, {{7, 0.5F}, {8, 0.5F}}}) {
      const auto other = With(CodeOf(domain, variations));
      EXPECT_LT(
          Furthest(Walk(*network, {{domain, 1}}, variations), Walk(*other, {{kDomains, 1}}, {})),
          1e-3F)
          << domain << " " << variations[0].variation;
    }
  }
}

TEST_F(VariationsTest, AStyleOfHalfTheWeightVariesByHalfAndNeutralDoesNot) {
  const auto other = With(CodeOf(2, {{7, 1}}));
  EXPECT_LT(Furthest(Walk(*network, {{2, 0.5F}}, {{7, 1}}), Walk(*other, {{kDomains, 0.5F}}, {})),
            1e-3F);
  EXPECT_EQ(Furthest(Walk(*network, {}, {{7, 1}}), Walk(*network, {}, {})), 0);
  EXPECT_EQ(Furthest(Walk(*network, {{0, 1}}, {{7, 1}}, 3), Walk(*network, {{0, 1}}, {}, 3)), 0);
}

TEST_F(VariationsTest, AnAddedStyleHasThoseOfTheNearestDomain) {
  StyleCode code = CodeOf(3, {});
  code[0] += 1e-3F;
  const auto with = With(code);
  StyleCode varied = CodeOf(3, {{7, 1}});
  varied[0] += 1e-3F;
  EXPECT_LT(
      Furthest(Walk(*with, {{kDomains, 1}}, {{7, 1}}), Walk(*With(varied), {{kDomains, 1}}, {})),
      1e-3F);
  EXPECT_GT(Furthest(Walk(*with, {{kDomains, 1}}, {{7, 1}}), Walk(*with, {{kDomains, 1}}, {})),
            1e-2F);
  const net::Styles& styles = with->model().styles;
  EXPECT_FALSE(styles[0].varies);
  for (std::size_t style = 1; style < styles.size(); ++style) EXPECT_TRUE(styles[style].varies);
}

TEST_F(VariationsTest, ManyNoisesGiveTheCodesOfEachAlone) {
  Eigen::MatrixXf noises(stgcn::kNoise, 3);
  for (int k = 0; k < 3; ++k) noises.col(k) = stgcn::NoiseOf(static_cast<std::uint64_t>(k));
  const Eigen::MatrixXf codes = network->space().MapNoises(noises, 2);
  for (int k = 0; k < 3; ++k) {
    const stgcn::Code alone = stgcn::NoiseCode(network->space(), static_cast<std::uint64_t>(k), 2);
    EXPECT_LT((codes.col(k) - alone).cwiseAbs().maxCoeff(), 1e-5F);
  }
}

}  // namespace
}  // namespace styled::stgcn_causal
