#include "model/train/erd/learner.h"

#include <ATen/CPUGeneratorImpl.h>

#include <algorithm>
#include <utility>

#include "model/train/geometry.h"

namespace styled::train::style_erd {
namespace {

using torch::Tensor;

// Windows that a style's effect in a content must be measured in: fewer are noise.
constexpr int kFewestWindows = 4;

int StyleCount(const clip::Manifest& manifest) { return static_cast<int>(manifest.styles.size()); }
int ContentCount(const clip::Manifest& manifest) {
  return static_cast<int>(manifest.contents.size());
}

Sampler::Options SamplerOptions(const Config& config, uint64_t seed,
                                const clip::Manifest& manifest) {
  return {.styles = StyleCount(manifest),
          .contents = ContentCount(manifest),
          .per_style = config.per_style,
          .length = config.window + 1,
          .carry = config.carry,
          .session_start = config.session_start,
          .unpaired = config.unpaired,
          .miscalibrated = config.miscalibrated,
          .idle = config.idle,
          .pairs = config.pairs,
          .seed = seed};
}

GeneratorShape ShapeOf(GeneratorShape shape, const Config& config, const clip::Manifest& manifest) {
  shape.styles = StyleCount(manifest);
  if (config.content_input) shape.contents = ContentCount(manifest);
  return shape;
}

int64_t IdleContent(const Config& config, const clip::Manifest& manifest) {
  if (config.idle <= 0) return -1;
  const std::vector<std::string>& all = manifest.contents;
  return std::find(all.begin(), all.end(), config.idle_as) - all.begin();
}

Tensor ToTensor(const erd::Features& features, const torch::Device& device) {
  return torch::from_blob(const_cast<float*>(features.data()), {erd::kFeatureCount})
      .clone()
      .to(device);
}

// 1 for each of the manifest's contents that is named.
Tensor Named(const clip::Manifest& manifest, const std::vector<std::string>& names,
             const torch::Device& device) {
  Tensor out = torch::zeros({static_cast<int64_t>(manifest.contents.size())});
  for (std::size_t i = 0; i < manifest.contents.size(); ++i) {
    const bool named = std::find(names.begin(), names.end(), manifest.contents[i]) != names.end();
    out[static_cast<int64_t>(i)] = named ? 1.0F : 0.0F;
  }
  return out.to(device);
}

// Learning rates are constant, then fall linearly.
double Decay(const Config& config, double progress) {
  if (progress <= config.decay_from) return 1.0;
  const double share = std::min(1.0, (progress - config.decay_from) / (1.0 - config.decay_from));
  return 1.0 + (config.decay_to - 1.0) * share;
}

// The smoothness term's share of its weight.
double SmoothShare(const Config& config, double progress) {
  const double length = std::max(1e-9, config.smooth_full - config.smooth_from);
  return std::clamp((progress - config.smooth_from) / length, 0.0, 1.0);
}

}  // namespace

// The order of the members is that in which the networks draw their random weights.
Learner::Learner(const Config& config, uint64_t seed, const LearnerData& data,
                 const torch::Device& device)
    : config_(config),
      manifest_(data.manifest),
      clips_(data.clips),
      seed_(seed),
      device_(device),
      mean_(ToTensor(data.statistics.mean, device)),
      deviation_(ToTensor(data.statistics.deviation, device)),
      frames_(config.window + 1),
      sampler_(clips_, SamplerOptions(config, seed, manifest_)),
      batches_(clips_, ContentCount(manifest_), config.window + 1, data.parameters, mean_,
               deviation_),
      moments_(MeasureEffects(clips_, StyleCount(manifest_), ContentCount(manifest_), config.window,
                              kFewestWindows, data.parameters),
               device),
      generator_(ShapeOf(data.shape, config, manifest_), mean_, deviation_),
      average_(generator_.shape, mean_, deviation_),
      critic_(kJudgedFeatures, StyleCount(manifest_), ContentCount(manifest_), config.window,
              config.attention),
      classifier_(kContentFeatures, ContentCount(manifest_)),
      generator_adam_(generator_.parameters, config.beta1, config.beta2),
      critic_adam_((critic_.parameters.Flatten(device), critic_.parameters), config.beta1,
                   config.beta2),
      w_smooth_(torch::zeros({}, torch::TensorOptions().device(device))),
      records_(device.is_cuda()),
      ahead_(!device.is_cpu(), [this](int64_t iteration) { return MakeBatch(iteration); }) {
  classifier_.parameters.Flatten(device);
  average_.parameters.RequireGradient(false);
  average_.parameters.flat().copy_(generator_.parameters.flat());
  slots_ = FixedSlots();
  if (!config.add_styles.empty()) FreezeAllButTheStyles();
  if (!config.learned_states) StartFromZeros();
  const torch::NoGradGuard no_grad;
  carried_ = generator_.Start(slots_);
  teachers_.emplace(
      Distillation::Setup{.manifest = manifest_,
                          .clips = clips_,
                          .rate_hz = config_.rate_hz,
                          .lead_s = config_.teacher_lead_s,
                          .slots = slots_,
                          .mean = mean_,
                          .deviation = deviation_,
                          .idle_content = IdleContent(config, manifest_),
                          .idle_contents = Named(manifest_, config_.idle_contents, device_),
                          .kept_contents = Named(manifest_, config_.kept_contents, device_)});
  if (!records_) return;
  UseRecordableStream();
  means_.KeepSums();
}

// With pairs, each batch has its own styles; these have their shapes.
Slots Learner::FixedSlots() const {
  std::vector<int64_t> input, target;
  for (int slot = 0; slot < sampler_.slots(); ++slot) {
    input.push_back(config_.pairs > 0 ? slot % 2 : sampler_.InputStyle(slot));
    target.push_back(config_.pairs > 0 ? 1 - slot % 2 : sampler_.TargetStyle(slot));
  }
  const int64_t styles = generator_.shape.styles;
  Slots slots =
      config_.pairs > 0 ? PlacedSlots(input, target, styles) : OrderedSlots(input, target, styles);
  for (Tensor* tensor : {&slots.input, &slots.target, &slots.input_one_hot, &slots.target_one_hot,
                         &slots.styled, &slots.window_of_place, &slots.place_of_window}) {
    if (tensor->defined()) *tensor = tensor->to(device_);
  }
  return slots;
}

// In memory of the CPU; it may run in another thread (OneAhead).
OneAhead<Batch>::Made Learner::MakeBatch(int64_t iteration) {
  const torch::NoGradGuard no_grad;
  const std::vector<Sampler::Window> windows = sampler_.Next();
  Batch batch = batches_.Make(windows);
  if (config_.offset > 0 || config_.noise > 0) {
    batch.input = Disturb(batch.input, config_.offset, config_.noise,
                          seed_ * 1000003 + static_cast<uint64_t>(iteration));
  }
  if (generator_.shape.contents > 0) DrawContentSources(iteration, batch);
  if (config_.pairs > 0) {
    std::vector<int64_t> input, target;
    for (const Sampler::Window& window : windows) {
      input.push_back(window.style);
      target.push_back(window.target);
    }
    batch.slots = PlacedSlots(input, target, generator_.shape.styles);
  }
  if (device_.is_cuda()) PinMemory(batch.all());
  return {std::move(batch), sampler_.Save()};
}

// Seeded by the iteration, so that a resumed run draws the same.
void Learner::DrawContentSources(int64_t iteration, Batch& batch) const {
  constexpr uint64_t kSourceSeed = 3000017;  // apart from the disturbance's
  const at::Generator random = at::detail::createCPUGenerator(
      seed_ * 1000003 + static_cast<uint64_t>(iteration) + kSourceSeed);
  const Tensor draw = torch::rand({batch.content.size(0)}, random);
  batch.labelled = (draw < config_.content_label).to(torch::kFloat32);
  batch.recognized = (draw >= config_.content_label + config_.content_unknown).to(torch::kFloat32);
}

const Batch& Learner::NextBatch() {
  Batch next = ahead_.Next(iteration_);
  if (device_.is_cpu()) {
    batch_ = std::move(next);
  } else {
    CopyToDevice(next.all(), device_, batch_.all());
    batch_.windows = std::move(next.windows);
  }
  if (config_.pairs == 0) batch_.slots = slots_;
  return batch_;
}

bool Learner::Penalized() const { return iteration_ % config_.penalty_every == 0; }

void Learner::Run(RecordedWork& recorded, const std::function<void()>& work) {
  if (records_) {
    recorded.Run(means_, work);
  } else {
    work();
  }
}

// The label, what the recognizer has found up to each frame, or nothing. The recognizer learns from
// all windows, and from its own loss alone.
ContentInput Learner::Contents(const Batch& batch, Carried& carried, Generated& out) {
  if (generator_.shape.contents == 0) return {};
  const Stack& recognizer = generator_.recognizer;
  carried.recognizer = Stack::Start(recognizer.Initial(batch.slots.count()), carried.recognizer,
                                    batch.carried.view({1, -1, 1}));
  const Tensor logits = generator_.Recognize(batch.input, carried.recognizer);
  const Tensor label = batch.content.argmax(1);
  out.recognition =
      torch::nn::functional::cross_entropy(logits.flatten(0, 1), label.repeat({frames_}));
  means_.Add("recognizer", out.recognition);
  means_.Add("recognized", (logits[frames_ - 1].argmax(1) == label).to(torch::kFloat32).mean());
  const torch::NoGradGuard no_grad;
  const Tensor age_s = torch::where(batch.carried, carried.age_s, torch::zeros_like(carried.age_s));
  const Tensor at_s = torch::arange(frames_, age_s.options()).unsqueeze(1) / config_.rate_hz +
                      age_s.unsqueeze(0);  // [T, B]
  const Tensor certainty = 1.0 - (-at_s / config_.content_rise_s).exp();
  const Tensor found = torch::softmax(logits, 2) * certainty.unsqueeze(2);
  carried.age_s = age_s + static_cast<double>(frames_) / config_.rate_hz;
  const Tensor labelled = batch.labelled.view({1, -1, 1});
  ContentInput in;
  in.content = labelled * batch.content.unsqueeze(0) + batch.recognized.view({1, -1, 1}) * found;
  in.start =
      torch::where(batch.labelled > 0, label, torch::full_like(label, generator_.shape.contents));
  return in;
}

Status Learner::AddTeacher(const LoadedWeights& weights, const std::vector<Lesson>& lessons) {
  return teachers_->Add(weights, lessons);
}

Status Learner::AddTeacher(const net::ClipStylizer& network, const std::vector<Lesson>& lessons) {
  return teachers_->Add(network, lessons);
}

// A badly calibrated window must have the same output as the well calibrated one: `rec` is compared
// with that, and the change of style is applied to it before it is judged.
Learner::Generated Learner::Generate(const Batch& batch) {
  Generated out;
  Carried ends = carried_;
  const ContentInput contents = Contents(batch, ends, out);
  const Decoded decoded =
      generator_.Transfer(batch.input, batch.slots, contents, batch.carried, ends);
  carried_.CopyFrom(ends);
  const int64_t count = batch.slots.count();
  out.rec = decoded.rotations.narrow(1, 0, count);
  out.rec_velocities = decoded.velocities.narrow(1, 0, count);
  out.rec_height = decoded.height.narrow(1, 0, count);
  const Tensor sty = decoded.rotations.narrow(1, count, count);
  out.change = Multiply(Conjugate(out.rec), sty);
  out.rotations = config_.judge_published ? Multiply(batch.rotations(), out.change) : sty;
  const Tensor positions = HipsRelativePositions(torch::cat({out.rec, out.rotations}, 1));
  out.rec_positions = positions.narrow(1, 0, count);
  const Tensor sty_positions = positions.narrow(1, count, count);
  const bool compared = config_.w_teacher_position > 0 || config_.w_teacher_velocity > 0;
  if (compared && !teachers_->empty()) {
    out.positions = config_.judge_published
                        ? sty_positions
                        : HipsRelativePositions(Multiply(batch.rotations(), out.change));
  }
  out.rise_m = (decoded.height.narrow(1, count, count) - out.rec_height).squeeze(2) *
               deviation_[erd::kHipsHeightIndex];
  // The lowest foot stays as high as the input's.
  const Tensor lift = LowestFoot(batch.positions()) - LowestFoot(sty_positions);
  out.fake = Judged(sty_positions.narrow(0, 1, frames_ - 1),
                    WorldVelocities(sty_positions, batch.yaw_change_rad, batch.hips_step_m, lift,
                                    config_.rate_hz));
  return out;
}

// Real +1, fake -1, and the gradient penalty on real windows (eq. 5, 6).
void Learner::TeachCritic(const Batch& batch, const Tensor& fake) {
  const bool penalized = Penalized();
  const Tensor x = Real(batch).detach().requires_grad_(penalized);
  const Tensor real_score = critic_(x, torch::cat({batch.slots.input_one_hot, batch.content}, 1));
  const Tensor fake_score =
      critic_(fake.detach(), torch::cat({batch.slots.target_one_hot, batch.content}, 1));
  const Tensor judgement =
      (real_score - 1.0).square().mean() + PairedMean(batch, (fake_score + 1.0).square());
  Tensor loss = judgement;
  if (penalized) {
    const Tensor gradient = torch::autograd::grad({real_score.sum()}, {x}, {}, true, true)[0];
    const Tensor penalty = config_.w_penalty * config_.penalty_every *
                           gradient.square().sum(torch::IntArrayRef({0, 2})).mean();
    loss = loss + penalty;
    means_.Add("penalty", penalty);
  }
  means_.Add("critic", judgement);
  means_.Add("real", real_score.mean());
  means_.Add("fake", fake_score.mean());
  critic_.parameters.ZeroGradient();
  loss.backward();
}

void Learner::TeachGenerator(const Batch& batch, const Generated& generated) {
  critic_.parameters.RequireGradient(false);
  Tensor loss =
      config_.summed ? SummedReconstruction(batch, generated) : Reconstruction(batch, generated);
  if (config_.w_adversarial > 0) {
    loss = loss + config_.w_adversarial * Adversarial(batch, generated);
  }
  if (config_.w_perceptual > 0) {
    const Tensor perceptual = Perceptual(batch, generated);
    means_.Add("perceptual", perceptual);
    loss = loss + config_.w_perceptual * perceptual;
  }
  if (config_.w_moments > 0) {
    loss = loss + config_.w_moments * MomentMatching(batch, generated);
  }
  if (!teachers_->empty()) loss = loss + Teaching(batch, generated);
  loss = loss + w_smooth_ * Smoothness(generated);
  means_.Add("loss", loss);
  if (generated.recognition.defined()) loss = loss + generated.recognition;
  generator_.parameters.ZeroGradient();
  loss.backward();
  critic_.parameters.RequireGradient(true);
  if (trained_.defined()) generator_.parameters.gradient().mul_(trained_);
}

// Early on the mean is over fewer iterations, so that it does not keep the random weights.
void Learner::UpdateAverage() {
  const torch::NoGradGuard no_grad;
  const auto n = static_cast<double>(iteration_);
  const double keep = std::min(config_.ema, (1.0 + n) / (10.0 + n));
  average_.parameters.flat().lerp_(generator_.parameters.flat(), 1.0 - keep);
}

void Learner::Step(double progress) {
  const double decay = Decay(config_, progress);
  w_smooth_.fill_(config_.w_smooth * SmoothShare(config_, progress));
  const Batch& batch = NextBatch();
  teachers_->See(batch);
  Recorded& r = recorded_[Penalized() ? 1 : 0];
  Run(r.critic, [&] {
    r.made = Generate(batch);
    if (config_.w_adversarial > 0) TeachCritic(batch, r.made.fake);
  });
  if (config_.w_adversarial > 0) critic_adam_.Step(critic_.parameters, config_.critic_rate * decay);
  if (iteration_ < config_.critic_first) {
    ++iteration_;
    return;
  }
  Run(r.generator, [&] { TeachGenerator(batch, r.made); });
  generator_adam_.Step(generator_.parameters, config_.generator_rate * decay);
  if (!records_) r.made = {};  // a recording reads it again
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
  SaveCarried(carried_, "", checkpoint);
  teachers_->Save(checkpoint);
  checkpoint.strings["sampler"] = ahead_.sampler().empty() ? sampler_.Save() : ahead_.sampler();
}

Status Learner::Restore(const Checkpoint& checkpoint) {
  const torch::NoGradGuard no_grad;
  try {
    const auto& t = checkpoint.tensors;
    if (!torch::equal(t.at("mean"), mean_.cpu()) ||
        !torch::equal(t.at("deviation"), deviation_.cpu())) {
      return Status::Error("was made with other data or another rate");
    }
    if (t.at("generator").sizes() != generator_.parameters.flat().sizes()) {
      return Status::Error("was made with other styles, another --wide or another --content-input");
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
    RestoreCarried(checkpoint, "", carried_);
    teachers_->Restore(checkpoint);
    sampler_.Restore(checkpoint.strings.at("sampler"));
  } catch (const std::exception& error) {
    return Status::Error(Reason(error));
  }
  classifier_.parameters.RequireGradient(false);
  return Status::Ok();
}

}  // namespace styled::train::style_erd
