// One iteration of Style-ERD against its equations (Tao et al. 2022, section 3.2) as plain loops:
// what is logged, and what the optimizers' gradients are.

#include <gtest/gtest.h>
#include <torch/torch.h>

#include <cmath>
#include <map>

#include "model/train/erd/learner.h"
#include "tests/unit/train/walker.h"

namespace styled::train::style_erd {
namespace {

using torch::Tensor;

double MeanOf(const Tensor& x) { return x.to(torch::kFloat64).mean().item<double>(); }

// A learner of three styles, the last of which was not recorded in the second content.
class ErdIteration : public testing::Test {
 protected:
  ErdIteration() {
    for (const char* name : {"neutral", "odd", "rare"}) manifest_.styles.emplace_back().name = name;
    manifest_.contents = {"walk", "wave"};
    for (int style = 0; style < 3; ++style) {
      for (int content = 0; content < (style == 2 ? 1 : 2); ++content) {
        clips_.push_back(Walker(60, static_cast<float>(2 * style + content)));
        clips_.back().style = style;
        clips_.back().content = content;
      }
    }
    statistics_ = ComputeStatistics(clips_, parameters_);
    SetHemisphere(statistics_.mean, parameters_);
    config_.window = 6;
    config_.per_style = 2;
    config_.unpaired = 0.7;
    config_.w_velocity = 0.07;
    config_.w_height = 0.04;
  }

  std::unique_ptr<Learner> Make() {
    torch::manual_seed(1);
    return std::make_unique<Learner>(
        config_, 3, LearnerData{manifest_, clips_, statistics_, parameters_, shape_}, torch::kCPU);
  }
  static Checkpoint StateOf(const Learner& learner) {
    Checkpoint state;
    learner.Save(state);
    for (auto& [name, tensor] : state.tensors) tensor = tensor.clone();
    return state;
  }

  void ExpectTheEquations(double progress, double smooth_share, bool of_critic = true,
                          double tolerance = 0.03);

  clip::Manifest manifest_;
  std::vector<TrainingClip> clips_;
  FeatureStatistics statistics_;
  erd::FeatureParameters parameters_;
  GeneratorShape shape_;
  Config config_;
};

// The windows and slots of an iteration, remade from the state before it.
struct Seen {
  Batch batch;
  Slots slots;
  Tensor mean, deviation;
  const Checkpoint& before;
};

Seen SeenBy(const Checkpoint& before, const Config& config, const std::vector<TrainingClip>& clips,
            const erd::FeatureParameters& parameters) {
  Sampler sampler(clips, {.styles = 3,
                          .contents = 2,
                          .per_style = config.per_style,
                          .length = config.window + 1,
                          .unpaired = config.unpaired});
  sampler.Restore(before.strings.at("sampler"));
  const Tensor mean = before.tensors.at("mean"), deviation = before.tensors.at("deviation");
  const BatchMaker maker(clips, 2, config.window + 1, parameters, mean, deviation);
  Seen seen{maker.Make(sampler.Next()), {}, mean, deviation, before};
  const int64_t n = sampler.slots();
  seen.slots.input = torch::empty({n}, torch::kInt64);
  seen.slots.target = torch::empty({n}, torch::kInt64);
  for (int slot = 0; slot < sampler.slots(); ++slot) {
    seen.slots.input[slot] = sampler.InputStyle(slot);
    seen.slots.target[slot] = sampler.TargetStyle(slot);
  }
  seen.slots.input_one_hot = torch::one_hot(seen.slots.input, 3).to(torch::kFloat32);
  seen.slots.target_one_hot = torch::one_hot(seen.slots.target, 3).to(torch::kFloat32);
  seen.slots.styled = (seen.slots.input > 0).to(torch::kFloat32).view({1, n, 1});
  return seen;
}

body::Quat QuatOf(const Tensor& q) {
  const Tensor d = q.contiguous();
  const float* at = d.data_ptr<float>();
  return body::Quat(at[3], at[0], at[1], at[2]);
}

body::WorldPose WorldOf(const std::array<body::Quat, body::kJointCount>& rotations) {
  body::Pose pose;
  pose.rotations = rotations;
  pose.hips_position_m.setZero();
  body::WorldPose world;
  body::ForwardKinematics(pose, world);
  return world;
}

// The generator's output for the windows, by the runtime's rotations and kinematics.
struct Transferred {
  Tensor rec, rec_velocities, rec_height;  // decoded in the input style
  Tensor rec_positions;                    // [T, B, 21, 3]
  Tensor log_change;                       // of rec⁻¹ ∘ sty, [T, B, 21, 3]
  Tensor seen;  // standardized r (on the mean's hemisphere), p, v of the judged frames
};

Transferred TransferByLoops(const Seen& at, const Tensor& parameters, const Config& config,
                            GeneratorShape shape) {
  const torch::NoGradGuard no_grad;
  shape.styles = 3;
  Generator generator(shape, at.mean, at.deviation);
  generator.parameters.flat().copy_(parameters);
  Carried carried = generator.Start(at.slots);
  RestoreCarried(at.before, "", carried);
  const int64_t frames = at.batch.u.size(0), n = at.slots.count();
  const Decoded decoded = generator.Transfer(at.batch.u, at.slots, {}, at.batch.carried, carried);
  Transferred out{.rec = decoded.rotations.narrow(1, 0, n),
                  .rec_velocities = decoded.velocities.narrow(1, 0, n),
                  .rec_height = decoded.height.narrow(1, 0, n),
                  .rec_positions = torch::empty({frames, n, body::kJointCount, 3}),
                  .log_change = torch::empty({frames, n, body::kJointCount, 3}),
                  .seen = torch::empty({frames - 1, n, kContentFeatures})};
  const Tensor sty = decoded.rotations.narrow(1, n, n);
  const auto put = [](const Tensor& place, const body::Vec3& v) {
    for (int i = 0; i < 3; ++i) place[i] = v[i];
  };
  for (int64_t b = 0; b < n; ++b) {
    body::WorldPose last;
    float last_lift_m = 0;
    for (int64_t t = 0; t < frames; ++t) {
      std::array<body::Quat, body::kJointCount> rec, made;
      for (int j = 0; j < body::kJointCount; ++j) {
        rec[j] = QuatOf(out.rec[t][b][j]);
        const body::Quat change = rec[j].conjugate() * QuatOf(sty[t][b][j]);
        put(out.log_change[t][b][j], body::Log(change));
        made[j] = config.judge_published ? QuatOf(at.batch.rotations()[t][b][j]) * change
                                         : QuatOf(sty[t][b][j]);
      }
      const body::WorldPose rec_world = WorldOf(rec), world = WorldOf(made);
      float lowest_in_m = 1e9F, lowest_out_m = 1e9F;
      for (const int j : {body::kLeftFoot, body::kLeftToes, body::kRightFoot, body::kRightToes}) {
        lowest_in_m = std::min(lowest_in_m, at.batch.positions()[t][b][j][1].item<float>());
        lowest_out_m = std::min(lowest_out_m, world.positions_m[j].y());
      }
      const float lift_m = lowest_in_m - lowest_out_m;
      const body::Quat back = body::Yaw(-at.batch.yaw_change_rad[t][b].item<float>());
      body::Vec3 step_m;
      for (int i = 0; i < 3; ++i) step_m[i] = at.batch.hips_step_m[t][b][i].item<float>();
      step_m.y() += lift_m - last_lift_m;
      for (int j = 0; j < body::kJointCount; ++j) {
        put(out.rec_positions[t][b][j], rec_world.positions_m[j]);
        if (t == 0) continue;
        const Tensor row = out.seen[t - 1][b];
        body::Quat q = made[j];
        double dot = 0;
        for (int i = 0; i < 4; ++i) dot += q.coeffs()[i] * at.mean[4 * j + i].item<double>();
        for (int i = 0; i < 4; ++i) row[4 * j + i] = dot < 0 ? -q.coeffs()[i] : q.coeffs()[i];
        put(row.narrow(0, erd::kPositionBegin + 3 * j, 3), world.positions_m[j]);
        put(row.narrow(0, erd::kVelocityBegin + 3 * j, 3),
            (world.positions_m[j] - back * last.positions_m[j] + step_m) *
                static_cast<float>(config.rate_hz));
      }
      last = world;
      last_lift_m = lift_m;
    }
  }
  out.seen = (out.seen - at.mean.narrow(0, 0, kContentFeatures)) /
             at.deviation.narrow(0, 0, kContentFeatures);
  return out;
}

Tensor ScoresOf(const Critic& critic, const Tensor& x, const Tensor& styles,
                const Tensor& content) {
  const torch::NoGradGuard no_grad;
  return critic(x, torch::cat({styles, content}, 1).to(x.dtype())).to(torch::kFloat64);
}

// The mean over the windows whose pair of target and content was recorded.
double PairedMeanOf(const Tensor& squares, const Tensor& paired) {
  double sum = 0, count = 0;
  for (int64_t b = 0; b < squares.size(0); ++b) {
    if (paired[b].item<float>() == 0) continue;
    sum += squares[b].item<double>();
    count += 1;
  }
  return sum / std::max(1.0, count);
}

// Eq. 6 by central differences of the score by each number of each window.
double PenaltyByDifferences(const Critic& critic, const Tensor& real, const Tensor& styles,
                            const Tensor& content) {
  const double h = 1e-6;
  const int64_t frames = real.size(0), size = frames * real.size(2);
  double sum = 0;
  for (int64_t b = 0; b < real.size(1); ++b) {
    const Tensor steps = (h * torch::eye(size, torch::kFloat64)).view({size, frames, -1});
    const Tensor x = real.narrow(1, b, 1), along = steps.transpose(0, 1);
    const auto scores = [&](const Tensor& all) {
      return ScoresOf(critic, all, styles.narrow(0, b, 1).expand({size, -1}),
                      content.narrow(0, b, 1).expand({size, -1}));
    };
    sum += ((scores(x + along) - scores(x - along)) / (2 * h)).square().sum().item<double>();
  }
  return sum / static_cast<double>(real.size(1));
}

// The networks of the test are in double precision while this lives.
struct InDoubles {
  InDoubles() { torch::set_default_dtype(caffe2::TypeMeta::Make<double>()); }
  ~InDoubles() { torch::set_default_dtype(caffe2::TypeMeta::Make<float>()); }
};

// Eq. 5, 6 and 9 for a critic with these parameters.
std::map<std::string, double> CriticsLoss(const Seen& at, const Tensor& parameters,
                                          const Tensor& fake, const Config& config) {
  const InDoubles in_doubles;
  const torch::NoGradGuard no_grad;
  Critic critic(kJudgedFeatures, 3, 2, config.window, config.attention);
  critic.parameters.Flatten(torch::kCPU);
  critic.parameters.flat().copy_(parameters);
  const Tensor real = at.batch.u.narrow(0, 1, config.window)
                          .narrow(2, erd::kPositionBegin, kJudgedFeatures)
                          .to(torch::kFloat64);
  const Tensor of_real = ScoresOf(critic, real, at.slots.input_one_hot, at.batch.content);
  const Tensor of_fake =
      ScoresOf(critic, fake.to(torch::kFloat64), at.slots.target_one_hot, at.batch.content);
  std::map<std::string, double> loss;
  loss["real"] = MeanOf(of_real);
  loss["fake"] = MeanOf(of_fake);
  loss["critic"] =
      MeanOf((of_real - 1).square()) + PairedMeanOf((of_fake + 1).square(), at.batch.paired);
  loss["penalty"] = config.w_penalty * config.penalty_every *
                    PenaltyByDifferences(critic, real, at.slots.input_one_hot, at.batch.content);
  return loss;
}

// Eq. 2 to 4, 7 and 8, and the smoothness, for a generator with these parameters.
std::map<std::string, double> GeneratorsLoss(const Seen& at, const Tensor& parameters,
                                             const Checkpoint& after, const Config& config,
                                             const GeneratorShape& shape, double smooth_share) {
  const torch::NoGradGuard no_grad;
  const Transferred made = TransferByLoops(at, parameters, config, shape);
  const int64_t frames = at.batch.u.size(0), n = at.slots.count();
  double rotation = 0, position = 0, smooth = 0;
  for (int64_t b = 0; b < n; ++b) {
    for (int64_t t = 0; t < frames; ++t) {
      for (int64_t j = 0; j < body::kJointCount; ++j) {
        const double dot = (made.rec[t][b][j] * at.batch.rotations()[t][b][j]).sum().item<double>();
        rotation += std::pow(std::acos(std::min(1.0, std::abs(dot))), 2) / n;
        position += (made.rec_positions[t][b][j] - at.batch.positions()[t][b][j])
                        .square()
                        .sum()
                        .item<double>() /
                    (n * frames * body::kJointCount);
        if (t < 2) continue;
        const auto log = [&](int64_t frame) { return made.log_change[frame][b][j]; };
        smooth += (log(t) - 2 * log(t - 1) + log(t - 2)).square().sum().item<double>() / n;
      }
    }
  }
  std::map<std::string, double> loss;
  loss["rec_rad"] = 2 * std::sqrt(rotation / (frames * body::kJointCount));
  loss["rec_m"] = std::sqrt(position);
  loss["velocity"] = MeanOf(
      (made.rec_velocities - at.batch.u.narrow(2, erd::kVelocityBegin, erd::kVelocityFeatures))
          .square());
  loss["height"] =
      MeanOf((made.rec_height - at.batch.u.narrow(2, erd::kHipsHeightIndex, 1)).square());
  Critic critic(kJudgedFeatures, 3, 2, config.window, config.attention);
  critic.parameters.Flatten(torch::kCPU);
  critic.parameters.flat().copy_(after.tensors.at("critic"));  // the critic learns first
  const Tensor fake = made.seen.narrow(2, erd::kPositionBegin, kJudgedFeatures);
  loss["adversarial"] = PairedMeanOf(
      ScoresOf(critic, fake, at.slots.target_one_hot, at.batch.content).square(), at.batch.paired);
  ContentClassifier classifier(kContentFeatures, 2);
  classifier.parameters.Flatten(torch::kCPU);
  classifier.parameters.flat().copy_(at.before.tensors.at("classifier"));
  const std::vector<Tensor> was =
      classifier.Maps(at.batch.u.narrow(0, 1, frames - 1).narrow(2, 0, kContentFeatures));
  const std::vector<Tensor> is = classifier.Maps(made.seen);
  for (std::size_t i = 0; i < is.size(); ++i) {
    loss["perceptual"] += MeanOf((is[i] - was[i]).square());
  }
  loss["smooth"] = smooth;
  loss["loss"] = config.w_rotation * rotation + config.w_position * position +
                 config.w_velocity * loss["velocity"] + config.w_height * loss["height"] +
                 config.w_adversarial * loss["adversarial"] +
                 config.w_perceptual * loss["perceptual"] + config.w_smooth * smooth_share * smooth;
  return loss;
}

// One iteration from random weights: what is logged are the equations' values, and Adam's first
// moment holds their gradients. The derivative of a sum along its gradient is the gradient's
// squared length; the steps along it are such that the loss changes by `change`.
void ErdIteration::ExpectTheEquations(double progress, double smooth_share, bool of_critic,
                                      double tolerance) {
  const auto learner = Make();
  const Checkpoint before = StateOf(*learner);
  learner->Step(progress);
  const Checkpoint after = StateOf(*learner);
  std::map<std::string, double> logged;
  for (const auto& [name, value] : learner->means().Pop()) logged[name] = value;

  const Seen at = SeenBy(before, config_, clips_, parameters_);
  const double paired = at.batch.paired.sum().item<double>();
  ASSERT_GT(paired, 0);
  ASSERT_LT(paired, static_cast<double>(at.slots.count())) << "no window is unpaired";
  const Tensor critic = before.tensors.at("critic"), generator = before.tensors.at("generator");
  const Tensor fake = TransferByLoops(at, generator, config_, shape_)
                          .seen.narrow(2, erd::kPositionBegin, kJudgedFeatures);
  std::map<std::string, double> expected;
  if (of_critic) expected = CriticsLoss(at, critic, fake, config_);
  expected.merge(GeneratorsLoss(at, generator, after, config_, shape_, smooth_share));
  if (config_.w_perceptual == 0) expected.erase("perceptual");  // not computed, and not logged
  for (const auto& [name, value] : expected) {
    EXPECT_NEAR(logged.at(name), value, 0.003 * std::abs(value)) << name;
  }

  const auto expect_gradient = [&](const std::string& name, double change, const auto& loss) {
    const Tensor gradient = after.tensors.at(name + ".first") / (1 - config_.beta1);
    const double square = gradient.square().sum().item<double>();
    ASSERT_GT(square, 0) << name;
    const double h = change / square;
    const Tensor from = before.tensors.at(name).to(torch::kFloat64);
    const double slope = (loss(from + h * gradient) - loss(from - h * gradient)) / (2 * h);
    EXPECT_NEAR(slope, square, tolerance * square) << name;
  };
  if (of_critic) {
    expect_gradient("critic", 1e-6 * expected["critic"], [&](const Tensor& moved) {
      auto loss = CriticsLoss(at, moved, fake, config_);
      return loss["critic"] + loss["penalty"];
    });
  }
  expect_gradient("generator", 5e-4 * expected["loss"], [&](const Tensor& moved) {
    return GeneratorsLoss(at, moved, after, config_, shape_, smooth_share)["loss"];
  });
}

TEST_F(ErdIteration, LogsAndDescendsOnTheEquations) {
  config_.smooth_from = 0.2;
  config_.smooth_full = 0.4;
  ExpectTheEquations(0.3, 0.5);
}

// A small loss does not show in the gradient of their sum, so each has its turn. Random weights are
// so smooth that differences do not resolve the loss of smoothness by itself.
TEST_F(ErdIteration, EveryLossOfTheGeneratorHasAGradient) {
  double Config::*const weights[] = {&Config::w_rotation, &Config::w_position, &Config::w_velocity,
                                     &Config::w_height, &Config::w_perceptual};
  for (double Config::*weight : weights) config_.*weight = 0;
  config_.w_smooth = 0;
  for (double Config::*weight : weights) {
    config_.w_adversarial = 1e-12;  // 0 would leave out the critic
    config_.*weight = 1;
    ExpectTheEquations(1, 1, false, 0.06);
    config_.*weight = 0;
  }
  // The score of a random critic is so near 0 that its square is not straight over any step that
  // differences resolve: that there is a gradient must do.
  config_.w_adversarial = 1;
  const auto learner = Make();
  learner->Step(1);
  EXPECT_GT(StateOf(*learner).tensors.at("generator.first").abs().sum().item<double>(), 0);
}

TEST_F(ErdIteration, SmoothnessIsRampedIn) {
  for (double Config::*weight :
       {&Config::w_rotation, &Config::w_position, &Config::w_velocity, &Config::w_height,
        &Config::w_perceptual, &Config::w_adversarial}) {
    config_.*weight = 0;
  }
  config_.w_smooth = 4;
  config_.smooth_from = 0.2;
  config_.smooth_full = 0.6;
  for (const auto& [progress, share] :
       {std::pair{0.1, 0.0}, {0.2, 0.0}, {0.3, 0.25}, {0.4, 0.5}, {0.6, 1.0}, {0.9, 1.0}}) {
    const auto learner = Make();
    learner->Step(progress);
    std::map<std::string, double> logged;
    for (const auto& [name, value] : learner->means().Pop()) logged[name] = value;
    ASSERT_GT(logged.at("smooth"), 0);
    EXPECT_NEAR(logged.at("loss"), 4 * share * logged.at("smooth"), 1e-4 * logged.at("smooth"))
        << progress;
  }
}

TEST_F(ErdIteration, APenaltyThatOutweighsAllElseHasAGradient) {
  config_.w_penalty = 1e6;
  ExpectTheEquations(1, 1);
}

TEST_F(ErdIteration, WithoutAttentionAndOnTheRawOutputTheyHoldToo) {
  config_.attention = false;
  config_.judge_published = false;
  config_.penalty_every = 4;
  ExpectTheEquations(0, 0);
}

TEST_F(ErdIteration, ThePenaltyHasItsInterval) {
  config_.penalty_every = 3;
  const auto learner = Make();
  for (int i = 0; i < 7; ++i) {
    learner->Step(0);
    const Figures figures = learner->means().Pop();
    const bool penalized = std::any_of(figures.begin(), figures.end(),
                                       [](const auto& row) { return row.first == "penalty"; });
    EXPECT_EQ(penalized, i % 3 == 0) << i;
  }
}

// Adam's first step is as long as its rate; the exported mean is over few iterations at first.
TEST_F(ErdIteration, RatesFallLinearlyAndTheMeanFollowsTheWeights) {
  config_.decay_from = 0.5;
  config_.decay_to = 0.2;
  for (const auto& [progress, share] : {std::pair{0.4, 1.0}, {0.75, 0.6}, {1.0, 0.2}}) {
    const auto learner = Make();
    const Checkpoint before = StateOf(*learner);
    learner->Step(progress);
    const Checkpoint after = StateOf(*learner);
    const auto moved = [&](const std::string& name) {
      return (after.tensors.at(name) - before.tensors.at(name)).abs().max().item<double>();
    };
    EXPECT_NEAR(moved("generator"), config_.generator_rate * share, 1e-6) << progress;
    EXPECT_NEAR(moved("critic"), config_.critic_rate * share, 1e-6) << progress;
    const Tensor mean =
        before.tensors.at("generator") * (2.0 / 11) + after.tensors.at("generator") * (9.0 / 11);
    EXPECT_LT((after.tensors.at("average") - mean).abs().max().item<double>(), 1e-6);
  }
}

// Neutral windows are reconstructed by r_0 alone and transferred by the branch of their target,
// styled ones are reconstructed by the branch of their style and transferred by r_0.
TEST_F(ErdIteration, ABranchServesItsOwnStyle) {
  const torch::NoGradGuard no_grad;
  const auto learner = Make();
  const Checkpoint before = StateOf(*learner);
  const Seen at = SeenBy(before, config_, clips_, parameters_);
  const Generator& generator = learner->average();
  Carried carried = generator.Start(at.slots);
  const int64_t n = at.slots.count(), per_branch = n / 2;
  const Decoded all =
      generator.Transfer(at.batch.u, at.slots, {}, torch::zeros({n}, torch::kBool), carried);
  for (int64_t b = 0; b < n; ++b) {
    const int64_t style = (at.slots.input[b] + at.slots.target[b]).item<int64_t>();
    const Tensor z =
        generator.Encode(at.batch.u.narrow(1, b, 1), at.slots.input_one_hot.narrow(0, b, 1), {});
    StackState r0 = generator.neutral.Initial(1), branch = generator.branches.Initial(per_branch);
    const Tensor neutral = generator.Neutral(z, r0);
    const Tensor with = neutral + generator.Branches(z.expand({-1, n, -1}).contiguous(), branch)
                                      .narrow(1, (style - 1) * per_branch, 1);
    const auto one_hot = [](int64_t of) {
      return torch::one_hot(torch::tensor({of}), 3).to(torch::kFloat32);
    };
    const Tensor as_neutral = generator.Decode(neutral, one_hot(0)).rotations.select(1, 0);
    const Tensor as_style = generator.Decode(with, one_hot(style)).rotations.select(1, 0);
    const bool styled = at.slots.input[b].item<int64_t>() > 0;
    EXPECT_LT(
        (all.rotations.select(1, b) - (styled ? as_style : as_neutral)).abs().max().item<float>(),
        1e-5);
    EXPECT_LT((all.rotations.select(1, n + b) - (styled ? as_neutral : as_style))
                  .abs()
                  .max()
                  .item<float>(),
              1e-5);
  }
}

// The recurrent states at the start are parameters; without learned states they are and stay 0.
TEST_F(ErdIteration, InitialStatesAreTrainedOrStayZero) {
  for (const bool learned : {true, false}) {
    config_.learned_states = learned;
    const auto learner = Make();
    const Tensor flat = StateOf(*learner).tensors.at("generator");
    const Generator& generator = learner->average();
    for (int i = 0; i < 4; ++i) learner->Step(0);
    const Tensor now = StateOf(*learner).tensors.at("generator");
    for (const auto& [name, tensor] : generator.parameters.named()) {
      const auto part = [&tensor = tensor](const Tensor& of) {
        return of.narrow(0, tensor.storage_offset(), tensor.numel());
      };
      const bool state = name.ends_with(".h0") || name.ends_with(".c0");
      EXPECT_EQ(torch::equal(part(flat), part(now)), state && !learned) << name;
      if (!state) continue;
      EXPECT_EQ(part(now).abs().max().item<float>() == 0, !learned) << name;
      EXPECT_EQ(tensor.abs().max().item<float>() == 0, !learned) << name << " of the mean";
    }
  }
}

}  // namespace
}  // namespace styled::train::style_erd
