#include "model/train/erd/learner.h"

#include <algorithm>
#include <iostream>

#include "model/train/geometry.h"

namespace styled::train {
namespace {

using torch::Tensor;

constexpr int64_t kJudgedFeatures = erd::kPositionFeatures + erd::kVelocityFeatures;
constexpr int kFewestWindows = 4;  // of a cell whose effect or mean is imitated: fewer are noise
constexpr int64_t kContentFeatures = erd::kRotationFeatures + kJudgedFeatures;

void RequireGradient(const Parameters& parameters, bool required) {
  for (const auto& [name, tensor] : parameters.named()) tensor.requires_grad_(required);
}

Sampler::Options SamplerOptions(const TrainConfig& config, const clip::Manifest& manifest) {
  return {.styles = static_cast<int>(manifest.styles.size()),
          .contents = static_cast<int>(manifest.contents.size()),
          .per_style = config.per_style,
          .length = config.window + 1,
          .carry = config.carry,
          .session_start = config.session_start,
          .miscalibrated = config.miscalibrated,
          .idle = config.idle,
          .seed = config.seed};
}

GeneratorShape Shape(const clip::Manifest& manifest) {
  GeneratorShape shape;
  shape.styles = static_cast<int64_t>(manifest.styles.size());
  return shape;
}

Tensor ToTensor(const erd::Features& features, const torch::Device& device) {
  return torch::from_blob(const_cast<float*>(features.data()), {erd::kFeatureCount})
      .clone()
      .to(device);
}

// Learning rates are constant, then fall linearly.
double Decay(const TrainConfig& config, double progress) {
  if (progress <= config.decay_from) return 1.0;
  const double share = std::min(1.0, (progress - config.decay_from) / (1.0 - config.decay_from));
  return 1.0 + (config.decay_to - 1.0) * share;
}

}  // namespace

void Tally::Add(const std::string& name, const Tensor& value) {
  const auto found = std::find_if(sums_.begin(), sums_.end(),
                                  [&name](const auto& item) { return item.first == name; });
  if (found == sums_.end()) {
    sums_.emplace_back(name, value.detach().clone());
  } else {
    found->second += value.detach();
  }
}

std::vector<std::pair<std::string, double>> Tally::Take(int count) {
  std::vector<std::pair<std::string, double>> means;
  for (const auto& [name, sum] : sums_) means.emplace_back(name, sum.item<double>() / count);
  sums_.clear();
  return means;
}

Learner::Learner(const TrainConfig& config, const clip::Manifest& manifest,
                 const std::vector<TrainingClip>& clips, const FeatureStatistics& statistics,
                 const erd::FeatureParameters& parameters, const torch::Device& device)
    : config_(config),
      manifest_(manifest),
      clips_(clips),
      parameters_(parameters),
      device_(device),
      mean_(ToTensor(statistics.mean, device)),
      deviation_(ToTensor(statistics.deviation, device)),
      frames_(config.window + 1),
      sampler_(clips, SamplerOptions(config, manifest)),
      moments_(MeasureEffects(clips, static_cast<int>(manifest.styles.size()),
                              static_cast<int>(manifest.contents.size()), config.window,
                              kFewestWindows, parameters),
               device),
      generator_(Shape(manifest), mean_, deviation_),
      average_(Shape(manifest), mean_, deviation_),
      critic_(kJudgedFeatures, static_cast<int64_t>(manifest.styles.size()),
              static_cast<int64_t>(manifest.contents.size()), config.window, config.attention),
      classifier_(kContentFeatures, static_cast<int64_t>(manifest.contents.size())),
      generator_adam_(generator_.parameters, config.beta1, config.beta2),
      critic_adam_((critic_.parameters.Flatten(device), critic_.parameters), config.beta1,
                   config.beta2) {
  classifier_.parameters.Flatten(device);
  RequireGradient(average_.parameters, false);
  average_.parameters.flat().copy_(generator_.parameters.flat());

  std::vector<int64_t> own, target;
  for (int slot = 0; slot < sampler_.slots(); ++slot) {
    own.push_back(sampler_.InputStyle(slot));
    target.push_back(sampler_.TargetStyle(slot));
  }
  const int64_t styles = generator_.shape.styles;
  slots_.own = torch::tensor(own, torch::kInt64).to(device);
  slots_.target = torch::tensor(target, torch::kInt64).to(device);
  slots_.own_one_hot = torch::one_hot(slots_.own, styles).to(torch::kFloat32);
  slots_.target_one_hot = torch::one_hot(slots_.target, styles).to(torch::kFloat32);
  slots_.styled = (slots_.own > 0).to(torch::kFloat32).view({1, -1, 1});

  if (!config.add_styles.empty()) FreezeAllButTheStyles();
  if (!config.learned_states) StartFromZeros();

  torch::NoGradGuard no_grad;
  carried_ = generator_.Start(slots_);
}

Learner::Batch Learner::MakeBatch(const std::vector<Sampler::Window>& windows) const {
  const auto count = static_cast<int64_t>(windows.size());
  Batch batch;
  Tensor features = torch::empty({frames_, count, erd::kFeatureCount});
  Tensor yaw = torch::empty({frames_, count});
  Tensor step = torch::empty({frames_, count, 3});
  Tensor content = torch::zeros({count, static_cast<int64_t>(manifest_.contents.size())});
  Tensor carried = torch::zeros({count}, torch::kBool);
  Tensor idle = torch::zeros({count}, torch::kBool);
  Tensor paired = torch::zeros({count});
  Tensor seen;  // made where a window is miscalibrated
  const auto wrong = [](const Sampler::Window& window) { return window.miscalibration != 0; };
  if (std::any_of(windows.begin(), windows.end(), wrong)) seen = torch::empty_like(features);
  for (int64_t i = 0; i < count; ++i) {
    const Sampler::Window& window = windows[i];
    FillWindow(clips_[window.clip], window.start, static_cast<int>(frames_), window.mirrored,
               window.session_start || window.idle, parameters_,
               {.features = features.data_ptr<float>() + i * erd::kFeatureCount,
                .feature_stride = count * erd::kFeatureCount,
                .yaw_change_rad = yaw.data_ptr<float>() + i,
                .yaw_stride = count,
                .hips_step_m = step.data_ptr<float>() + i * 3,
                .step_stride = count * 3});
    if (seen.defined()) {
      Miscalibration draw;
      if (wrong(window)) draw = DrawMiscalibration(window.miscalibration);
      FillWindow(clips_[window.clip], window.start, static_cast<int>(frames_), window.mirrored,
                 window.session_start, parameters_,
                 {.features = seen.data_ptr<float>() + i * erd::kFeatureCount,
                  .feature_stride = count * erd::kFeatureCount},
                 wrong(window) ? &draw : nullptr);
    }
    if (window.idle) {  // every frame is the first, in which nothing moves
      features.narrow(1, i, 1).copy_(features.narrow(0, 0, 1).narrow(1, i, 1).clone());
      if (seen.defined()) seen.narrow(1, i, 1).copy_(features.narrow(1, i, 1));
      yaw.narrow(1, i, 1).zero_();
      step.narrow(1, i, 1).zero_();
      idle.data_ptr<bool>()[i] = true;
    }
    content.data_ptr<float>()[i * content.size(1) + window.content] = 1.0F;
    paired.data_ptr<float>()[i] = window.paired ? 1.0F : 0.0F;
    carried.data_ptr<bool>()[i] = window.carried;
  }
  batch.features = features.to(device_);
  batch.u = (batch.features - mean_) / deviation_;
  batch.seen = seen.defined() ? (seen.to(device_) - mean_) / deviation_ : batch.u;
  batch.rotations = batch.features.narrow(2, 0, erd::kRotationFeatures)
                        .reshape({frames_, count, body::kJointCount, 4});
  batch.positions = batch.features.narrow(2, erd::kPositionBegin, erd::kPositionFeatures)
                        .reshape({frames_, count, body::kJointCount, 3});
  batch.yaw_change_rad = yaw.to(device_);
  batch.hips_step_m = step.to(device_);
  batch.content = content.to(device_);
  batch.carried = carried.to(device_);
  batch.idle = idle.to(device_);
  batch.paired = paired.to(device_);
  return batch;
}

// What another performer, rig or floor does to the features, roughly and for the cost of some
// random numbers: each is off by a constant, and by noise that is new in every frame. How much of
// both differs from window to window, none included.
Tensor Learner::Spoil(const Tensor& u) const {
  // Seeded by the iteration, so that a resumed run goes on bit for bit.
  torch::manual_seed(config_.seed * 1000003 + static_cast<std::uint64_t>(iteration_));
  const auto amount = [&u] { return torch::rand({1, u.size(1), 1}, u.options()); };
  const Tensor offset = torch::randn({1, u.size(1), u.size(2)}, u.options()) * amount();
  const Tensor noise = torch::randn_like(u) * amount();
  return u + config_.offset * offset + config_.noise * noise;
}

void Learner::TrainClassifier() {
  Sampler::Options options = sampler_.options();
  options.seed += 1000003;
  Sampler sampler(clips_, options);
  Adam adam(classifier_.parameters);
  const int styles = options.styles;
  double loss_sum = 0, right_sum = 0;
  for (int i = 0; i < config_.classifier_iterations; ++i) {
    std::vector<Sampler::Window> windows;
    for (int64_t k = 0; k < slots_.count(); ++k)
      windows.push_back(sampler.Draw(static_cast<int>(k) % styles));
    const Batch batch = MakeBatch(windows);
    const Tensor u = batch.u.narrow(0, 1, frames_ - 1).narrow(2, 0, kContentFeatures);
    const Tensor logits = classifier_.Logits(u);
    const Tensor label = batch.content.argmax(1);
    const Tensor loss = torch::nn::functional::cross_entropy(logits, label);
    classifier_.parameters.ZeroGradient();
    loss.backward();
    adam.Step(classifier_.parameters, 1e-3 * (1.0 - 0.9 * i / config_.classifier_iterations));
    loss_sum += loss.item<double>();
    right_sum += (logits.argmax(1) == label).to(torch::kFloat32).mean().item<double>();
    if ((i + 1) % 250 == 0) {
      std::cout << "classifier " << i + 1 << ": loss " << loss_sum / 250 << ", right "
                << right_sum / 250 << std::endl;
      loss_sum = right_sum = 0;
    }
  }
  RequireGradient(classifier_.parameters, false);
}

// What the critic sees: standardized positions and velocities, [T, B, 126].
Tensor Learner::Judged(const Tensor& positions, const Tensor& velocities) const {
  const Tensor raw = torch::cat({positions.flatten(2, 3), velocities.flatten(2, 3)}, 2);
  return (raw - mean_.narrow(0, erd::kPositionBegin, kJudgedFeatures)) /
         deviation_.narrow(0, erd::kPositionBegin, kJudgedFeatures);
}

Tensor Learner::Real(const Batch& batch) const {
  if (config_.judge_root) {
    return batch.u.narrow(0, 1, frames_ - 1)
        .narrow(2, erd::kPositionBegin, kJudgedFeatures)
        .contiguous();
  }
  const Tensor still = torch::zeros_like(batch.hips_step_m);
  return Judged(batch.positions.narrow(0, 1, frames_ - 1),
                WorldVelocities(batch.positions, batch.yaw_change_rad, still,
                                torch::zeros_like(batch.yaw_change_rad), config_.rate_hz));
}

// A badly calibrated window must come out as the well calibrated one would: `rec` is then compared
// with that, and the change of style is put on that before it is judged.
Learner::Generated Learner::Generate(const Batch& batch) {
  const Decoded decoded = generator_.Transfer(batch.seen, slots_, batch.carried, carried_);
  const int64_t count = slots_.count();
  Generated out;
  out.rec = decoded.rotations.narrow(1, 0, count);
  out.rec_velocities = decoded.velocities.narrow(1, 0, count);
  out.rec_height = decoded.height.narrow(1, 0, count);
  const Tensor sty = decoded.rotations.narrow(1, count, count);
  out.change = Multiply(Conjugate(out.rec), sty);
  out.rotations = config_.judge_published ? Multiply(batch.rotations, out.change) : sty;
  const Tensor positions = HipsRelativePositions(torch::cat({out.rec, out.rotations}, 1));
  out.rec_positions = positions.narrow(1, 0, count);
  const Tensor sty_positions = positions.narrow(1, count, count);
  // The lowest foot stays as high as the input's.
  const Tensor lift = LowestFoot(batch.positions) - LowestFoot(sty_positions);
  const Tensor step = config_.judge_root ? batch.hips_step_m : torch::zeros_like(batch.hips_step_m);
  out.fake =
      Judged(sty_positions.narrow(0, 1, frames_ - 1),
             WorldVelocities(sty_positions, batch.yaw_change_rad, step, lift, config_.rate_hz));
  return out;
}

// The mean over windows whose target the critic knows in their content: where a label pair was
// never recorded, "fake" would follow from the labels alone.
Tensor Learner::PairedMean(const Batch& batch, const Tensor& score) const {
  return (score * batch.paired).sum() / batch.paired.sum().clamp_min(1.0);
}

// Real +1, fake -1, and the gradient penalty on real windows (eq. 5, 6).
void Learner::StepCritic(const Batch& batch, const Tensor& fake, double rate) {
  const bool penalized = iteration_ % config_.penalty_every == 0;
  const Tensor x = Real(batch).detach().requires_grad_(penalized);
  const Tensor real_score = critic_(x, torch::cat({slots_.own_one_hot, batch.content}, 1));
  const Tensor fake_score =
      critic_(fake.detach(), torch::cat({slots_.target_one_hot, batch.content}, 1));
  const Tensor judgement =
      (real_score - 1.0).square().mean() + PairedMean(batch, (fake_score + 1.0).square());
  Tensor loss = judgement;
  if (penalized) {
    const Tensor gradient = torch::autograd::grad({real_score.sum()}, {x}, {}, true, true)[0];
    const Tensor penalty = config_.w_penalty * config_.penalty_every *
                           gradient.square().sum(torch::IntArrayRef({0, 2})).mean();
    loss = loss + penalty;
    tally_.Add("penalty", penalty);
  }
  critic_.parameters.ZeroGradient();
  loss.backward();
  critic_adam_.Step(critic_.parameters, rate);
  tally_.Add("critic", judgement);
  tally_.Add("real", real_score.mean());
  tally_.Add("fake", fake_score.mean());
}

// Eq. 2 and 3, weighted.
Tensor Learner::Reconstruction(const Batch& batch, const Generated& generated) {
  const Tensor rotation =
      SquaredHalfAngle(generated.rec, batch.rotations).sum(torch::IntArrayRef({0, 2})).mean();
  const Tensor position = (generated.rec_positions - batch.positions).square().sum(-1).mean();
  const Tensor velocity =
      (generated.rec_velocities - batch.u.narrow(2, erd::kVelocityBegin, erd::kVelocityFeatures))
          .square()
          .mean();
  const Tensor height =
      (generated.rec_height - batch.u.narrow(2, erd::kHipsHeightIndex, 1)).square().mean();
  tally_.Add("rec_rad", (rotation / (frames_ * body::kJointCount)).sqrt() * 2.0);
  tally_.Add("rec_m", position.sqrt());
  tally_.Add("velocity", velocity);
  tally_.Add("height", height);
  return config_.w_rotation * rotation + config_.w_position * position +
         config_.w_velocity * velocity + config_.w_height * height;
}

// Eq. 7: the classifier's feature maps before and after the transfer.
Tensor Learner::Perceptual(const Batch& batch, const Generated& generated) const {
  const Tensor mean = mean_.narrow(0, 0, erd::kRotationFeatures);
  const Tensor rotations = (ToHemisphere(generated.rotations.narrow(0, 1, frames_ - 1),
                                         mean.view({body::kJointCount, 4}))
                                .flatten(2, 3) -
                            mean) /
                           deviation_.narrow(0, 0, erd::kRotationFeatures);
  std::vector<Tensor> before;
  {
    torch::NoGradGuard no_grad;
    before = classifier_.Maps(batch.u.narrow(0, 1, frames_ - 1).narrow(2, 0, kContentFeatures));
  }
  const std::vector<Tensor> after = classifier_.Maps(torch::cat({rotations, generated.fake}, 2));
  Tensor sum = torch::zeros({}, batch.u.options());
  for (std::size_t i = 0; i < after.size(); ++i) {
    sum = sum + (after[i] - before[i]).square().mean();
  }
  return sum;
}

// The means of what each style does, in neutral windows that were transferred to it.
Tensor Learner::MomentMatching(const Batch& batch, const Generated& generated) {
  const Tensor mean = mean_.narrow(0, erd::kPositionBegin, erd::kPositionFeatures);
  const Tensor deviation = deviation_.narrow(0, erd::kPositionBegin, erd::kPositionFeatures);
  const Tensor in = batch.features.narrow(0, 1, frames_ - 1).narrow(2, 0, kEffectFeatures);
  const Tensor hemisphere = mean_.narrow(0, 0, erd::kRotationFeatures);
  const Tensor rotations = ToHemisphere(generated.rotations.narrow(0, 1, frames_ - 1),
                                        hemisphere.view({body::kJointCount, 4}))
                               .flatten(2, 3);
  const Tensor positions = generated.fake.narrow(2, 0, erd::kPositionFeatures) * deviation + mean;
  const Tensor out = torch::cat({rotations, positions}, 2);
  const Tensor loss = moments_.Loss(in, out, slots_.target, batch.content.argmax(1),
                                    batch.paired * (1.0 - slots_.styled.flatten()));
  tally_.Add("moments", moments_.Distance());
  return loss;
}

// The second difference over time of the change of style: what keeps the output from jerking.
Tensor Learner::Smoothness(const Generated& generated) {
  const Tensor log_change = LogQuaternion(generated.change);
  const Tensor smooth = log_change.diff(2, 0).square().sum(torch::IntArrayRef({0, 2, 3})).mean();
  tally_.Add("smooth", smooth);
  tally_.Add("change_rad", log_change.detach().square().sum(-1).sqrt().mean());
  return smooth;
}

// Replaces what is wanted of who just stands by a mean, the same in every frame; by nothing, until
// that is known.
void Learner::TeachIdle(const Batch& batch, Teacher& teacher, Tensor& wanted, Tensor& gain) const {
  const Tensor model = (slots_.own == 0) & (batch.content.argmax(1) == idle_as_) & ~batch.idle;
  const Tensor counts = model.to(wanted.dtype());
  const Tensor mean = LogQuaternion(wanted).mean(0);  // [B, 21, 3]
  teacher.mean_sum.index_add_(0, slots_.target, mean * counts.view({-1, 1, 1}));
  teacher.mean_count.index_add_(0, slots_.target, counts);

  const Tensor known = teacher.mean_count.index({slots_.target});
  const Tensor taught =
      teacher.mean_sum.index({slots_.target}) / known.clamp_min(1).view({-1, 1, 1});
  wanted = torch::where(batch.idle.view({1, -1, 1, 1}), ExpQuaternion(taught).unsqueeze(0), wanted);
  const Tensor as_model = torch::where(known < kFewestWindows, torch::zeros_like(gain),
                                       teacher.gain.select(1, idle_as_));
  gain = torch::where(batch.idle, as_model, gain);
}

// How far each change of style is from its teacher's, as eq. 2 has it.
Tensor Learner::Teaching(const Batch& batch, const Generated& generated) {
  const int64_t count = slots_.count();
  Tensor sum = torch::zeros({}, batch.u.options());
  Tensor taught = torch::zeros({}, batch.u.options());
  for (Teacher& teacher : teachers_) {
    Tensor wanted, teaches;
    {
      const torch::NoGradGuard no_grad;
      const Tensor of =
          teacher.generator->Transfer(batch.u, slots_, batch.carried, teacher.carried).rotations;
      wanted = Multiply(Conjugate(of.narrow(1, 0, count)), of.narrow(1, count, count));
      Tensor gain = (teacher.gain * batch.content).sum(1);
      if (teacher.mean_sum.defined()) TeachIdle(batch, teacher, wanted, gain);
      teaches = (gain > 0).to(wanted.dtype());
      wanted = ScaleRotation(wanted, gain.view({1, count, 1, 1}));
    }
    const Tensor apart = SquaredHalfAngle(generated.change, wanted);  // [T, B, 21]
    sum = sum + (apart.sum(torch::IntArrayRef({0, 2})) * teaches).sum();
    taught = taught + teaches.sum();
  }
  const Tensor loss = sum / taught.clamp_min(1.0);
  tally_.Add("teacher_rad", (loss.detach() / (frames_ * body::kJointCount)).sqrt() * 2.0);
  return loss;
}

void Learner::UpdateAverage() {
  torch::NoGradGuard no_grad;
  const auto n = static_cast<double>(iteration_);
  const double keep = std::min(config_.ema, (1.0 + n) / (10.0 + n));
  average_.parameters.flat().lerp_(generator_.parameters.flat(), 1.0 - keep);
}

void Learner::Step(double progress) {
  const double decay = Decay(config_, progress);
  const double smooth_share = std::clamp(
      (progress - config_.smooth_from) / std::max(1e-9, config_.smooth_full - config_.smooth_from),
      0.0, 1.0);
  Batch batch = MakeBatch(sampler_.Next());
  if (config_.offset > 0 || config_.noise > 0) batch.seen = Spoil(batch.seen);
  const Generated generated = Generate(batch);
  const bool judged = config_.w_adversarial > 0;
  if (judged) StepCritic(batch, generated.fake, config_.critic_rate * decay);
  if (iteration_ < config_.critic_first) {
    ++iteration_;
    return;
  }

  RequireGradient(critic_.parameters, false);
  Tensor loss = Reconstruction(batch, generated);
  if (judged) {
    const Tensor adversarial = PairedMean(
        batch,
        critic_(generated.fake, torch::cat({slots_.target_one_hot, batch.content}, 1)).square());
    tally_.Add("adversarial", adversarial);
    loss = loss + config_.w_adversarial * adversarial;
  }
  if (config_.w_perceptual > 0) {
    const Tensor perceptual = Perceptual(batch, generated);
    tally_.Add("perceptual", perceptual);
    loss = loss + config_.w_perceptual * perceptual;
  }
  if (config_.w_moments > 0) {
    loss = loss + config_.w_moments * MomentMatching(batch, generated);
  }
  if (!teachers_.empty()) loss = loss + config_.w_teacher * Teaching(batch, generated);
  loss = loss + config_.w_smooth * smooth_share * Smoothness(generated);
  tally_.Add("loss", loss);
  generator_.parameters.ZeroGradient();
  loss.backward();
  RequireGradient(critic_.parameters, true);
  if (trained_.defined()) generator_.parameters.gradient().mul_(trained_);
  generator_adam_.Step(generator_.parameters, config_.generator_rate * decay);
  ++iteration_;
  UpdateAverage();
}

bool Learner::Finite() const {
  return torch::isfinite(generator_.parameters.flat()).all().item<bool>();
}

void Learner::Save(Checkpoint& checkpoint) const {
  auto& t = checkpoint.tensors;
  t["mean"] = mean_;
  t["deviation"] = deviation_;
  t["generator"] = generator_.parameters.flat();
  t["average"] = average_.parameters.flat();
  t["critic"] = critic_.parameters.flat();
  t["classifier"] = classifier_.parameters.flat();
  t["generator.first"] = generator_adam_.first;
  t["generator.second"] = generator_adam_.second;
  t["critic.first"] = critic_adam_.first;
  t["critic.second"] = critic_adam_.second;
  t["moments"] = moments_.Save();
  t["iteration"] = torch::tensor({iteration_}, torch::kInt64);
  const auto save = [&t](const std::string& name, const Carried& carried) {
    t[name + "neutral.h"] = torch::stack(carried.neutral.h);
    t[name + "neutral.c"] = torch::stack(carried.neutral.c);
    t[name + "branches.h"] = torch::stack(carried.branches.h);
    t[name + "branches.c"] = torch::stack(carried.branches.c);
  };
  save("", carried_);
  for (std::size_t i = 0; i < teachers_.size(); ++i) {
    const std::string name = "teacher." + std::to_string(i) + ".";
    save(name, teachers_[i].carried);
    if (!teachers_[i].mean_sum.defined()) continue;
    t[name + "mean_sum"] = teachers_[i].mean_sum;
    t[name + "mean_count"] = teachers_[i].mean_count;
  }
  checkpoint.strings["sampler"] = sampler_.Save();
}

Status Learner::Restore(const Checkpoint& checkpoint) {
  torch::NoGradGuard no_grad;
  try {
    const auto& t = checkpoint.tensors;
    if (!torch::equal(t.at("mean"), mean_.cpu()) ||
        !torch::equal(t.at("deviation"), deviation_.cpu())) {
      return Status::Error("was made with other data or another rate");
    }
    generator_.parameters.flat().copy_(t.at("generator"));
    average_.parameters.flat().copy_(t.at("average"));
    critic_.parameters.flat().copy_(t.at("critic"));
    classifier_.parameters.flat().copy_(t.at("classifier"));
    generator_adam_.first.copy_(t.at("generator.first"));
    generator_adam_.second.copy_(t.at("generator.second"));
    critic_adam_.first.copy_(t.at("critic.first"));
    critic_adam_.second.copy_(t.at("critic.second"));
    moments_.Restore(t.at("moments"));
    iteration_ = t.at("iteration").item<int64_t>();
    critic_adam_.steps = iteration_;
    generator_adam_.steps = std::max<int64_t>(0, iteration_ - config_.critic_first);
    const auto unstack = [this](const Tensor& all, std::vector<Tensor>& layers) {
      TORCH_CHECK(
          all.size(0) == static_cast<int64_t>(layers.size()) && all[0].sizes() == layers[0].sizes(),
          "carried states of another batch");
      for (std::size_t i = 0; i < layers.size(); ++i) {
        layers[i] = all[static_cast<int64_t>(i)].clone().to(device_);
      }
    };
    const auto restore = [&](const std::string& name, Carried& carried) {
      unstack(t.at(name + "neutral.h"), carried.neutral.h);
      unstack(t.at(name + "neutral.c"), carried.neutral.c);
      unstack(t.at(name + "branches.h"), carried.branches.h);
      unstack(t.at(name + "branches.c"), carried.branches.c);
    };
    restore("", carried_);
    for (std::size_t i = 0; i < teachers_.size(); ++i) {
      const std::string name = "teacher." + std::to_string(i) + ".";
      restore(name, teachers_[i].carried);
      if (!teachers_[i].mean_sum.defined()) continue;
      teachers_[i].mean_sum.copy_(t.at(name + "mean_sum"));
      teachers_[i].mean_count.copy_(t.at(name + "mean_count"));
    }
    sampler_.Restore(checkpoint.strings.at("sampler"));
  } catch (const std::exception& error) {
    return Status::Error(Reason(error));
  }
  RequireGradient(classifier_.parameters, false);
  return Status::Ok();
}

}  // namespace styled::train
