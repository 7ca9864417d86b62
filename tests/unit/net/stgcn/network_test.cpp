// The networks against plain loops in double, on every SIMD target that this machine supports.
#include "model/net/stgcn/network.h"

#include <gtest/gtest.h>

#include <random>

#include "model/net/stgcn/code_space.h"
#include "tests/unit/net/kernels/each_target.h"
#include "tests/unit/net/stgcn/random_weights.h"
#include "tests/unit/net/stgcn/reference.h"

namespace styled::stgcn {
namespace {

constexpr float kTolerance = 1e-4F;  // of standardized features and of codes

std::vector<Features> Generate(const Network& network, const std::vector<Features>& clip,
                               const Code& code) {
  Scratch scratch;
  Network::Content content;
  network.Encode(clip, content, scratch);
  std::vector<Features> out(clip.size());
  network.Decode(content, code, out, scratch);
  return out;
}

// The largest difference of two clips, in the features' deviations.
float Largest(const std::vector<Features>& a, const std::vector<Features>& b,
              const WeightsFile& file) {
  const std::vector<float>& deviation = file.tensor("features.deviation").values;
  float largest = 0;
  for (std::size_t t = 0; t < a.size(); ++t) {
    for (std::size_t i = 0; i < kFeatureCount; ++i) {
      const float difference = std::abs(a[t][i] - b[t][i]) / deviation[i];
      if (!(difference <= largest)) largest = difference;  // also NaN
    }
  }
  return largest;
}

TEST(Network, AnyClipIsThatOfTheEquations) {
  const WeightsFile file = RandomWeights(3, 16, 1);
  const Reference reference(file);
  for (const int frames : {8, 9, 15, 64, 65, 66, 67, 257}) {
    const std::vector<Features> walk = WalkFeatures(frames, {});
    const std::vector<Features> expected = reference.Generate(walk, Code::Constant(0.3F));
    const std::vector<Features> still(expected.size(), expected[0]);
    EXPECT_GT(Largest(expected, still, file), 0.1F) << "or nothing would tell frames apart";
    net::OnEachTarget([&] {
      const auto network = NetworkOf(file);
      EXPECT_LT(Largest(Generate(*network, walk, Code::Constant(0.3F)), expected, file), kTolerance)
          << net::BestRowKernels().target << ", " << frames << " frames";
    });
  }
}

TEST(Network, AnyWidthIsThatOfTheEquations) {
  std::mt19937 random(2);
  for (const int width : {32, 48, 64}) {
    const WeightsFile file = RandomWeights(2, width, static_cast<unsigned>(width));
    const auto network = NetworkOf(file);
    EXPECT_EQ(network->width(), width);
    const std::vector<Features> walk = WalkFeatures(36, {});
    Code code;
    for (float& value : code) value = std::uniform_real_distribution<float>(-1, 1)(random);
    const auto expected = Reference(file).Generate(walk, code);
    EXPECT_LT(Largest(Generate(*network, walk, code), expected, file), kTolerance) << width;
    EXPECT_GT(Largest(Generate(*network, walk, Code::Zero()), expected, file), 100 * kTolerance)
        << width;
  }
}

TEST(Network, TheHipsStayOverTheOrigin) {
  const auto network = NetworkOf(RandomWeights(2, 16, 3));
  for (const Features& frame : Generate(*network, WalkFeatures(20, {}), Code::Ones())) {
    EXPECT_EQ(frame[0], 0);
    EXPECT_NE(frame[1], 0);
    EXPECT_EQ(frame[2], 0);
  }
}

TEST(Network, AScratchThatServedALongerClipGivesTheSameBits) {
  const WeightsFile file = RandomWeights(2, 16, 4);
  const auto network = NetworkOf(file);
  const std::vector<Features> clip = WalkFeatures(41, {}), other = WalkFeatures(120, {});
  const std::vector<Features> alone = Generate(*network, clip, Code::Ones());
  Scratch scratch;
  Network::Content content;
  std::vector<Features> out(other.size());
  network->Encode(other, content, scratch);
  network->Decode(content, Code::Zero(), out, scratch);
  network->space().EncodeStyle(other, 1, scratch);
  network->Encode(clip, content, scratch);
  out.resize(clip.size());
  network->Decode(content, Code::Ones(), out, scratch);
  EXPECT_EQ(Largest(out, alone, file), 0);
}

TEST(Network, StyleCodesAreThoseOfTheEquations) {
  const WeightsFile file = RandomWeights(3, 16, 5);
  const Reference reference(file);
  const std::vector<Features> walk = WalkFeatures(kReference, {});
  net::OnEachTarget([&] {
    const auto network = NetworkOf(file);
    Scratch scratch;
    for (const int domain : {0, 1, 2, kFreeHead}) {
      const Code found = network->space().EncodeStyle(walk, domain, scratch);
      const Code expected = reference.EncodeStyle(walk, domain);
      EXPECT_LT((found - expected).cwiseAbs().maxCoeff(), kTolerance) << domain;
      EXPECT_GT(expected.cwiseAbs().maxCoeff(), 0.1F) << domain;
    }
  });
}

TEST(Network, ALongReferenceIsTheMeanOfItsWindows) {
  const auto network = NetworkOf(RandomWeights(3, 16, 6));
  Scratch scratch;
  for (const int frames : {64, 79, 80, 81, 240}) {
    const std::vector<Features> walk = WalkFeatures(frames, {});
    Code sum = Code::Zero();
    int windows = 0;
    for (int begin = 0; begin + kReference <= frames; begin += kReferenceHop, ++windows) {
      sum += network->space().EncodeStyle(
          std::span(walk).subspan(static_cast<std::size_t>(begin), 64), 1, scratch);
    }
    const Code mean = sum / static_cast<float>(windows);
    EXPECT_LT((network->space().EncodeStyle(walk, 1, scratch) - mean).cwiseAbs().maxCoeff(), 1e-5F)
        << frames;
  }
}

TEST(Network, AShortReferenceIsFilledUpWithItsEnds) {
  const auto network = NetworkOf(RandomWeights(3, 16, 7));
  Scratch scratch;
  for (const int frames : {1, 2, 31, 63}) {
    const std::vector<Features> walk = WalkFeatures(frames, {});
    std::vector<Features> filled = walk;
    while (filled.size() < kReference) {
      filled.push_back(filled.back());
      if (filled.size() < kReference) filled.insert(filled.begin(), filled.front());
    }
    EXPECT_EQ(network->space().EncodeStyle(walk, 2, scratch),
              network->space().EncodeStyle(filled, 2, scratch))
        << frames;
  }
}

TEST(Network, NoiseBecomesTheCodeOfTheEquations) {
  const WeightsFile file = RandomWeights(3, 16, 8);
  const auto network = NetworkOf(file);
  const Reference reference(file);
  std::mt19937 random(8);
  for (int domain = 0; domain < 3; ++domain) {
    Noise noise;
    for (float& value : noise) value = std::normal_distribution<float>()(random);
    const Code found = network->space().MapNoise(noise, domain);
    EXPECT_LT((found - reference.MapNoise(noise, domain)).cwiseAbs().maxCoeff(), 1e-5F) << domain;
    EXPECT_LT(found.cwiseAbs().maxCoeff(), 1.0F);
    EXPECT_NE(found, network->space().MapNoise(noise, (domain + 1) % 3));
  }
}

}  // namespace
}  // namespace styled::stgcn
