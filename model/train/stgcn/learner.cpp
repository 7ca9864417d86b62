#include "model/train/stgcn/learner.h"

#include <ATen/CPUGeneratorImpl.h>

#include <algorithm>
#include <cmath>

#include "model/train/stgcn/losses.h"

namespace styled::train::st_gcn {
namespace {

using torch::Tensor;

// First outputs of the last layers, over He's: with those the critic's logits are ±12 at once, and
// the generator never learns to reconstruct.
constexpr double kOutScale = 0.2, kCodeScale = 0.3, kLogitScale = 0.1;

// A turn changes the logarithm of the weight by this times the relative error: a lack of all
// variety triples it in 300 turns, a lack of a tenth in 3,000.
constexpr double kSteering = 0.004;
// Larger: the term outweighs the critic; smaller: it does not come back when it is needed.
constexpr double kLeastWeight = 0.1, kMostWeight = 5.0;

Shape ShapeOf(const Config& config, int domains) {
  Shape shape;
  shape.domains = domains;
  shape.width = config.width;
  shape.node_bias = config.node_bias;
  return shape;
}

stgcn::Normalization NormalizationOf(const Config& config) {
  return config.normalization == "subset" ? stgcn::Normalization::kSubset
                                          : stgcn::Normalization::kNeighbours;
}

}  // namespace

torch::Dtype TypeOf(const std::string& precision, const torch::Device& device) {
  if (precision == "fp32") return torch::kFloat32;
  if (precision == "bf16" || device.is_cuda()) return torch::kBFloat16;
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx512bf16")) return torch::kBFloat16;
#endif
  return torch::kFloat32;
}

Networks::Networks(const Shape& shape, const torch::Device& device, bool scaled_heads)
    : generator(shape, device, scaled_heads ? kOutScale : 1.0),
      encoder(shape, device, scaled_heads ? kCodeScale : 1.0),
      mapping(shape, device) {}

DiversityWeight::DiversityWeight(double start, double target_cm, const torch::Device& device)
    : target_cm_(target_cm),
      weight_(
          torch::full({}, start, torch::TensorOptions().dtype(torch::kFloat32).device(device))) {}

Tensor DiversityWeight::Observe(const Tensor& distance_cm) {
  const torch::NoGradGuard no_grad;
  Tensor before = weight_.clone();
  if (target_cm_ <= 0) return before;
  const Tensor error = ((target_cm_ - distance_cm.detach()) / target_cm_).clamp(-1.0, 1.0);
  weight_.mul_((kSteering * error).exp()).clamp_(kLeastWeight, kMostWeight);
  return before;
}

Learner::Learner(const Config& config, uint64_t seed, const WindowStore& store,
                 const Statistics& statistics, int domains, const std::vector<bool>& single_act,
                 const torch::Device& device)
    : config_(config),
      seed_(seed),
      device_(device),
      store_(store),
      kinematics_(statistics, device),
      graph_(device, TypeOf(config.precision, device), NormalizationOf(config)),
      exact_graph_(device, torch::kFloat32, NormalizationOf(config)),
      postures_(store, domains, single_act),
      sampler_(store, {.domains = domains,
                       .contents = static_cast<int>(single_act.size()),
                       .shared_contents = config.shared_contents,
                       .even_contents = config.even_contents,
                       .unpaired = config.unpaired,
                       .mirror = config.mirror,
                       .seed = seed}),
      networks_(ShapeOf(config, domains), device, config.scaled_heads),
      average_(ShapeOf(config, domains), device, config.scaled_heads),
      critic_(ShapeOf(config, domains),
              config.content_critic ? static_cast<int64_t>(single_act.size()) : 0, device,
              config.scaled_heads ? kLogitScale : 1.0, config.critic_layer),
      generator_adam_(networks_.generator.parameters, config.beta1, config.beta2),
      encoder_adam_(networks_.encoder.parameters, config.beta1, config.beta2),
      mapping_adam_(networks_.mapping.parameters, config.beta1, config.beta2),
      critic_adam_(critic_.parameters, config.beta1, config.beta2),
      diversity_{DiversityWeight(config.w_diversity, config.diversity_target_cm, device),
                 DiversityWeight(config.w_diversity, config.diversity_target_cm, device)},
      records_(device.is_cuda()),
      batches_(!device.is_cpu(), [this](int64_t iteration) { return MakeBatch(iteration); }) {
  auto from = networks_.parts();
  auto to = average_.parts();
  for (std::size_t i = 0; i < from.size(); ++i) {
    to[i].second->RequireGradient(false);
    to[i].second->flat().copy_(from[i].second->flat());
  }
  if (!records_) return;
  UseRecordableStream();
  means_.KeepSums();
}

// In memory of the CPU; it may run in another thread (OneAhead).
OneAhead<Learner::Batch>::Made Learner::MakeBatch(int64_t iteration) {
  const torch::NoGradGuard no_grad;
  const std::vector<Sample> samples = sampler_.Next(config_.batch);
  std::vector<Window> windows;
  for (const auto of :
       {&Sample::source, &Sample::same_clip, &Sample::reference1, &Sample::reference2}) {
    for (const Sample& sample : samples) windows.push_back(sample.*of);
  }
  std::vector<int64_t> domain, target, content;
  std::vector<float> paired;
  for (const Sample& sample : samples) {
    domain.push_back(sample.domain);
    target.push_back(sample.target);
    content.push_back(sample.content);
    paired.push_back(sample.paired ? 1.0F : 0.0F);
  }
  const std::vector<Tensor> parts = store_.Read(windows).chunk(4, 0);
  Batch batch;
  batch.source = parts[0];
  batch.same_clip = parts[1];
  batch.reference1 = parts[2];
  batch.reference2 = parts[3];
  batch.domain = torch::tensor(domain, torch::kInt64);
  batch.target = torch::tensor(target, torch::kInt64);
  batch.content = torch::tensor(content, torch::kInt64);
  batch.paired = torch::tensor(paired);
  batch.noise = Noise(iteration, 0);
  batch.other_noise = Noise(iteration, 1);
  if (config_.w_posture > 0) AddWanted(samples, batch);
  if (config_.w_read > 0) AddReadShifts(iteration, batch);
  if (device_.is_cuda()) PinMemory(batch.all());
  return {std::move(batch), sampler_.Save()};
}

const Learner::Batch& Learner::NextBatch() {
  Batch next = batches_.Next(iteration_);
  if (device_.is_cpu()) {
    batch_ = std::move(next);
    return batch_;
  }
  CopyToDevice(next.all(), device_, batch_.all());
  return batch_;
}

void Learner::AddWanted(const std::vector<Sample>& samples, Batch& batch) const {
  std::vector<float> has_wanted;
  std::vector<Tensor> shifts;
  for (const Sample& sample : samples) {
    Tensor shift = torch::zeros({body::kJointCount, stgcn::kChannels});
    has_wanted.push_back(postures_.Wanted(sample, shift) ? 1.0F : 0.0F);
    shifts.push_back(shift);
  }
  batch.wanted = batch.source.mean(1) + torch::stack(shifts);
  batch.has_wanted = torch::tensor(has_wanted);
}

// Half of the sources are shifted differently from the target, so that their own posture does
// not reveal it.
void Learner::AddReadShifts(int64_t iteration, Batch& batch) const {
  // Seeded by the iteration, so that a resumed run draws the same.
  std::mt19937_64 random(seed_ * 1000003 + static_cast<uint64_t>(iteration));
  std::vector<Tensor> wanted, source;
  for (int i = 0; i < config_.batch; ++i) {
    wanted.push_back(postures_.Draw(random));
    source.push_back(i % 2 == 0 ? postures_.Draw(random) : torch::zeros_like(wanted.back()));
  }
  batch.read_wanted = torch::stack(wanted).unsqueeze(1);
  batch.read_source = torch::stack(source).unsqueeze(1);
}

// Seeded by the iteration, so that a resumed run draws the same.
Tensor Learner::Noise(int64_t iteration, int64_t stream) const {
  const uint64_t seed =
      (seed_ * 1000003 + static_cast<uint64_t>(iteration)) * 2 + static_cast<uint64_t>(stream);
  const at::Generator random = at::detail::createCPUGenerator(seed);
  return torch::randn({config_.batch, networks_.generator.shape.noise}, random);
}

Tensor Learner::FreeLoss(const Tensor& features, const Tensor& code) const {
  const Tensor seen = config_.free_head_teaches ? features : features.detach();
  return (networks_.encoder.FreeCode(seen) - code.detach()).abs().mean();
}

Learner::Made Learner::Make(const Batch& batch, Turn turn) {
  Networks& n = networks_;
  Made made;
  const Tensor own = config_.same_clip ? batch.same_clip : batch.source;
  Tensor other_code;
  Tensor windows = own, domains = batch.domain;
  if (turn == Turn::kReferences) {
    windows = torch::cat({own, batch.reference1, batch.reference2});
    domains = torch::cat({batch.domain, batch.target, batch.target});
  }
  const Tensor features = n.encoder.Features(graph_, windows);
  const Tensor codes = n.encoder.Code(features, domains);
  made.free_loss = FreeLoss(features, codes);
  made.own_code = codes.narrow(0, 0, config_.batch);
  if (turn == Turn::kReferences) {
    made.target_code = codes.narrow(0, config_.batch, config_.batch);
    other_code = codes.narrow(0, 2 * config_.batch, config_.batch).detach();
  } else {
    made.target_code = n.mapping(batch.noise, batch.target);
    const torch::NoGradGuard no_grad;
    other_code = n.mapping(batch.other_noise, batch.target);
  }
  // The content is encoded once for all codes.
  const Tensor content = n.generator.Encode(graph_, batch.source);
  const Tensor both = n.generator.Decode(graph_, torch::cat({content, content}),
                                         torch::cat({made.own_code, made.target_code}));
  made.reconstruction = both.narrow(0, 0, config_.batch);
  made.raw = both.narrow(0, config_.batch, config_.batch);
  made.fake = Judged(made.raw);
  const torch::NoGradGuard no_grad;
  made.other_fake = Judged(n.generator.Decode(graph_, content, other_code));
  return made;
}

void Learner::StepAdam(Parameters& parameters, AdamWithDecay& adam, double rate) const {
  adam.Step(parameters, rate, config_.weight_decay);
}

void Learner::Run(RecordedWork& recorded, const std::function<void()>& work) {
  if (records_) {
    recorded.Run(means_, work);
  } else {
    work();
  }
}

void Learner::StepWarmUp(const Batch& batch) {
  Networks& n = networks_;
  Run(warm_up_, [&] {
    const Tensor own = config_.same_clip ? batch.same_clip : batch.source;
    const Tensor features = n.encoder.Features(graph_, own);
    const Tensor code = n.encoder.Code(features, batch.domain);
    const Tensor decoded =
        n.generator.Decode(graph_, n.generator.Encode(graph_, batch.source), code);
    const Tensor identity = JointNorm(decoded - batch.source);
    const Tensor fk = (decoded - kinematics_.Published(decoded)).abs().mean();
    n.generator.parameters.ZeroGradient();
    n.encoder.parameters.ZeroGradient();
    Tensor loss = identity + config_.w_fk * fk + config_.w_free * FreeLoss(features, code);
    if (config_.w_read > 0) loss = loss + ReadPosture(batch);
    loss.backward();
    means_.Add("identity", identity);
  });
  StepAdam(n.generator.parameters, generator_adam_, config_.warm_up_rate);
  StepAdam(n.encoder.parameters, encoder_adam_, config_.warm_up_rate);
}

bool Learner::Penalized() const {
  return config_.w_penalty > 0 && iteration_ % config_.penalty_every == 0;
}

// The critic and the generator's losses see one output.
void Learner::StepTurn(const Batch& batch, Turn turn, double decay) {
  RecordedTurn& t = turns_[static_cast<std::size_t>(turn)][Penalized() ? 1 : 0];
  Run(t.critic, [&] {
    t.made = Make(batch, turn);
    TeachCritic(batch, t.made.fake);
  });
  StepCritic(decay);
  Run(t.generator, [&] { TeachGenerator(batch, t.made, turn); });
  StepGenerator(turn, decay);
  if (!records_) t.made = {};  // a recording reads it again
}

// As in the authors' code: first the critic on both.
void Learner::StepBothTurns(const Batch& batch, double decay) {
  const auto recorded = [this](Turn turn) -> RecordedTurn& {
    return turns_[static_cast<std::size_t>(turn)][Penalized() ? 1 : 0];
  };
  for (const Turn turn : {Turn::kNoise, Turn::kReferences}) {
    Run(recorded(turn).critic, [&] {
      const Tensor fake = [&] {
        const torch::NoGradGuard no_grad;
        return Make(batch, turn).fake;
      }();
      TeachCritic(batch, fake);
    });
    StepCritic(decay);
  }
  for (const Turn turn : {Turn::kNoise, Turn::kReferences}) {
    Run(recorded(turn).generator, [&] { TeachGenerator(batch, Make(batch, turn), turn); });
    StepGenerator(turn, decay);
  }
}

void Learner::Step(double progress) {
  const Batch& batch = NextBatch();
  const double left = 1.0 - std::clamp(progress, 0.0, 1.0);
  const double decay = config_.decay_to + (1.0 - config_.decay_to) * left * left;
  if (iteration_ < config_.warm_up) {
    StepWarmUp(batch);
  } else if (!config_.both_turns) {
    StepTurn(batch, iteration_ % 2 == 0 ? Turn::kNoise : Turn::kReferences, decay);
  } else {
    StepBothTurns(batch, decay);
  }
  ++iteration_;
  UpdateAverage();
}

void Learner::UpdateAverage() {
  const torch::NoGradGuard no_grad;
  const auto n = static_cast<double>(iteration_);
  const double keep = std::min(config_.ema, (1.0 + n) / (50.0 + n));
  auto from = networks_.parts();
  auto to = average_.parts();
  for (std::size_t i = 0; i < from.size(); ++i) {
    to[i].second->flat().lerp_(from[i].second->flat(), 1.0 - keep);
  }
}

bool Learner::Finite() const {
  for (const Parameters* one : {&networks_.generator.parameters, &networks_.encoder.parameters,
                                &networks_.mapping.parameters, &critic_.parameters}) {
    if (!torch::isfinite(one->flat()).all().item<bool>()) return false;
  }
  return true;
}

}  // namespace styled::train::st_gcn
