// The layers against their equations, written out node by node.

#include "model/train/stgcn/layers.h"

#include <gtest/gtest.h>
#include <torch/torch.h>

#include "model/train/stgcn/adam_with_decay.h"
#include "model/train/stgcn/losses.h"
#include "model/train/stgcn/networks.h"
#include "model/train/stgcn/normalized_leaky.h"

namespace styled::train::st_gcn {
namespace {

using stgcn::kLabelCount;
using torch::Tensor;

double Largest(const Tensor& a, const Tensor& b) {
  return (a.to(torch::kFloat64) - b.to(torch::kFloat64)).abs().max().item<double>();
}

Tensor Dense(const Eigen::MatrixXf& matrix) {
  Tensor out = torch::empty({matrix.rows(), matrix.cols()});
  for (int i = 0; i < matrix.rows(); ++i) {
    for (int j = 0; j < matrix.cols(); ++j) out[i][j] = matrix(i, j);
  }
  return out;
}

// y_i = Σ_k Σ_j A_k[j, i] (W_k x_j + b_k) + node bias, as the equation reads.
Tensor ByTheEquation(const GraphConv& conv, const Tensor& x,
                     stgcn::Normalization by = stgcn::Normalization::kNeighbours) {
  const int64_t out = conv.bias.size(0) / kLabelCount;
  Tensor y = conv.node_bias.expand({x.size(0), x.size(1), -1, -1}).clone();
  const auto adjacency = stgcn::Adjacency(conv.level, by);
  for (int k = 0; k < kLabelCount; ++k) {
    const Tensor inner = torch::matmul(x, conv.weight.narrow(0, k * out, out).t()) +
                         conv.bias.narrow(0, k * out, out);
    y = y + torch::einsum("btjc,ji->btic", {inner, Dense(adjacency[k])});
  }
  return y;
}

class Layers : public testing::Test {
 protected:
  void SetUp() override { torch::manual_seed(3); }
  const torch::NoGradGuard no_grad_;
  const Graph graph_{torch::kCPU, torch::kFloat32};
};

TEST_F(Layers, AGraphConvolutionIsItsEquationOnEveryLevel) {
  for (int level = 0; level < stgcn::kLevels; ++level) {
    Parameters parameters;
    const GraphConv conv(parameters, "c", level, 5, 6, true);
    parameters.Flatten(torch::kCPU);
    parameters.flat().normal_();
    const Tensor x = torch::randn({2, 4, stgcn::kNodes[level], 5});
    EXPECT_LT(Largest(conv(graph_, x), ByTheEquation(conv, x)), 1e-5) << level;
    const auto by = stgcn::Normalization::kSubset;
    const Graph subsets(torch::kCPU, torch::kFloat32, by);
    EXPECT_LT(Largest(conv(subsets, x), ByTheEquation(conv, x, by)), 1e-5) << level;
    EXPECT_GT(Largest(conv(subsets, x), conv(graph_, x)), 1e-2) << level;
  }
}

TEST_F(Layers, PoolingBeforeTheProductIsTheSameAsAfterIt) {
  for (int level = 0; level + 1 < stgcn::kLevels; ++level) {
    Parameters parameters;
    const GraphConv conv(parameters, "c", level, 5, 6, true);
    parameters.Flatten(torch::kCPU);
    parameters.flat().normal_();
    const Tensor x = torch::randn({2, 4, stgcn::kNodes[level], 5});
    const Tensor nodes =
        torch::einsum("btjc,ji->btic", {ByTheEquation(conv, x), Dense(stgcn::Pooling(level))});
    const Tensor pairs = nodes.view({2, 2, 2, nodes.size(2), 6}).mean(2);
    EXPECT_LT(Largest(conv.Pooled(graph_, x), pairs), 1e-5);
  }
}

TEST_F(Layers, StretchInterpolatesBetweenTheFirstAndTheLastFrame) {
  const Tensor stretch = graph_.Stretch(4);
  const Tensor line = torch::tensor({1.0F, 2.0F, 3.0F, 4.0F});
  const Tensor expected = torch::linspace(1, 4, 8);
  EXPECT_LT(Largest(torch::matmul(stretch, line), expected), 1e-6);
}

TEST_F(Layers, ATemporalConvolutionSeesAFrameAndItsNeighboursOfTheSameNode) {
  Parameters parameters;
  const TemporalConv conv(parameters, "t", 4);
  parameters.Flatten(torch::kCPU);
  Tensor x = torch::zeros({1, 8, 3, 4});
  x[0][4][1][2] = 1;
  const Tensor y = conv(x) - conv.bias;
  for (int t = 0; t < 8; ++t) {
    for (int v = 0; v < 3; ++v) {
      const bool near = v == 1 && t >= 3 && t <= 5;
      const Tensor expected = near ? conv.weight.select(1, 2).select(1, 5 - t) : torch::zeros({4});
      EXPECT_LT(Largest(y[0][t][v], expected), 1e-6) << t << ' ' << v;
    }
  }
  EXPECT_LT(Largest(conv(x, 0.5), 0.5 * conv(x)), 1e-6);
}

// Values and all gradients, where slopes and signs differ.
TEST(NormalizedLeakyTest, InOnePassIsTheSameAsInParts) {
  torch::manual_seed(4);
  for (const auto type : {torch::kFloat32, torch::kBFloat16}) {
    const Tensor x = (3 + torch::randn({3, 8, 5, 16})).to(type).requires_grad_(true);
    const Tensor scale = torch::randn({3, 16}).requires_grad_(true);
    const Tensor shift = torch::randn({3, 16}).requires_grad_(true);
    const Tensor weight = torch::randn({3, 8, 5, 16}).to(type);
    const auto run = [&](const Tensor& y) {
      auto all = torch::autograd::grad({(y * weight).sum()}, {x, scale, shift});
      all.push_back(y.detach());
      return all;
    };
    const auto one = run(NormalizedLeaky(x, scale, shift));
    const auto parts = run(NormalizedLeakyByParts(x, scale, shift));
    // bfloat16 has 8 bits: half a unit in the last place of numbers up to 8
    const double tolerance = type == torch::kFloat32 ? 2e-5 : 0.04;
    for (std::size_t i = 0; i < one.size(); ++i)
      EXPECT_LT(Largest(one[i], parts[i]), tolerance) << i;
  }
}

TEST(NormalizedLeakyTest, OneScaleForAllSamplesGetsTheGradientOfAll) {
  torch::manual_seed(4);
  const Tensor x = torch::randn({3, 8, 5, 16});
  const Tensor scale = torch::randn({1, 16}).requires_grad_(true);
  const Tensor shift = torch::randn({1, 16}).requires_grad_(true);
  const auto one =
      torch::autograd::grad({NormalizedLeaky(x, scale, shift).square().sum()}, {scale, shift});
  const auto parts = torch::autograd::grad({NormalizedLeakyByParts(x, scale, shift).square().sum()},
                                           {scale, shift});
  EXPECT_LT(Largest(one[0], parts[0]), 1e-3);
  EXPECT_LT(Largest(one[1], parts[1]), 1e-3);
}

TEST(AdamWithDecayTest, IsAdamWithTheWeightsAddedToTheGradient) {
  torch::manual_seed(5);
  const torch::NoGradGuard no_grad;
  Parameters ours, theirs;
  ours.Add("w", {1000}, 1);
  theirs.Add("w", {1000}, 1);
  ours.Flatten(torch::kCPU);
  theirs.Flatten(torch::kCPU);
  theirs.flat().copy_(ours.flat());
  AdamWithDecay one(ours, 0.5, 0.99);
  Adam parts(theirs, 0.5, 0.99);
  for (int i = 0; i < 5; ++i) {
    ours.gradient().normal_();
    theirs.gradient().copy_(ours.gradient() + 0.1 * theirs.flat());
    one.Step(ours, 1e-2, 0.1);
    parts.Step(theirs, 1e-2);
  }
  EXPECT_LT(Largest(ours.flat(), theirs.flat()), 1e-5);
  EXPECT_EQ(one.steps, 5);
}

// R1 against the same by finite differences: the critic can be differentiated twice, in both types.
TEST(CriticTest, ItsPenaltyIsHalfTheSquaredGradientAndHasAGradient) {
  torch::manual_seed(6);
  Shape shape;
  shape.domains = 3;
  shape.width = 8;
  const Graph graph(torch::kCPU, torch::kFloat32), rough(torch::kCPU, torch::kBFloat16);
  Critic critic(shape, 2, torch::kCPU);
  const Tensor domain = torch::tensor({0, 2}, torch::kInt64), content = torch::tensor({1, 0});
  const Tensor x = torch::randn({2, kWindowFrames, 21, 7}).requires_grad_(true);
  const Tensor logit = critic(graph, x, domain, content);
  const Tensor penalty = GradientPenalty(logit, x);
  critic.parameters.ZeroGradient();
  penalty.backward();
  EXPECT_GT(critic.parameters.gradient().abs().sum().item<double>(), 0);

  const torch::NoGradGuard no_grad;
  // The derivative of the logit along its own gradient is the gradient's squared length.
  const Tensor gradient = [&] {
    const torch::AutoGradMode on(true);
    const Tensor free = x.detach().clone().requires_grad_(true);
    return torch::autograd::grad({critic(graph, free, domain, content).sum()}, {free})[0];
  }();
  const double h = 1e-2;
  const Tensor along = (critic(graph, x + h * gradient, domain, content) -
                        critic(graph, x - h * gradient, domain, content))
                           .sum() /
                       (2 * h);
  EXPECT_NEAR(penalty.item<double>(), 0.5 * along.item<double>() / 2,
              0.03 * penalty.item<double>());
  {
    const torch::AutoGradMode on(true);
    const Tensor again = x.detach().clone().requires_grad_(true);
    const Tensor bf16 = GradientPenalty(critic(rough, again, domain, content), again);
    EXPECT_NEAR(bf16.item<double>(), penalty.item<double>(), 0.05 * penalty.item<double>());
  }
}

TEST(MaskedMeanTest, LeavesOutWhatTheMaskHides) {
  const Tensor value = torch::tensor({1.0F, 5.0F, 3.0F});
  EXPECT_FLOAT_EQ(MaskedMean(value, torch::tensor({1.0F, 0.0F, 1.0F})).item<float>(), 2);
  EXPECT_FLOAT_EQ(MaskedMean(value, torch::zeros({3})).item<float>(), 0);
}

}  // namespace
}  // namespace styled::train::st_gcn
