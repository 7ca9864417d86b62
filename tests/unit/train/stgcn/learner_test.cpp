// One iteration: which losses reach which networks, and the weight of diversity.

#include "model/train/stgcn/learner.h"

#include <gtest/gtest.h>
#include <torch/torch.h>

#include <map>

#include "tests/unit/train/walker.h"

namespace styled::train::st_gcn {
namespace {

using torch::Tensor;

class LearnerTest : public testing::Test {
 protected:
  LearnerTest() {
    for (int i = 0; i < 4; ++i) {
      clips_.push_back(Walker(120, static_cast<float>(i)));
      clips_.back().style = i % 2;
    }
    statistics_ = ComputeStatistics(clips_, stgcn::FeatureParameters());
    stgcn::SetHemisphere(statistics_.mean, parameters_);
    store_.emplace(clips_, statistics_, parameters_, 8);
    config_.width = 8;
    config_.batch = 3;
    config_.warm_up = 0;
  }
  std::unique_ptr<Learner> Make() {
    torch::manual_seed(1);
    return std::make_unique<Learner>(config_, 1, *store_, statistics_, 2, std::vector<bool>{true},
                                     torch::kCPU);
  }

  std::vector<TrainingClip> clips_;
  Statistics statistics_;
  stgcn::FeatureParameters parameters_;
  std::optional<WindowStore> store_;
  Config config_;
};

double Gradient(const Parameters& parameters) {
  return parameters.gradient().abs().sum().item<double>();
}

// Sums of the gradients' sizes, by the beginning of the parameters' names.
double Gradient(const Parameters& parameters, const std::string& begin) {
  double sum = 0;
  for (const auto& [name, tensor] : parameters.named()) {
    if (name.starts_with(begin)) sum += tensor.grad().abs().sum().item<double>();
  }
  return sum;
}

TEST_F(LearnerTest, EveryParameterOfEveryNetworkGetsAGradient) {
  const auto learner = Make();
  std::map<std::string, double> largest;
  const auto observe = [&largest](const Parameters& parameters) {
    for (const auto& [name, tensor] : parameters.named()) {
      largest[name] = std::max(largest[name], tensor.grad().abs().max().item<double>());
    }
  };
  for (int i = 0; i < 8; ++i) {
    learner->Step(0);
    for (const auto& [name, parameters] : learner->networks().parts()) observe(*parameters);
    observe(learner->critic().parameters);
  }
  EXPECT_GT(largest.size(), 120U);
  for (const auto& [name, gradient] : largest) EXPECT_GT(gradient, 0) << name;
  EXPECT_TRUE(learner->Finite());
}

TEST_F(LearnerTest, ReferencesTeachTheEncoderOnlyIfAsked) {
  for (const bool learns : {true, false}) {
    config_.encoder_learns_from_references = learns;
    const auto learner = Make();
    learner->Step(0);  // by noise
    const Tensor before = learner->networks().encoder.parameters.flat().clone();
    const Tensor mapping = learner->networks().mapping.parameters.flat().clone();
    learner->Step(0);  // by references
    EXPECT_EQ(torch::equal(before, learner->networks().encoder.parameters.flat()), !learns);
    EXPECT_TRUE(torch::equal(mapping, learner->networks().mapping.parameters.flat()));
  }
}

TEST_F(LearnerTest, TheFreeHeadReachesTheTrunkOnlyIfAsked) {
  config_.w_adversarial = config_.w_cycle = config_.w_identity = config_.w_style = 0;
  config_.w_diversity = config_.diversity_target_cm = config_.w_fk = 0;
  for (const bool teaches : {true, false}) {
    config_.free_head_teaches = teaches;
    const auto learner = Make();
    learner->Step(0);
    const Parameters& encoder = learner->networks().encoder.parameters;
    EXPECT_GT(Gradient(encoder, "e.free."), 0);
    EXPECT_EQ(Gradient(encoder, "e.heads."), 0) << "its target does not follow it";
    EXPECT_EQ(Gradient(encoder, "e.res1.") > 0, teaches);
    EXPECT_EQ(Gradient(learner->networks().generator.parameters), 0);
  }
}

// The paper has no such head: with its settings nothing else may depend on it.
TEST_F(LearnerTest, WithThePapersSettingsTheFreeHeadChangesNoOtherBit) {
  AsInThePaper(config_);
  config_.width = 16;
  config_.critic_rate = config_.encoder_rate = config_.mapping_rate = 1e-3;  // visible in 3 steps
  std::vector<std::map<std::string, Tensor>> ends;
  for (const double weight : {0.0, 1.0}) {
    config_.w_free = weight;
    const auto learner = Make();
    for (int i = 0; i < 3; ++i) learner->Step(0);
    auto& end = ends.emplace_back();
    for (const auto& [name, parameters] : learner->networks().parts()) {
      for (const auto& [tensor_name, tensor] : parameters->named()) {
        end[tensor_name] = tensor.detach().clone();
      }
    }
    for (const auto& [name, tensor] : learner->critic().parameters.named()) {
      end[name] = tensor.detach().clone();
    }
  }
  for (const auto& [name, tensor] : ends[0]) {
    EXPECT_EQ(torch::equal(tensor, ends[1].at(name)), !name.starts_with("e.free.")) << name;
  }
}

// A published position follows from the rotations, so that only decoded ones teach the output layer
// to predict it.
TEST_F(LearnerTest, TheLossesSeeDecodedWindowsIfAsked) {
  config_.w_cycle = config_.w_identity = config_.w_free = config_.w_fk = 0;
  for (const bool published : {true, false}) {
    config_.judge_published = published;
    const auto learner = Make();
    learner->Step(0);
    const Parameters& generator = learner->networks().generator.parameters;
    const Tensor rows = generator.Find("g.out.weight").grad().abs().sum(1);
    EXPECT_EQ(rows[0].item<float>() > 0, !published) << "x";
    EXPECT_GT(rows[1].item<float>(), 0) << "y: the hips' height is published";
    EXPECT_EQ(rows[2].item<float>() > 0, !published) << "z";
    EXPECT_GT(rows[3].item<float>(), 0) << "rotations";
  }
}

TEST_F(LearnerTest, TheCriticsLastLayerMixesTheDomains) {
  const torch::NoGradGuard no_grad;
  const Shape shape{.domains = 3, .width = 8};
  torch::manual_seed(1);
  const Critic without(shape, 0, torch::kCPU);
  torch::manual_seed(1);
  const Critic with(shape, 0, torch::kCPU, 1.0, true);
  const Graph graph(torch::kCPU, torch::kFloat32);
  const Tensor x = torch::randn({1, kWindowFrames, body::kJointCount, stgcn::kChannels});
  const Tensor content = torch::zeros({1}, torch::kInt64);
  const auto logits = [&](const Critic& critic) {
    std::vector<Tensor> all;
    for (int64_t domain = 0; domain < shape.domains; ++domain) {
      all.push_back(critic(graph, x, torch::tensor({domain}), content));
    }
    return torch::cat(all);
  };
  const Tensor expected = torch::matmul(with.parameters.Find("d.last.weight"), logits(without)) +
                          with.parameters.Find("d.last.bias");
  EXPECT_LT((logits(with) - expected).abs().max().item<float>(), 1e-4F);
  EXPECT_GT((logits(with) - logits(without)).abs().max().item<float>(), 1e-2F);
}

TEST_F(LearnerTest, PosturesOfExamplesTeachHeadsAndGenerator) {
  config_.w_adversarial = config_.w_cycle = config_.w_identity = config_.w_style = 0;
  config_.w_diversity = config_.diversity_target_cm = config_.w_fk = config_.w_free = 0;
  for (const bool labelled : {true, false}) {
    config_.w_posture = labelled ? 1 : 0;
    config_.w_read = labelled ? 0 : 1;
    const auto learner = Make();
    const Parameters& encoder = learner->networks().encoder.parameters;
    const Parameters& generator = learner->networks().generator.parameters;
    learner->Step(0);  // by noise
    EXPECT_EQ(Gradient(generator), 0);
    learner->Step(0);  // by references
    EXPECT_EQ(Gradient(encoder, "e.heads.") > 0, labelled);
    EXPECT_EQ(Gradient(encoder, "e.free.") > 0, !labelled);
    EXPECT_GT(Gradient(encoder, "e.res1."), 0);
    EXPECT_GT(Gradient(generator), 0);
  }
}

TEST_F(LearnerTest, WarmUpIsIdentityAlone) {
  config_.warm_up = 1;
  const auto learner = Make();
  const Tensor critic = learner->critic().parameters.flat().clone();
  learner->Step(0);
  EXPECT_TRUE(torch::equal(critic, learner->critic().parameters.flat()));
  EXPECT_GT(Gradient(learner->networks().generator.parameters), 0);
  EXPECT_GT(Gradient(learner->networks().encoder.parameters, "e.heads."), 0);
  EXPECT_EQ(Gradient(learner->networks().mapping.parameters), 0);
  learner->Step(0);
  EXPECT_FALSE(torch::equal(critic, learner->critic().parameters.flat()));
}

TEST_F(LearnerTest, TheAverageFollowsTheWeights) {
  config_.ema = 0;
  auto learner = Make();
  learner->Step(0);
  EXPECT_TRUE(torch::equal(learner->average().generator.parameters.flat(),
                           learner->networks().generator.parameters.flat()));
  config_.ema = 0.999;
  learner = Make();
  const Tensor start = learner->average().generator.parameters.flat().clone();
  learner->Step(0);
  const Tensor now = learner->networks().generator.parameters.flat();
  const Tensor expected = start + (1.0 - 2.0 / 51.0) * (now - start);
  EXPECT_LT((learner->average().generator.parameters.flat() - expected).abs().max().item<double>(),
            1e-6);
}

TEST_F(LearnerTest, TheHipsOfEveryOutputStandStill) {
  const auto learner = Make();
  learner->Step(0);
  const torch::NoGradGuard no_grad;
  const Networks& networks = learner->networks();
  const Tensor x = store_->Read({{0, 0, false}});
  const Tensor out = networks.generator.Decode(
      learner->graph(), networks.generator.Encode(learner->graph(), x), torch::randn({1, 64}));
  EXPECT_EQ(out.sizes(), x.sizes());
  EXPECT_EQ(out.select(2, 0).select(2, 0).abs().max().item<double>(), 0);
  EXPECT_EQ(out.select(2, 0).select(2, 2).abs().max().item<double>(), 0);
  EXPECT_GT(out.select(2, 0).select(2, 1).abs().max().item<double>(), 0);
}

// A steered weight on the CPU, of distances in cm.
struct Steered {
  DiversityWeight weight;
  Steered(double start, double target_cm) : weight(start, target_cm, torch::kCPU) {}
  double Observe(double distance_cm) {
    return weight.Observe(torch::tensor(distance_cm, torch::kFloat32)).item<double>();
  }
  double Now() const { return weight.weight().item<double>(); }
};

TEST(DiversityWeightTest, RisesWhereVarietyLacksAndFallsWhereItAbounds) {
  Steered low(1, 3), high(1, 3), right(1, 3), constant(1, 0);
  EXPECT_EQ(low.Observe(0), 1) << "the weight before";
  for (int i = 0; i < 299; ++i) low.Observe(0);
  for (int i = 0; i < 300; ++i) {
    high.Observe(6);
    right.Observe(3);
    constant.Observe(0);
  }
  EXPECT_NEAR(low.Now(), 3.32, 0.01) << "exp(300 * 0.004)";
  EXPECT_NEAR(high.Now(), 0.301, 0.001);
  EXPECT_EQ(right.Now(), 1);
  EXPECT_EQ(constant.Now(), 1);
  for (int i = 0; i < 3000; ++i) {
    low.Observe(0);
    high.Observe(1e9);
  }
  EXPECT_EQ(low.Now(), 5);
  EXPECT_FLOAT_EQ(static_cast<float>(high.Now()), 0.1F);
}

// A plant whose variety is a multiple of the weight comes to rest at the target.
TEST(DiversityWeightTest, SteersToItsTarget) {
  Steered steered(1, 3);
  for (int i = 0; i < 5000; ++i) steered.Observe(1.4 * steered.Now());
  EXPECT_NEAR(1.4 * steered.Now(), 3, 0.01);
}

}  // namespace
}  // namespace styled::train::st_gcn
