// One iteration of st-gcn against its losses (Park et al. 2021, eq. 7 to 12) as plain loops: what
// is logged, and the gradients of all four networks.

#include <ATen/CPUGeneratorImpl.h>
#include <gtest/gtest.h>
#include <torch/torch.h>

#include <map>

#include "model/train/stgcn/learner.h"
#include "tests/unit/train/walker.h"

namespace styled::train::st_gcn {
namespace {

using torch::Tensor;

constexpr uint64_t kSeedOfRun = 5;
constexpr int kWindowsOfBatch = 4;

class StGcnEquations : public testing::Test {
 protected:
  // Three domains; the last has no clip of the second content.
  StGcnEquations() {
    for (int domain = 0; domain < 3; ++domain) {
      for (int content = 0; content < (domain == 2 ? 1 : 2); ++content) {
        clips_.push_back(Walker(120, static_cast<float>(2 * domain + content)));
        clips_.back().style = domain;
        clips_.back().content = content;
      }
    }
    statistics_ = ComputeStatistics(clips_, stgcn::FeatureParameters());
    stgcn::SetHemisphere(statistics_.mean, parameters_);
    store_.emplace(clips_, statistics_, parameters_, 8);
    config_.width = 8;
    config_.batch = kWindowsOfBatch;
    config_.warm_up = 0;
    config_.unpaired = 0.5;
    config_.precision = "fp32";
    config_.w_adversarial = 1.5;
    config_.w_cycle = 0.7;
    config_.w_identity = 0.9;
    config_.w_style = 1.2;
    config_.w_diversity = 0.8;
    config_.w_fk = 0.5;
    config_.w_free = 0.6;
    config_.w_penalty = 2;
  }

  // A learner at that iteration: even ones take codes from noise, odd ones from references.
  std::unique_ptr<Learner> At(int64_t iteration) {
    torch::manual_seed(1);
    auto learner = std::make_unique<Learner>(config_, kSeedOfRun, *store_, statistics_, 3,
                                             std::vector<bool>{true, true}, torch::kCPU);
    Checkpoint state = StateOf(*learner);
    state.tensors["iteration"] = torch::tensor({iteration}, torch::kInt64);
    EXPECT_TRUE(learner->Restore(state).ok());
    return learner;
  }
  static Checkpoint StateOf(const Learner& learner) {
    Checkpoint state;
    learner.Save(state);
    for (auto& [name, tensor] : state.tensors) tensor = tensor.clone();
    return state;
  }
  std::map<std::string, double> Logged(Learner& learner) {
    std::map<std::string, double> figures;
    for (const auto& [name, value] : learner.means().Pop()) figures[name] = value;
    return figures;
  }

  void ExpectTheEquations(int64_t iteration);

  std::vector<TrainingClip> clips_;
  Statistics statistics_;
  stgcn::FeatureParameters parameters_;
  std::optional<WindowStore> store_;
  Config config_;
};

// The windows and labels of an iteration.
struct Drawn {
  Tensor source, same_clip, reference1, reference2;
  Tensor domain, target, content, paired;
};

// ‖difference‖₂ over the joints, as the authors' code has eq. 8 and 9: a mean over the rest.
double JointNormByLoops(const Tensor& a, const Tensor& b) {
  const auto x = a.accessor<float, 4>(), y = b.accessor<float, 4>();
  double sum = 0;
  for (int64_t n = 0; n < a.size(0); ++n) {
    for (int64_t t = 0; t < a.size(1); ++t) {
      for (int64_t c = 0; c < a.size(3); ++c) {
        double square = 0;
        for (int64_t j = 0; j < a.size(2); ++j) {
          square += std::pow(double{x[n][t][j][c]} - y[n][t][j][c], 2);
        }
        sum += std::sqrt(square);
      }
    }
  }
  return sum / static_cast<double>(a.size(0) * a.size(1) * a.size(3));
}

double MeanAbsolute(const Tensor& a, const Tensor& b) {
  return (a - b).to(torch::kFloat64).abs().mean().item<double>();
}

// The mean over pairs that were recorded of -log(σ(sign · logit)).
double CrossEntropy(const Tensor& logit, double sign, const Tensor& paired) {
  double sum = 0, count = 0;
  for (int64_t b = 0; b < logit.size(0); ++b) {
    if (paired[b].item<float>() == 0) continue;
    sum += std::log1p(std::exp(-sign * logit[b].item<double>()));
    count += 1;
  }
  return sum / std::max(1.0, count);
}

// The networks with parameters of their own, and their losses for a batch.
struct World {
  const Config& config;
  const Drawn& drawn;
  const Kinematics kinematics;
  const Graph graph{torch::kCPU, torch::kFloat32};
  int64_t iteration;
  Networks networks;
  Critic critic;

  World(const Config& of, const Drawn& batch, const Statistics& statistics, int64_t at,
        const Checkpoint& state)
      : config(of),
        drawn(batch),
        kinematics(statistics, torch::kCPU),
        iteration(at),
        networks(ShapeOfTest(of), torch::kCPU, true),
        critic(ShapeOfTest(of), 2, torch::kCPU) {
    const torch::NoGradGuard no_grad;
    for (const auto& [name, part] : networks.parts()) part->flat().copy_(state.tensors.at(name));
  }
  static Shape ShapeOfTest(const Config& of) {
    Shape shape;
    shape.domains = 3;
    shape.width = of.width;
    return shape;
  }

  bool by_noise() const { return iteration % 2 == 0; }
  // z ~ N(0, I), seeded by run and iteration so that a resumed run draws the same.
  Tensor Noise(uint64_t which) const {
    const uint64_t at = static_cast<uint64_t>(iteration);
    return torch::randn({kWindowsOfBatch, 16},
                        at::detail::createCPUGenerator((kSeedOfRun * 1000003 + at) * 2 + which));
  }
  Tensor E(const Tensor& window, const Tensor& domain) const {
    return networks.encoder.Code(networks.encoder.Features(graph, window), domain);
  }
  Tensor G(const Tensor& window, const Tensor& code) const {
    return networks.generator.Decode(graph, networks.generator.Encode(graph, window), code);
  }
  Tensor Fake(const Tensor& code) const { return kinematics.Published(G(drawn.source, code)); }
  Tensor TargetCode() const {
    return by_noise() ? networks.mapping(Noise(0), drawn.target)
                      : E(drawn.reference1, drawn.target);
  }
  Tensor OtherCode() const {
    return by_noise() ? networks.mapping(Noise(1), drawn.target)
                      : E(drawn.reference2, drawn.target);
  }
  double D(const Tensor& window, const Tensor& domain, double sign) const {
    return CrossEntropy(critic(graph, window, domain, drawn.content), sign, drawn.paired);
  }

  // No gradient flows through these.
  struct Constants {
    Tensor other_fake;   // eq. 11's second output
    Tensor target_code;  // of a reference, in eq. 10
    std::vector<Tensor> codes;
  };
  Constants Now() const {
    const torch::NoGradGuard no_grad;
    return {Fake(OtherCode()), TargetCode(), OwnAndReferences()};
  }
  std::vector<Tensor> OwnAndReferences() const {
    std::vector<Tensor> codes{E(drawn.same_clip, drawn.domain)};
    if (by_noise()) return codes;
    codes.push_back(E(drawn.reference1, drawn.target));
    codes.push_back(E(drawn.reference2, drawn.target));
    return codes;
  }

  std::map<std::string, double> Losses(const Constants& constant) const {
    const torch::NoGradGuard no_grad;
    // The estimated code of the source's own domain, read from another window of its clip.
    const Tensor own = E(drawn.same_clip, drawn.domain), code = TargetCode();
    const Tensor reconstruction = G(drawn.source, own), raw = G(drawn.source, code);
    const Tensor fake = kinematics.Published(raw);
    std::map<std::string, double> loss;
    loss["adversarial"] = D(fake, drawn.target, 1);
    loss["identity"] = JointNormByLoops(reconstruction, drawn.source);
    loss["cycle"] = JointNormByLoops(G(fake, own), drawn.source);
    loss["style"] = MeanAbsolute(by_noise() ? code : constant.target_code, E(fake, drawn.target));
    const std::vector<Tensor> windows{drawn.same_clip, drawn.reference1, drawn.reference2};
    for (std::size_t i = 0; i < constant.codes.size(); ++i) {
      const Tensor free = networks.encoder.FreeCode(networks.encoder.Features(graph, windows[i]));
      loss["free"] += MeanAbsolute(free, constant.codes[i]) / constant.codes.size();
    }
    loss["fk"] = MeanAbsolute(raw, fake) +
                 MeanAbsolute(reconstruction, kinematics.Published(reconstruction));
    loss["apart_cm"] =
        100 * (kinematics.Positions_m(fake) - kinematics.Positions_m(constant.other_fake))
                  .norm(2, -1)
                  .mean()
                  .item<double>();
    loss["sum"] = config.w_adversarial * loss["adversarial"] +
                  config.w_identity * loss["identity"] + config.w_cycle * loss["cycle"] +
                  config.w_style * loss["style"] + config.w_free * loss["free"] +
                  config.w_fk * loss["fk"] -
                  config.w_diversity * MeanAbsolute(fake, constant.other_fake);
    return loss;
  }

  // Half the squared gradient of the logit of real windows: the derivative along the gradient.
  double Penalty() const {
    const Tensor x = drawn.source.clone().requires_grad_(true);
    const Tensor logit = critic(graph, x, drawn.domain, drawn.content);
    const Tensor g = torch::autograd::grad({logit.sum()}, {x})[0];
    const torch::NoGradGuard no_grad;
    return 0.5 * g.square().sum().item<double>() / kWindowsOfBatch;
  }
  double CriticsLoss(const Tensor& fake) const {
    const torch::NoGradGuard no_grad;
    return D(drawn.source, drawn.domain, 1) + D(fake, drawn.target, -1);
  }
};

Drawn DrawnBy(const Checkpoint& state, const Config& config, const WindowStore& store) {
  Sampler sampler(store, {.domains = 3, .contents = 2, .unpaired = config.unpaired});
  sampler.Restore(state.strings.at("sampler"));
  std::vector<Window> source, same, first, second;
  std::vector<int64_t> domain, target, content;
  std::vector<float> paired;
  for (const Sample& sample : sampler.Next(kWindowsOfBatch)) {
    source.push_back(sample.source);
    same.push_back(sample.same_clip);
    first.push_back(sample.reference1);
    second.push_back(sample.reference2);
    domain.push_back(sample.domain);
    target.push_back(sample.target);
    content.push_back(sample.content);
    paired.push_back(sample.paired ? 1.0F : 0.0F);
  }
  return {store.Read(source),     store.Read(same),      store.Read(first),
          store.Read(second),     torch::tensor(domain), torch::tensor(target),
          torch::tensor(content), torch::tensor(paired)};
}

void StGcnEquations::ExpectTheEquations(int64_t iteration) {
  const auto learner = At(iteration);
  const Checkpoint before = StateOf(*learner);
  learner->Step(0);
  const Checkpoint after = StateOf(*learner);
  const auto logged = Logged(*learner);
  const Drawn drawn = DrawnBy(before, config_, *store_);
  const double paired = drawn.paired.sum().item<double>();
  ASSERT_GT(paired, 0);
  ASSERT_LT(paired, kWindowsOfBatch) << "no window is unpaired";

  World world(config_, drawn, statistics_, iteration, before);
  const World::Constants constant = world.Now();
  const Tensor fake = [&] {
    const torch::NoGradGuard no_grad;
    return world.Fake(world.TargetCode());
  }();
  const auto set = [](Parameters& parameters, const Tensor& to) {
    const torch::NoGradGuard no_grad;
    parameters.flat().copy_(to);
  };
  // The derivative of a loss along its gradient is the gradient's squared length.
  const auto expect_gradient = [&](const std::string& name, Parameters& moved,
                                   const Tensor& gradient, const auto& loss) {
    const double square = gradient.square().sum().item<double>();
    ASSERT_GT(square, 0) << name;
    const Tensor from = before.tensors.at(name);
    const double h = 1e-3 * std::abs(loss()) / square;
    set(moved, from + h * gradient);
    const double above = loss();
    set(moved, from - h * gradient);
    const double below = loss();
    set(moved, from);
    EXPECT_NEAR((above - below) / (2 * h), square, 0.03 * square) << name;
  };

  // 1. The critic, on real windows and on what the networks made before they learned.
  set(world.critic.parameters, before.tensors.at("critic"));
  const bool penalized = iteration % config_.penalty_every == 0;
  EXPECT_NEAR(logged.at("critic"), world.CriticsLoss(fake), 1e-4);
  ASSERT_EQ(logged.count("penalty"), penalized ? 1U : 0U);
  if (penalized) {
    EXPECT_NEAR(logged.at("penalty"), world.Penalty(), 1e-3 * world.Penalty());
  }
  expect_gradient("critic", world.critic.parameters, learner->critic().parameters.gradient(), [&] {
    const double penalty = penalized ? world.Penalty() : 0;
    return world.CriticsLoss(fake) + config_.w_penalty * config_.penalty_every * penalty;
  });

  // 2. The others, against the critic that has learned.
  set(world.critic.parameters, after.tensors.at("critic"));
  auto expected = world.Losses(constant);
  const std::string turn = iteration % 2 == 0 ? "_noise" : "_reference";
  for (const std::string name : {"identity", "cycle", "free", "fk"}) {
    EXPECT_NEAR(logged.at(name), expected[name], 1e-3 * expected[name]) << name;
  }
  for (const std::string name : {"adversarial", "style", "apart_cm"}) {
    EXPECT_NEAR(logged.at(name + turn), expected[name], 1e-3 * expected[name]) << name;
  }
  for (const auto& [name, part] : world.networks.parts()) {
    if (std::string(name) == "mapping" && iteration % 2 == 1) continue;
    const Parameters* learned = nullptr;
    for (const auto& [of, parameters] : learner->networks().parts()) {
      if (std::string(of) == name) learned = parameters;
    }
    expect_gradient(name, *part, learned->gradient(),
                    [&] { return world.Losses(constant)["sum"]; });
  }
}

TEST_F(StGcnEquations, HoldWithCodesFromNoiseAndWithAPenalty) { ExpectTheEquations(0); }

TEST_F(StGcnEquations, HoldWithCodesOfReferences) { ExpectTheEquations(1); }

// Among the others its gradient is too small to be seen.
TEST_F(StGcnEquations, DiversityAloneHasAGradient) {
  for (double Config::*weight : {&Config::w_adversarial, &Config::w_identity, &Config::w_cycle,
                                 &Config::w_style, &Config::w_free, &Config::w_fk}) {
    config_.*weight = 1e-9;  // 0 would leave some out
  }
  ExpectTheEquations(1);
}

TEST_F(StGcnEquations, ThePenaltyHasItsInterval) {
  config_.penalty_every = 3;
  const auto learner = At(0);
  for (int i = 0; i < 7; ++i) {
    learner->Step(0);
    EXPECT_EQ(Logged(*learner).count("penalty"), i % 3 == 0 ? 1U : 0U) << i;
  }
}

// Adam's first step is as long as its rate, which falls with the square of what is left.
TEST_F(StGcnEquations, RatesFallQuadratically) {
  config_.decay_to = 0.2;
  config_.weight_decay = 0;
  for (const auto& [progress, share] : {std::pair{0.0, 1.0}, {0.5, 0.4}, {1.0, 0.2}}) {
    const auto learner = At(0);
    const Checkpoint before = StateOf(*learner);
    learner->Step(progress);
    const Checkpoint after = StateOf(*learner);
    const auto moved = [&](const std::string& name) {
      return (after.tensors.at(name) - before.tensors.at(name)).abs().max().item<double>();
    };
    EXPECT_NEAR(moved("generator"), config_.generator_rate * share, 1e-6) << progress;
    EXPECT_NEAR(moved("critic"), config_.critic_rate * share, 1e-6) << progress;
    EXPECT_NEAR(moved("mapping"), config_.mapping_rate * share, 1e-6) << progress;
  }
}

// F: noise and label each through a layer of their own, then three layers; ReLU, at last tanh.
TEST(StGcnMapping, IsItsEquation) {
  torch::manual_seed(7);
  const torch::NoGradGuard no_grad;
  Shape shape;
  shape.domains = 3;
  const Mapping mapping(shape, torch::kCPU);
  mapping.parameters.flat().normal_(0, 0.1);
  const auto layer = [&](const std::string& name, const std::vector<double>& x) {
    const Tensor weight = mapping.parameters.Find(name + ".weight");
    const Tensor bias = mapping.parameters.Find(name + ".bias");
    const auto w = weight.accessor<float, 2>();
    std::vector<double> y;
    for (int64_t o = 0; o < weight.size(0); ++o) {
      double sum = bias[o].item<double>();
      for (std::size_t i = 0; i < x.size(); ++i) sum += w[o][static_cast<int64_t>(i)] * x[i];
      y.push_back(name == "f.out" ? std::tanh(sum) : std::max(0.0, sum));
    }
    return y;
  };
  const Tensor z = torch::randn({1, 16});
  std::vector<double> noise;
  for (int64_t i = 0; i < 16; ++i) noise.push_back(z[0][i].item<double>());
  std::vector<double> both = layer("f.noise", noise);
  for (const double value : layer("f.label", {0, 0, 1})) both.push_back(value);
  const auto code = layer("f.out", layer("f.fc2", layer("f.fc1", both)));
  const Tensor ours = mapping(z, torch::tensor({2}, torch::kInt64));
  ASSERT_EQ(ours.size(1), static_cast<int64_t>(code.size()));
  for (std::size_t i = 0; i < code.size(); ++i) {
    EXPECT_NEAR(ours[0][static_cast<int64_t>(i)].item<double>(), code[i], 1e-5);
  }
}

// The paper's order: the critic on both kinds of codes, then the others on both.
TEST_F(StGcnEquations, BothTurnsAreOneIteration) {
  config_.both_turns = true;
  const auto learner = At(0);
  learner->Step(0);
  const auto logged = Logged(*learner);
  EXPECT_EQ(logged.count("adversarial_noise"), 1U);
  EXPECT_EQ(logged.count("adversarial_reference"), 1U);
  EXPECT_EQ(StateOf(*learner).tensors.at("critic.steps").item<int64_t>(), 2);
  EXPECT_EQ(StateOf(*learner).tensors.at("generator.steps").item<int64_t>(), 2);
  EXPECT_EQ(StateOf(*learner).tensors.at("mapping.steps").item<int64_t>(), 1);
}

}  // namespace
}  // namespace styled::train::st_gcn
