// The losses of the networks.
#include "model/train/stgcn/losses.h"

#include "model/train/stgcn/learner.h"

namespace styled::train::st_gcn {
namespace {

using torch::Tensor;

constexpr double kTiny = 1e-8;  // below a square root, whose gradient is infinite at 0
constexpr double kCmPerM = 100;

}  // namespace

Tensor JointNorm(const Tensor& difference) {
  return (difference.square().sum(2) + kTiny).sqrt().mean();
}

Tensor MaskedMean(const Tensor& value, const Tensor& mask) {
  return (value * mask).sum() / mask.sum().clamp_min(1.0);
}

Tensor GradientPenalty(const Tensor& logit, const Tensor& input) {
  const Tensor gradient = torch::autograd::grad({logit.sum()}, {input}, {}, true, true)[0];
  return 0.5 * gradient.square().flatten(1).sum(1).mean();
}

Tensor MeanDistance(const Tensor& a, const Tensor& b) {
  return ((a - b).square().sum(-1) + kTiny).sqrt().mean();
}

// softplus(-logit) is the cross entropy of "real", softplus(logit) that of "made".
void Learner::TeachCritic(const Batch& batch, const Tensor& fake) {
  critic_.parameters.RequireGradient(true);
  Tensor real_logit, fake_logit, loss;
  if (Penalized()) {
    const Tensor real = batch.source.detach().clone().requires_grad_(true);
    real_logit = critic_(graph_, real, batch.domain, batch.content);
    fake_logit = critic_(graph_, fake.detach(), batch.target, batch.content);
    const Tensor penalty = GradientPenalty(real_logit, real);
    means_.Add("penalty", penalty);
    loss = config_.w_penalty * config_.penalty_every * penalty;
  } else {
    const Tensor logit = critic_(graph_, torch::cat({batch.source, fake.detach()}),
                                 torch::cat({batch.domain, batch.target}),
                                 torch::cat({batch.content, batch.content}));
    real_logit = logit.narrow(0, 0, config_.batch);
    fake_logit = logit.narrow(0, config_.batch, config_.batch);
    loss = torch::zeros({}, torch::TensorOptions().device(device_));
  }
  const Tensor judgement = MaskedMean(torch::softplus(-real_logit), batch.paired) +
                           MaskedMean(torch::softplus(fake_logit), batch.paired);
  means_.Add("critic", judgement);
  critic_.parameters.ZeroGradient();
  (loss + judgement).backward();
}

void Learner::StepCritic(double decay) {
  StepAdam(critic_.parameters, critic_adam_, config_.critic_rate * decay);
}

// Losses beyond the paper's: positions that agree with the rotations, and changes of style without
// jerk.
Tensor Learner::BodyLosses(const Batch& batch, const Made& made) {
  Tensor loss = torch::zeros({}, torch::TensorOptions().device(device_));
  if (config_.w_fk > 0) {
    const Tensor published = config_.judge_published ? made.fake : kinematics_.Published(made.raw);
    const Tensor fk =
        (made.raw - published).abs().mean() +
        (made.reconstruction - kinematics_.Published(made.reconstruction)).abs().mean();
    loss = loss + config_.w_fk * fk;
    means_.Add("fk", fk);
  }
  if (config_.w_smooth > 0) {
    const Tensor change_m =
        kinematics_.Positions_m(made.fake) - kinematics_.Positions_m(batch.source);
    const Tensor third = change_m.diff(3, 1);
    const Tensor smooth = kCmPerM * MeanDistance(third, torch::zeros_like(third));
    loss = loss + config_.w_smooth * smooth;
    means_.Add("smooth", smooth);
  }
  return loss;
}

// The mean pose by an example of the target's style: it should have the example's posture.
Tensor Learner::Posture(const Batch& batch, const Made& made) {
  const Tensor off = (made.fake.mean(1) - batch.wanted).abs().mean({1, 2});
  const Tensor posture = MaskedMean(off, batch.has_wanted);
  means_.Add("posture", posture);
  return config_.w_posture * posture;
}

// The head without a label: a window of the source's clip is shifted as a whole, rotations first,
// so that it shows a new posture; the source, shifted by other rotations, should be decoded in that
// posture.
Tensor Learner::ReadPosture(const Batch& batch) {
  const Tensor example = kinematics_.Published(batch.same_clip + batch.read_wanted);
  const Tensor wanted = kinematics_.Published(batch.source + batch.read_wanted);
  const Tensor source = kinematics_.Published(batch.source + batch.read_source);
  const Networks& n = networks_;
  const Tensor code = n.encoder.FreeCode(n.encoder.Features(graph_, example));
  const Tensor decoded = n.generator.Decode(graph_, n.generator.Encode(graph_, source), code);
  const Tensor read = JointNorm(decoded - wanted);
  means_.Add("read", read);
  return config_.w_read * read;
}

// The weighted diversity of the two outputs; then its weight follows their distance.
Tensor Learner::Diversity(const Made& made, Turn turn, const std::string& suffix) {
  const Tensor apart_cm = kCmPerM * MeanDistance(kinematics_.Positions_m(made.fake.detach()),
                                                 kinematics_.Positions_m(made.other_fake));
  const Tensor weight = diversity_[static_cast<std::size_t>(turn)].Observe(apart_cm);
  means_.Add("apart_cm" + suffix, apart_cm);
  means_.Add("w_diversity" + suffix, weight);
  return weight * (made.fake - made.other_fake).abs().mean();
}

Tensor Learner::Losses(const Batch& batch, const Made& made, Turn turn) {
  const Networks& n = networks_;
  const std::string suffix = turn == Turn::kNoise ? "_noise" : "_reference";
  const Tensor logit = critic_(graph_, made.fake, batch.target, batch.content);
  const Tensor adversarial = MaskedMean(torch::softplus(-logit), batch.paired);
  const Tensor identity = JointNorm(made.reconstruction - batch.source);
  const Tensor back =
      n.generator.Decode(graph_, n.generator.Encode(graph_, made.fake), made.own_code);
  const Tensor cycle = JointNorm(back - batch.source);
  // A code of a reference is not drawn toward the code read from the output, because both would
  // become constant.
  const Tensor wanted = turn == Turn::kNoise ? made.target_code : made.target_code.detach();
  const Tensor read = n.encoder.Code(n.encoder.Features(graph_, made.fake), batch.target);
  const Tensor style = (wanted - read).abs().mean();
  means_.Add("adversarial" + suffix, adversarial);
  means_.Add("identity", identity);
  means_.Add("cycle", cycle);
  means_.Add("style" + suffix, style);
  means_.Add("free", made.free_loss);
  Tensor loss = config_.w_adversarial * adversarial + config_.w_identity * identity +
                config_.w_cycle * cycle + config_.w_style * style +
                config_.w_free * made.free_loss - Diversity(made, turn, suffix) +
                BodyLosses(batch, made);
  if (turn == Turn::kReferences && config_.w_posture > 0) loss = loss + Posture(batch, made);
  if (turn == Turn::kReferences && config_.w_read > 0) loss = loss + ReadPosture(batch);
  return loss;
}

void Learner::TeachGenerator(const Batch& batch, const Made& made, Turn turn) {
  critic_.parameters.RequireGradient(false);
  const Tensor loss = Losses(batch, made, turn);
  for (const auto& [name, parameters] : networks_.parts()) parameters->ZeroGradient();
  loss.backward();
}

void Learner::StepGenerator(Turn turn, double decay) {
  Networks& n = networks_;
  StepAdam(n.generator.parameters, generator_adam_, config_.generator_rate * decay);
  if (turn == Turn::kNoise) {
    StepAdam(n.mapping.parameters, mapping_adam_, config_.mapping_rate * decay);
  }
  if (turn == Turn::kNoise || config_.encoder_learns_from_references) {
    StepAdam(n.encoder.parameters, encoder_adam_, config_.encoder_rate * decay);
  }
}

}  // namespace styled::train::st_gcn
