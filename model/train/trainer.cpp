#include "model/train/trainer.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>

#include "model/train/adam.h"
#include "model/train/checkpoint.h"
#include "model/train/dataset.h"
#include "model/train/geometry.h"
#include "model/train/monitor.h"
#include "model/train/networks.h"
#include "model/train/sampler.h"

namespace styled::train {
namespace {

using torch::Tensor;
using Clock = std::chrono::steady_clock;

constexpr int64_t kJudgedFeatures = body::kPositionFeatures + body::kVelocityFeatures;
constexpr int64_t kContentFeatures = body::kRotationFeatures + kJudgedFeatures;

double SecondsSince(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

// A batch as tensors on the device, time-major: T = window + 1 frames, B slots.
struct Batch {
  Tensor features, yaw_change_rad, hips_step_m;  // [T, B, 211], [T, B], [T, B, 3]
  Tensor content;                                // [B, contents] one-hot
  Tensor carried;                                // [B] bool
};

// Mean losses since the last line of the log.
class Tally {
 public:
  void Add(const std::string& name, const Tensor& value) {
    auto found = std::find_if(sums_.begin(), sums_.end(),
                              [&name](const auto& item) { return item.first == name; });
    if (found == sums_.end()) {
      sums_.emplace_back(name, value.detach().clone());
    } else {
      found->second += value.detach();
    }
  }
  std::vector<std::pair<std::string, double>> Take(int count) {
    std::vector<std::pair<std::string, double>> means;
    for (auto& [name, sum] : sums_) means.emplace_back(name, sum.item<double>() / count);
    sums_.clear();
    return means;
  }

 private:
  std::vector<std::pair<std::string, Tensor>> sums_;
};

void RequireGradient(const Parameters& parameters, bool required) {
  for (const auto& [name, tensor] : parameters.named()) {
    tensor.requires_grad_(required);
  }
}

class Trainer {
 public:
  Trainer(const TrainConfig& config, const clip::Manifest& manifest,
          const std::vector<TrainingClip>& clips, const std::vector<TrainingClip>& validation,
          const FeatureStatistics& statistics, const body::FeatureParameters& parameters,
          const torch::Device& device);

  void TrainClassifier();
  Status Run();
  Status Save();
  Status Restore();

 private:
  static Sampler::Options SamplerOptions(const TrainConfig& config, const clip::Manifest& manifest);
  static GeneratorShape Shape(const clip::Manifest& manifest) {
    GeneratorShape shape;
    shape.styles = static_cast<int64_t>(manifest.styles.size());
    return shape;
  }
  static Tensor ToTensor(const body::Features& features, const torch::Device& device) {
    return torch::from_blob(const_cast<float*>(features.data()), {body::kFeatureCount})
        .clone()
        .to(device);
  }

  Batch MakeBatch(const std::vector<Sampler::Window>& windows) const;
  StackState Start(const Stack& stack, const StackState& carried, const Tensor& mask) const;
  void Step(double progress);
  double Progress() const;
  double Elapsed() const { return elapsed_before_s_ + SecondsSince(started_); }
  void Log(int count, double seconds, double progress);
  void LogMonitor();
  std::string Metadata() const;
  Tensor Judged(const Tensor& positions, const Tensor& velocities) const;

  const TrainConfig& config_;
  const clip::Manifest& manifest_;
  const std::vector<TrainingClip>& clips_;
  body::FeatureParameters parameters_;
  torch::Device device_;
  Tensor mean_, deviation_;
  int64_t frames_, slots_;

  Sampler sampler_;
  Generator generator_, average_;
  Critic critic_;
  ContentClassifier classifier_;
  Adam generator_adam_, critic_adam_;
  Monitor monitor_;

  Tensor own_, target_;              // [B] int64
  Tensor own_one_hot_, target_one_hot_;  // [B, styles]
  Tensor styled_;                    // [1, B, 1]: 1 where the slot's own style is not neutral
  StackState neutral_carried_, branch_carried_;
  int64_t iteration_ = 0;
  double elapsed_before_s_ = 0;
  Clock::time_point started_ = Clock::now();
  Tally tally_;
};

Sampler::Options Trainer::SamplerOptions(const TrainConfig& config,
                                         const clip::Manifest& manifest) {
  return {.styles = static_cast<int>(manifest.styles.size()),
          .contents = static_cast<int>(manifest.contents.size()),
          .per_style = config.per_style,
          .length = config.window + 1,
          .carry = config.carry,
          .session_start = config.session_start,
          .seed = config.seed};
}

Trainer::Trainer(const TrainConfig& config, const clip::Manifest& manifest,
                 const std::vector<TrainingClip>& clips,
                 const std::vector<TrainingClip>& validation, const FeatureStatistics& statistics,
                 const body::FeatureParameters& parameters, const torch::Device& device)
    : config_(config),
      manifest_(manifest),
      clips_(clips),
      parameters_(parameters),
      device_(device),
      mean_(ToTensor(statistics.mean, device)),
      deviation_(ToTensor(statistics.deviation, device)),
      frames_(config.window + 1),
      sampler_(clips, SamplerOptions(config, manifest)),
      generator_(Shape(manifest), mean_, deviation_),
      average_(Shape(manifest), mean_, deviation_),
      critic_(kJudgedFeatures,
              static_cast<int64_t>(manifest.styles.size() + manifest.contents.size()),
              config.window),
      classifier_(kContentFeatures, static_cast<int64_t>(manifest.contents.size())),
      generator_adam_(generator_.parameters, config.beta1, config.beta2),
      critic_adam_((critic_.parameters.Flatten(device), critic_.parameters), config.beta1,
                   config.beta2),
      monitor_(validation, static_cast<int>(manifest.styles.size()),
               static_cast<int>(manifest.contents.size()), parameters, mean_, deviation_) {
  classifier_.parameters.Flatten(device);
  RequireGradient(average_.parameters, false);
  average_.parameters.flat().copy_(generator_.parameters.flat());

  slots_ = sampler_.slots();
  std::vector<int64_t> own, target;
  for (int slot = 0; slot < slots_; ++slot) {
    own.push_back(sampler_.OwnStyle(slot));
    target.push_back(sampler_.TargetStyle(slot));
  }
  const int64_t styles = generator_.shape.styles;
  own_ = torch::tensor(own, torch::kInt64).to(device);
  target_ = torch::tensor(target, torch::kInt64).to(device);
  own_one_hot_ = torch::one_hot(own_, styles).to(torch::kFloat32);
  target_one_hot_ = torch::one_hot(target_, styles).to(torch::kFloat32);
  styled_ = (own_ > 0).to(torch::kFloat32).view({1, -1, 1});

  torch::NoGradGuard no_grad;
  const auto concrete = [](StackState state) {
    for (Tensor& h : state.h) h = h.detach().clone();
    for (Tensor& c : state.c) c = c.detach().clone();
    return state;
  };
  neutral_carried_ = concrete(generator_.neutral.Initial(slots_));
  branch_carried_ = concrete(generator_.branches.Initial(slots_ / (styles - 1)));
}

Batch Trainer::MakeBatch(const std::vector<Sampler::Window>& windows) const {
  const auto count = static_cast<int64_t>(windows.size());
  Batch batch;
  Tensor features = torch::empty({frames_, count, body::kFeatureCount});
  Tensor yaw = torch::empty({frames_, count});
  Tensor step = torch::empty({frames_, count, 3});
  Tensor content = torch::zeros({count, static_cast<int64_t>(manifest_.contents.size())});
  Tensor carried = torch::zeros({count}, torch::kBool);
  for (int64_t i = 0; i < count; ++i) {
    const Sampler::Window& window = windows[i];
    FillWindow(clips_[window.clip], window.start, static_cast<int>(frames_), window.mirrored,
               window.session_start, parameters_,
               {.features = features.data_ptr<float>() + i * body::kFeatureCount,
                .feature_stride = count * body::kFeatureCount,
                .yaw_change_rad = yaw.data_ptr<float>() + i,
                .yaw_stride = count,
                .hips_step_m = step.data_ptr<float>() + i * 3,
                .step_stride = count * 3});
    content.data_ptr<float>()[i * content.size(1) + clips_[window.clip].content] = 1.0F;
    carried.data_ptr<bool>()[i] = window.carried;
  }
  batch.features = features.to(device_);
  batch.yaw_change_rad = yaw.to(device_);
  batch.hips_step_m = step.to(device_);
  batch.content = content.to(device_);
  batch.carried = carried.to(device_);
  return batch;
}

// The classifier learns contents from real windows of all styles, then is frozen.
void Trainer::TrainClassifier() {
  Sampler::Options options = SamplerOptions(config_, manifest_);
  options.seed += 1000003;
  Sampler sampler(clips_, options);
  Adam adam(classifier_.parameters);
  const int styles = options.styles;
  double loss_sum = 0, right_sum = 0;
  for (int i = 0; i < config_.classifier_iterations; ++i) {
    std::vector<Sampler::Window> windows;
    for (int64_t k = 0; k < slots_; ++k) windows.push_back(sampler.Any(static_cast<int>(k) % styles));
    const Batch batch = MakeBatch(windows);
    const Tensor u = ((batch.features - mean_) / deviation_)
                         .narrow(0, 1, frames_ - 1)
                         .narrow(2, 0, kContentFeatures);
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

StackState Trainer::Start(const Stack& stack, const StackState& carried, const Tensor& mask) const {
  StackState state = stack.Initial(carried.h[0].size(1));
  for (std::size_t layer = 0; layer < state.h.size(); ++layer) {
    state.h[layer] = torch::where(mask, carried.h[layer], state.h[layer]);
    state.c[layer] = torch::where(mask, carried.c[layer], state.c[layer]);
  }
  return state;
}

// What the critic sees: standardized positions and velocities, [T, B, 126].
Tensor Trainer::Judged(const Tensor& positions, const Tensor& velocities) const {
  const Tensor raw = torch::cat({positions.flatten(2, 3), velocities.flatten(2, 3)}, 2);
  return (raw - mean_.narrow(0, body::kPositionBegin, kJudgedFeatures)) /
         deviation_.narrow(0, body::kPositionBegin, kJudgedFeatures);
}

void Trainer::Step(double progress) {
  const int64_t judged_frames = frames_ - 1;
  const Batch batch = MakeBatch(sampler_.Next());
  const Tensor u = (batch.features - mean_) / deviation_;
  const Tensor input_rotations = batch.features.narrow(2, 0, body::kRotationFeatures)
                                     .reshape({frames_, slots_, body::kJointCount, 4});
  const Tensor input_positions =
      batch.features.narrow(2, body::kPositionBegin, body::kPositionFeatures)
          .reshape({frames_, slots_, body::kJointCount, 3});

  // 1. Generate: every sample with its own style (rec) and with its target (sty).
  const Tensor z = generator_.Encode(u, own_);
  StackState neutral_state =
      Start(generator_.neutral, neutral_carried_, batch.carried.view({1, -1, 1}));
  StackState branch_state =
      Start(generator_.branches, branch_carried_,
            batch.carried.view({generator_.branches.groups, -1, 1}));
  const Tensor r0 = generator_.Neutral(z, neutral_state);
  const Tensor residual = generator_.Branches(z, branch_state);
  neutral_carried_ = neutral_state;
  branch_carried_ = branch_state;
  const Tensor own_residual = residual * styled_;
  const Decoded decoded =
      generator_.Decode(torch::cat({r0 + own_residual, r0 + residual - own_residual}, 1),
                        torch::cat({own_one_hot_, target_one_hot_}, 0));
  const Tensor rec = decoded.rotations.narrow(1, 0, slots_);
  const Tensor sty = decoded.rotations.narrow(1, slots_, slots_);
  const Tensor change = Multiply(Conjugate(rec), sty);
  const Tensor judged_rotations =
      config_.judge_published ? Multiply(input_rotations, change) : sty;
  const Tensor positions = HipsRelativePositions(torch::cat({rec, judged_rotations}, 1));
  const Tensor rec_positions = positions.narrow(1, 0, slots_);
  const Tensor sty_positions = positions.narrow(1, slots_, slots_);
  const Tensor lift = LowestFoot(input_positions) - LowestFoot(sty_positions);
  const Tensor hips_step =
      config_.judge_root ? batch.hips_step_m : torch::zeros_like(batch.hips_step_m);
  const Tensor sty_velocities = WorldVelocities(sty_positions, batch.yaw_change_rad, hips_step,
                                                lift, config_.rate_hz);
  const Tensor fake = Judged(sty_positions.narrow(0, 1, judged_frames), sty_velocities);
  Tensor real = u.narrow(0, 1, judged_frames)
                    .narrow(2, body::kPositionBegin, kJudgedFeatures)
                    .contiguous();
  if (!config_.judge_root) {
    real = Judged(input_positions.narrow(0, 1, judged_frames),
                  WorldVelocities(input_positions, batch.yaw_change_rad, hips_step,
                                  torch::zeros_like(lift), config_.rate_hz));
  }
  const double decay =
      progress <= config_.decay_from
          ? 1.0
          : 1.0 + (config_.decay_to - 1.0) *
                      std::min(1.0, (progress - config_.decay_from) / (1.0 - config_.decay_from));

  // 2. Critic: real +1, fake -1, and the gradient penalty on real windows (eq. 5, 6).
  const Tensor real_labels = torch::cat({own_one_hot_, batch.content}, 1);
  const Tensor fake_labels = torch::cat({target_one_hot_, batch.content}, 1);
  {
    const Tensor x = real.detach().requires_grad_(true);
    const Tensor real_score = critic_(x, real_labels);
    const Tensor fake_score = critic_(fake.detach(), fake_labels);
    const Tensor gradient = torch::autograd::grad({real_score.sum()}, {x}, {}, true, true)[0];
    const Tensor penalty = gradient.square().sum(torch::IntArrayRef({0, 2})).mean();
    const Tensor judgement =
        (real_score - 1.0).square().mean() + (fake_score + 1.0).square().mean();
    critic_.parameters.ZeroGradient();
    (judgement + config_.w_penalty * penalty).backward();
    critic_adam_.Step(critic_.parameters, config_.critic_rate * decay);
    tally_.Add("critic", judgement);
    tally_.Add("penalty", config_.w_penalty * penalty);
    tally_.Add("real", real_score.mean());
    tally_.Add("fake", fake_score.mean());
  }

  // 3. Generator.
  RequireGradient(critic_.parameters, false);
  const Tensor rotation = SquaredHalfAngle(rec, input_rotations).sum(torch::IntArrayRef({0, 2})).mean();
  const Tensor position = (rec_positions - input_positions).square().sum(-1).mean();
  const Tensor velocity =
      (decoded.velocities.narrow(1, 0, slots_) -
       u.narrow(2, body::kVelocityBegin, body::kVelocityFeatures))
          .square()
          .mean();
  const Tensor height =
      (decoded.height.narrow(1, 0, slots_) - u.narrow(2, body::kHipsHeightIndex, 1))
          .square()
          .mean();
  const Tensor adversarial = critic_(fake, fake_labels).square().mean();
  Tensor loss = config_.w_rotation * rotation + config_.w_position * position +
                config_.w_velocity * velocity + config_.w_height * height +
                config_.w_adversarial * adversarial;
  if (config_.w_perceptual > 0) {
    const Tensor rotations =
        (ToHemisphere(judged_rotations.narrow(0, 1, judged_frames),
                      mean_.narrow(0, 0, body::kRotationFeatures).view({body::kJointCount, 4}))
             .flatten(2, 3) -
         mean_.narrow(0, 0, body::kRotationFeatures)) /
        deviation_.narrow(0, 0, body::kRotationFeatures);
    std::vector<Tensor> wanted;
    {
      torch::NoGradGuard no_grad;
      wanted = classifier_.Maps(u.narrow(0, 1, judged_frames).narrow(2, 0, kContentFeatures));
    }
    const std::vector<Tensor> maps = classifier_.Maps(torch::cat({rotations, fake}, 2));
    Tensor perceptual = torch::zeros({}, u.options());
    for (std::size_t i = 0; i < maps.size(); ++i) {
      perceptual = perceptual + (maps[i] - wanted[i]).square().mean();
    }
    loss = loss + config_.w_perceptual * perceptual;
    tally_.Add("perceptual", perceptual);
  }
  const Tensor log_change = LogQuaternion(change);
  const Tensor smooth = log_change.diff(2, 0).square().sum(torch::IntArrayRef({0, 2, 3})).mean();
  const double smooth_share =
      std::clamp((progress - config_.smooth_from) /
                     std::max(1e-9, config_.smooth_full - config_.smooth_from),
                 0.0, 1.0);
  loss = loss + config_.w_smooth * smooth_share * smooth;
  generator_.parameters.ZeroGradient();
  loss.backward();
  RequireGradient(critic_.parameters, true);
  generator_adam_.Step(generator_.parameters, config_.generator_rate * decay);
  ++iteration_;
  {
    torch::NoGradGuard no_grad;
    const double keep =
        std::min(config_.ema, (1.0 + static_cast<double>(iteration_)) /
                                  (10.0 + static_cast<double>(iteration_)));
    average_.parameters.flat().lerp_(generator_.parameters.flat(), 1.0 - keep);
  }
  tally_.Add("rec_rad", (rotation / (frames_ * body::kJointCount)).sqrt() * 2.0);
  tally_.Add("rec_m", position.sqrt());
  tally_.Add("velocity", velocity);
  tally_.Add("height", height);
  tally_.Add("adversarial", adversarial);
  tally_.Add("smooth", smooth);
  tally_.Add("change_rad", log_change.detach().square().sum(-1).sqrt().mean());
  tally_.Add("loss", loss);
}

double Trainer::Progress() const {
  double progress = 0;
  if (config_.iterations > 0) {
    progress = static_cast<double>(iteration_) / static_cast<double>(config_.iterations);
  }
  if (config_.minutes > 0) progress = std::max(progress, Elapsed() / (60.0 * config_.minutes));
  return progress;
}

void Trainer::Log(int count, double seconds, double progress) {
  const auto means = tally_.Take(count);
  const std::filesystem::path file = config_.out / "log.csv";
  const bool fresh = !std::filesystem::exists(file);
  std::ofstream csv(file, std::ios::app);
  if (fresh) {
    csv << "iteration,elapsed_s,progress";
    for (const auto& [name, mean] : means) csv << ',' << name;
    csv << '\n';
  }
  csv << iteration_ << ',' << Elapsed() << ',' << progress;
  std::cout << iteration_ << ": ";
  for (const auto& [name, mean] : means) {
    csv << ',' << mean;
    std::cout << name << ' ' << mean << "  ";
  }
  csv << '\n';
  const double remaining_s = progress > 0 ? Elapsed() * (1.0 - progress) / progress : 0;
  std::cout << "| " << count / seconds << " it/s, " << static_cast<int>(remaining_s / 60)
            << " min left" << std::endl;
}

void Trainer::LogMonitor() {
  const MonitorRow row = monitor_.Evaluate(average_);
  const std::filesystem::path file = config_.out / "monitor.csv";
  const bool fresh = !std::filesystem::exists(file);
  std::ofstream csv(file, std::ios::app);
  if (fresh) {
    csv << "iteration,elapsed_s,reconstruction_deg";
    for (const std::string figure : {"expression", "cosine", "jerk_ratio"}) {
      for (std::size_t s = 1; s < manifest_.styles.size(); ++s) {
        csv << ',' << figure << '_' << manifest_.styles[s].name;
      }
    }
    csv << '\n';
  }
  csv << iteration_ << ',' << Elapsed() << ',' << row.reconstruction_deg;
  std::cout << "monitor " << iteration_ << ": rec " << row.reconstruction_deg << " deg";
  for (const auto& values : {row.expression, row.cosine, row.jerk_ratio}) {
    std::cout << " |";
    for (const double value : values) {
      csv << ',' << value;
      std::cout << ' ' << std::round(value * 100) / 100;
    }
  }
  csv << '\n';
  std::cout << std::endl;
}

std::string Trainer::Metadata() const {
  WeightsMetadata metadata;
  for (const clip::ManifestStyle& style : manifest_.styles) {
    metadata.styles.emplace_back(style.name, style.aliases);
  }
  metadata.rate_hz = config_.rate_hz;
  metadata.heading_tau_s = config_.heading_tau_s;
  metadata.licence = manifest_.licence;
  metadata.training = nlohmann::json{{"command", config_.command},
                                     {"data", manifest_.name},
                                     {"seed", config_.seed},
                                     {"iterations", iteration_},
                                     {"wall_time_s", std::round(Elapsed())}}
                          .dump();
  return metadata.ToJson(generator_.shape);
}

Status Trainer::Save() {
  Checkpoint checkpoint;
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
  t["iteration"] = torch::tensor({iteration_}, torch::kInt64);
  t["elapsed_s"] = torch::tensor({Elapsed()}, torch::kFloat64);
  t["neutral.h"] = torch::stack(neutral_carried_.h);
  t["neutral.c"] = torch::stack(neutral_carried_.c);
  t["branches.h"] = torch::stack(branch_carried_.h);
  t["branches.c"] = torch::stack(branch_carried_.c);
  checkpoint.strings["sampler"] = sampler_.Save();
  checkpoint.strings["metadata"] = Metadata();
  const Status written = WriteCheckpoint(checkpoint, config_.out / "checkpoint.pt");
  if (!written.ok()) return written;
  return WriteWeights(average_, mean_, deviation_, Metadata(), config_.out / "weights.safetensors");
}

Status Trainer::Restore() {
  Checkpoint checkpoint;
  const std::filesystem::path file = config_.out / "checkpoint.pt";
  const Status read = ReadCheckpoint(file, checkpoint);
  if (!read.ok()) return read;
  torch::NoGradGuard no_grad;
  try {
    auto& t = checkpoint.tensors;
    if (!torch::equal(t.at("mean"), mean_.cpu()) ||
        !torch::equal(t.at("deviation"), deviation_.cpu())) {
      return Status::Error(file.string() + ": was made with other data or another rate");
    }
    generator_.parameters.flat().copy_(t.at("generator"));
    average_.parameters.flat().copy_(t.at("average"));
    critic_.parameters.flat().copy_(t.at("critic"));
    classifier_.parameters.flat().copy_(t.at("classifier"));
    generator_adam_.first.copy_(t.at("generator.first"));
    generator_adam_.second.copy_(t.at("generator.second"));
    critic_adam_.first.copy_(t.at("critic.first"));
    critic_adam_.second.copy_(t.at("critic.second"));
    iteration_ = t.at("iteration").item<int64_t>();
    generator_adam_.steps = critic_adam_.steps = iteration_;
    elapsed_before_s_ = t.at("elapsed_s").item<double>();
    const auto unstack = [this](const Tensor& all, std::vector<Tensor>& layers) {
      TORCH_CHECK(all.size(0) == static_cast<int64_t>(layers.size()) &&
                      all[0].sizes() == layers[0].sizes(),
                  "carried states of another batch");
      for (std::size_t i = 0; i < layers.size(); ++i) {
        layers[i] = all[static_cast<int64_t>(i)].clone().to(device_);
      }
    };
    unstack(t.at("neutral.h"), neutral_carried_.h);
    unstack(t.at("neutral.c"), neutral_carried_.c);
    unstack(t.at("branches.h"), branch_carried_.h);
    unstack(t.at("branches.c"), branch_carried_.c);
    sampler_.Restore(checkpoint.strings.at("sampler"));
  } catch (const std::exception& error) {
    return Status::Error(file.string() + ": " + Reason(error));
  }
  RequireGradient(classifier_.parameters, false);
  return Status::Ok();
}

Status Trainer::Run() {
  started_ = Clock::now();
  auto last_log = Clock::now();
  auto last_save = Clock::now();
  int logged = 0;
  for (;;) {
    const double progress = Progress();
    if (progress >= 1.0 || (config_.stop_at > 0 && iteration_ >= config_.stop_at)) break;
    Step(progress);
    ++logged;
    if (iteration_ % config_.log_every == 0) {
      Log(logged, SecondsSince(last_log), progress);
      logged = 0;
      last_log = Clock::now();
      if (!std::isfinite(generator_.parameters.flat().sum().item<double>())) {
        return Status::Error("iteration " + std::to_string(iteration_) +
                             ": a weight is no longer finite; the last checkpoint is kept");
      }
    }
    if (iteration_ % config_.monitor_every == 0) LogMonitor();
    if (SecondsSince(last_save) > 60.0 * config_.checkpoint_minutes) {
      const Status saved = Save();
      if (!saved.ok()) return saved;
      last_save = Clock::now();
    }
  }
  if (iteration_ % config_.monitor_every != 0) LogMonitor();
  return Save();
}

}  // namespace

Status Train(const TrainConfig& config) {
  // 1. What cannot work is refused before anything is read.
  if (config.minutes <= 0 && config.iterations <= 0) {
    return Status::Error("give --minutes or --iterations");
  }
  if (config.window < 4 || config.per_style < 1 || config.rate_hz <= 0) {
    return Status::Error("--window must be at least 4, --per-style 1, --rate above 0");
  }
  const Status folder = CheckDataFolder(config.data);
  if (!folder.ok()) return folder;
  const bool cuda = config.device == "cuda" || (config.device == "auto" && torch::cuda::is_available());
  if (cuda && !torch::cuda::is_available()) {
    return Status::Error("--device cuda: this libtorch sees no CUDA device");
  }
  std::error_code error;
  std::filesystem::create_directories(config.out, error);
  if (error) return Status::Error("--out " + config.out.string() + ": " + error.message());

  // 2. Data.
  Result<clip::Manifest> manifest = clip::LoadManifest(config.manifest, config.data);
  if (!manifest.ok()) return manifest.status();
  body::FeatureParameters parameters;
  parameters.rate_hz = static_cast<float>(config.rate_hz);
  parameters.heading_tau_s = static_cast<float>(config.heading_tau_s);
  const auto begin = Clock::now();
  Result<std::vector<TrainingClip>> clips =
      LoadClips(manifest.value(), "train", parameters, config.window + 1);
  if (!clips.ok()) return clips.status();
  Result<std::vector<TrainingClip>> validation =
      LoadClips(manifest.value(), "validation", parameters, config.window + 1);
  if (!validation.ok()) return validation.status();
  const FeatureStatistics statistics = ComputeStatistics(clips.value(), parameters);
  SetHemisphere(statistics.mean, parameters);
  std::cout << clips.value().size() << " training clips, " << validation.value().size()
            << " validation clips, " << SecondsSince(begin) << " s" << std::endl;

  // 3. Train.
  try {
    at::set_num_threads(config.threads);
    torch::manual_seed(config.seed);
    Trainer trainer(config, manifest.value(), clips.value(), validation.value(), statistics,
                    parameters, cuda ? torch::Device(torch::kCUDA) : torch::Device(torch::kCPU));
    if (config.resume) {
      const Status restored = trainer.Restore();
      if (!restored.ok()) return restored;
    } else {
      trainer.TrainClassifier();
    }
    return trainer.Run();
  } catch (const std::exception& failure) {
    return Status::Error(std::string("libtorch: ") + Reason(failure));
  }
}

Status ExportRun(const std::filesystem::path& run, const std::filesystem::path& file) {
  Checkpoint checkpoint;
  const std::filesystem::path source = run / "checkpoint.pt";
  const Status read = ReadCheckpoint(source, checkpoint);
  if (!read.ok()) return read;
  try {
    const std::string& metadata = checkpoint.strings.at("metadata");
    const Result<GeneratorShape> shape = ShapeFromJson(metadata);
    if (!shape.ok()) return shape.status();
    const Tensor& mean = checkpoint.tensors.at("mean");
    const Tensor& deviation = checkpoint.tensors.at("deviation");
    Generator generator(shape.value(), mean, deviation);
    torch::NoGradGuard no_grad;
    generator.parameters.flat().copy_(checkpoint.tensors.at("average"));
    return WriteWeights(generator, mean, deviation, metadata, file);
  } catch (const std::exception& failure) {
    return Status::Error(source.string() + ": " + Reason(failure));
  }
}

}  // namespace styled::train
