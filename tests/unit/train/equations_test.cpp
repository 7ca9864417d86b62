// The equations of Style-ERD's networks (Tao et al. 2022, section 3.1) as plain loops; those of its
// training are in iteration_test.cpp.

#include <gtest/gtest.h>
#include <torch/torch.h>

#include <algorithm>
#include <cmath>

#include "model/train/erd/networks.h"
#include "model/train/geometry.h"

namespace styled::train::style_erd {
namespace {

using torch::Tensor;

double LeakyOf(double x) { return x > 0 ? x : 0.2 * x; }
double Logistic(double x) { return 1 / (1 + std::exp(-x)); }
double FarthestOf(const Tensor& a, const Tensor& b) { return (a - b).abs().max().item<double>(); }

// A convolution over time of x [T, B, C], the ends repeated.
Tensor ConvolvedByLoops(const Parameters& parameters, const std::string& name, int64_t kernel,
                        const Tensor& x) {
  const Tensor weight = parameters.Find(name + ".weight"), bias = parameters.Find(name + ".bias");
  const auto w = weight.accessor<float, 2>();
  const auto in = x.accessor<float, 3>();
  Tensor out = torch::empty({x.size(0), x.size(1), weight.size(0)});
  auto y = out.accessor<float, 3>();
  for (int64_t t = 0; t < x.size(0); ++t) {
    for (int64_t b = 0; b < x.size(1); ++b) {
      for (int64_t o = 0; o < weight.size(0); ++o) {
        double sum = bias[o].item<double>();
        for (int64_t k = 0; k < kernel; ++k) {
          const int64_t at = std::clamp<int64_t>(t + k - kernel / 2, 0, x.size(0) - 1);
          for (int64_t c = 0; c < x.size(2); ++c) sum += w[o][k * x.size(2) + c] * in[at][b][c];
        }
        y[t][b][o] = static_cast<float>(sum);
      }
    }
  }
  return out;
}

// W x + b of a vector.
std::vector<double> AffineByLoops(const Parameters& parameters, const std::string& name,
                                  const std::vector<double>& x) {
  const Tensor weight = parameters.Find(name + ".weight"), bias = parameters.Find(name + ".bias");
  std::vector<double> y;
  for (int64_t o = 0; o < weight.size(0); ++o) {
    double sum = bias[o].item<double>();
    for (std::size_t i = 0; i < x.size(); ++i) {
      sum += weight[o][static_cast<int64_t>(i)].item<double>() * x[i];
    }
    y.push_back(sum);
  }
  return y;
}

// The critic's convolutions: the feature map m_s [T, B, 16].
Tensor FeatureMap(const Parameters& parameters, Tensor x) {
  for (int layer = 0; layer < 5; ++layer) {
    x = ConvolvedByLoops(parameters, "convolution." + std::to_string(layer), 3, x);
    if (layer < 4) x = torch::where(x > 0, x, 0.2 * x);
  }
  return x;
}

// Eq. 1: the sum over features and frames of m_s[i, j] (w_f ⊗ w_t)[i, j].
TEST(ErdEquations, TheCriticsScoreIsTheFeatureMapUnderTheOuterProductOfItsAttentions) {
  torch::manual_seed(11);
  const torch::NoGradGuard no_grad;
  const int64_t frames = 6, styles = 3, contents = 2;
  const Critic critic(10, styles, contents, frames);
  const Tensor x = torch::randn({frames, 2, 10});
  const Tensor labels =
      torch::tensor({{0.0F, 1.0F, 0.0F, 0.0F, 1.0F}, {1.0F, 0.0F, 0.0F, 1.0F, 0.0F}});
  const Tensor score = critic(x, labels), map = FeatureMap(critic.parameters, x);
  for (int64_t b = 0; b < 2; ++b) {
    std::vector<double> a;
    for (int64_t i = 0; i < styles + contents; ++i) a.push_back(labels[b][i].item<double>());
    for (const char* layer : {"attention.0", "attention.1"}) {
      a = AffineByLoops(critic.parameters, layer, a);
      for (double& value : a) value = LeakyOf(value);
    }
    const auto wf = AffineByLoops(critic.parameters, "attention.feature", a);
    const auto wt = AffineByLoops(critic.parameters, "attention.time", a);
    double sum = 0;
    for (int64_t i = 0; i < 16; ++i) {
      for (int64_t j = 0; j < frames; ++j) sum += map[j][b][i].item<double>() * wf[i] * wt[j];
    }
    EXPECT_NEAR(score[b].item<double>(), sum, 1e-5);
  }
}

// The paper's comparison: a head per style over the same feature map; contents are not looked at.
TEST(ErdEquations, WithoutAttentionTheCriticHasAHeadPerStyle) {
  torch::manual_seed(12);
  const torch::NoGradGuard no_grad;
  const int64_t frames = 6, styles = 3;
  const Critic critic(10, styles, 2, frames, false);
  const Tensor x = torch::randn({frames, 1, 10}), map = FeatureMap(critic.parameters, x);
  std::vector<double> flat;
  for (int64_t i = 0; i < frames * 16; ++i) {
    flat.push_back(map[i / 16][0][i % 16].item<double>());
  }
  const auto heads = AffineByLoops(critic.parameters, "heads", flat);
  for (int64_t style = 0; style < styles; ++style) {
    for (int64_t content = 0; content < 2; ++content) {
      Tensor labels = torch::zeros({1, styles + 2});
      labels[0][style] = labels[0][styles + content] = 1.0F;
      EXPECT_NEAR(critic(x, labels).item<double>(), heads[style], 1e-5);
    }
  }
}

// Eq. 7's feature maps: kernel 5, instance norm over time, leaky ReLU.
TEST(ErdEquations, TheClassifiersFeatureMapsAreNormalizedOverTime) {
  torch::manual_seed(13);
  const torch::NoGradGuard no_grad;
  const ContentClassifier classifier(32, 2);
  Tensor x = torch::randn({7, 2, 32});
  const std::vector<Tensor> maps = classifier.Maps(x);
  ASSERT_EQ(maps.size(), 4U);
  for (int layer = 0; layer < 4; ++layer) {
    x = ConvolvedByLoops(classifier.parameters, "convolution." + std::to_string(layer), 5, x);
    auto y = x.accessor<float, 3>();
    for (int64_t b = 0; b < x.size(1); ++b) {
      for (int64_t c = 0; c < x.size(2); ++c) {
        double mean = 0, square = 0;
        for (int64_t t = 0; t < 7; ++t) mean += y[t][b][c] / 7.0;
        for (int64_t t = 0; t < 7; ++t) square += std::pow(y[t][b][c] - mean, 2) / 7.0;
        for (int64_t t = 0; t < 7; ++t) {
          y[t][b][c] = static_cast<float>(LeakyOf((y[t][b][c] - mean) / std::sqrt(square + 1e-5)));
        }
      }
    }
    EXPECT_LT(FarthestOf(maps[static_cast<std::size_t>(layer)], x), 1e-4) << layer;
  }
}

// Eq. 2, of random rotations: half the angle between them, squared, whichever sign they have. The
// series is 2 % too small at 180 degrees.
TEST(ErdEquations, TheQuaternionLossIsTheSquaredArccosine) {
  torch::manual_seed(14);
  Tensor a = torch::randn({200, 4}), b = torch::randn({200, 4});
  a = a / a.norm(2, 1, true);
  b = b / b.norm(2, 1, true);
  const Tensor loss = SquaredHalfAngle(a, b);
  for (int64_t i = 0; i < 200; ++i) {
    const double dot = (a[i] * b[i]).sum().item<double>();
    const double expected = std::pow(std::acos(std::abs(dot)), 2);
    EXPECT_NEAR(loss[i].item<double>(), expected, 0.021 * expected) << dot;
  }
}

// A stack of LSTM layers of two groups, cell by cell: windows that go on start from the carried
// states, the others from the learned ones of their group.
TEST(ErdEquations, AStackStartsFromLearnedOrCarriedStates) {
  torch::manual_seed(15);
  const torch::NoGradGuard no_grad;
  const int64_t groups = 2, layers = 2, width = 3, frames = 4, samples = 2;
  Parameters parameters;
  const Stack stack(parameters, "s", groups, layers, width);
  parameters.Flatten(torch::kCPU);
  const Tensor x = torch::randn({groups, frames, samples, width});
  StackState carried = stack.Initial(samples).Concrete();
  for (int64_t layer = 0; layer < layers; ++layer) {
    carried.h[layer] = torch::randn({groups, samples, width});
    carried.c[layer] = torch::randn({groups, samples, width});
  }
  const Tensor goes_on = torch::tensor({{false, true}, {true, false}}).view({groups, samples, 1});
  StackState state = Stack::Start(stack.Initial(samples), carried, goes_on);
  const Tensor y = stack(x, state);
  for (int64_t g = 0; g < groups; ++g) {
    for (int64_t n = 0; n < samples; ++n) {
      Tensor in = x.select(0, g).select(1, n).clone();  // [T, Z]
      for (int64_t layer = 0; layer < layers; ++layer) {
        const bool on = goes_on[g][n][0].item<bool>();
        Tensor h = (on ? carried.h[layer][g][n] : stack.h0[layer][g]).clone();
        Tensor c = (on ? carried.c[layer][g][n] : stack.c0[layer][g]).clone();
        for (int64_t t = 0; t < frames; ++t) {
          const Tensor gate =
              stack.input[layer][g].mv(in[t]) + stack.hidden[layer][g].mv(h) + stack.bias[layer][g];
          const auto at = [&](int64_t i) { return gate[i].item<double>(); };
          for (int64_t z = 0; z < width; ++z) {
            c[z] = Logistic(at(width + z)) * c[z] + Logistic(at(z)) * std::tanh(at(2 * width + z));
            h[z] = Logistic(at(3 * width + z)) * std::tanh(c[z].item<double>());
          }
          in[t] = h;
        }
        EXPECT_LT(FarthestOf(state.h[layer][g][n], h), 1e-5);
        EXPECT_LT(FarthestOf(state.c[layer][g][n], c), 1e-5);
      }
      EXPECT_LT(FarthestOf(y.select(0, g).select(1, n), in), 1e-5);
    }
  }
}

}  // namespace
}  // namespace styled::train::style_erd
