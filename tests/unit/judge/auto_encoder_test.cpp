#include "model/train/judge/auto_encoder.h"

#include <gtest/gtest.h>

#include "model/net/erd/features.h"
#include "model/train/judge/classifier.h"

namespace styled::judge {
namespace {

using torch::Tensor;

// Eq. 2 of Style-ERD, joint by joint.
double LossByLoops(const Tensor& expected, const Tensor& found) {
  double sum = 0;
  for (int64_t n = 0; n < expected.size(0); ++n) {
    for (int64_t t = 0; t < expected.size(2); ++t) {
      for (int64_t j = 0; j < body::kJointCount; ++j) {
        const Tensor a = expected[n].narrow(0, 4 * j, 4).select(1, t);
        const Tensor b = found[n].narrow(0, 4 * j, 4).select(1, t);
        const double cosine = (a.dot(b) / a.norm() / b.norm()).item<double>();
        sum += std::pow(std::acos(std::min(1.0, std::abs(cosine))), 2);
      }
    }
  }
  return sum / static_cast<double>(expected.size(0) * expected.size(2) * body::kJointCount);
}

TEST(AutoEncoderTest, ItsLossIsTheSquaredHalfAngleBetweenRotationsOfAnyLength) {
  torch::manual_seed(1);
  const Tensor a = torch::randn({2, erd::kRotationFeatures, 5}), b = torch::randn_like(a);
  EXPECT_NEAR(QuaternionLoss(a, b).item<double>(), LossByLoops(a, b), 1e-5);
  EXPECT_NEAR(QuaternionLoss(a, -3 * b).item<double>(), LossByLoops(a, b), 1e-5);
  EXPECT_LT(QuaternionLoss(a, a).item<double>(), 1e-5);
}

// The supplement of Style-ERD: noise N(0, 0.03) on the rotations, which are to be restored without.
TEST(AutoEncoderTest, RestoresRotationsFromSuchWithNoise) {
  torch::manual_seed(2);
  AutoEncoder network;  // in training, where it normalizes by the batch
  const torch::NoGradGuard no_grad;
  const Tensor r = 0.2 * torch::randn({3, erd::kRotationFeatures, 32});
  const Tensor mean = torch::randn({1, erd::kRotationFeatures, 1});
  EXPECT_EQ(network->Encode(r).sizes(), torch::IntArrayRef({3, 512, 3}));
  torch::manual_seed(3);
  const double loss = network->Loss(r, mean).item<double>();
  torch::manual_seed(3);
  const Tensor noisy = r + 0.03 * torch::randn({3, erd::kRotationFeatures, 32});
  const Tensor decoded = network->decoder->forward(network->encoder->forward(noisy - mean)) + mean;
  EXPECT_NEAR(loss, LossByLoops(r, decoded), 1e-5);
  const Tensor without = network->decoder->forward(network->encoder->forward(r - mean)) + mean;
  EXPECT_GT(std::abs(loss - LossByLoops(r, without)), 5e-5) << "the noise shows";
}

TEST(ClassifierTest, PoolsMeanAndMaximumOverTime) {
  torch::manual_seed(4);
  const torch::NoGradGuard no_grad;
  Classifier classifier(10, 3);
  classifier->eval();
  const Tensor x = torch::randn({2, 10, 32}), map = classifier->layers->forward(x);
  const Tensor pooled = classifier->Pool(x);
  for (int64_t n = 0; n < 2; ++n) {
    for (int64_t c = 0; c < 128; ++c) {
      double sum = 0, most = -1e9;
      for (int64_t t = 0; t < map.size(2); ++t) {
        const double value = map[n][c][t].item<double>();
        sum += value;
        most = std::max(most, value);
      }
      EXPECT_NEAR(pooled[n][c].item<double>(), sum / static_cast<double>(map.size(2)), 1e-6);
      EXPECT_NEAR(pooled[n][128 + c].item<double>(), most, 1e-6);
    }
  }
  EXPECT_TRUE(torch::allclose(classifier->forward(x), classifier->head(pooled)));
}

}  // namespace
}  // namespace styled::judge
