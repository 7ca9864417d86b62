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

Tensor Indices(const std::vector<int64_t>& values, const torch::Device& device) {
  return torch::tensor(values, torch::kInt64).to(device);
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

void Means::Add(const std::string& name, const Tensor& value) {
  for (Sum& one : sums_) {
    if (one.name != name) continue;
    one.sum += value.detach();
    ++one.count;
    return;
  }
  sums_.push_back({name, value.detach().clone(), 1});
}

Figures Means::Pop() {
  Figures figures;
  for (const Sum& one : sums_) figures.emplace_back(one.name, one.sum.item<double>() / one.count);
  sums_.clear();
  return figures;
}

void DiversityWeight::Observe(double distance_cm) {
  if (target_cm_ <= 0) return;
  const double error = std::clamp((target_cm_ - distance_cm) / target_cm_, -1.0, 1.0);
  weight_ = std::clamp(weight_ * std::exp(kSteering * error), kLeastWeight, kMostWeight);
}

Learner::Learner(const Config& config, uint64_t seed, const WindowStore& store,
                 const Statistics& statistics, int domains, const std::vector<bool>& single_act,
                 const torch::Device& device)
    : config_(config),
      seed_(seed),
      device_(device),
      store_(store),
      kinematics_(statistics, device),
      graph_(device, TypeOf(config.precision, device)),
      exact_graph_(device, torch::kFloat32),
      postures_(store, domains, single_act),
      sampler_(store, {.domains = domains,
                       .contents = static_cast<int>(single_act.size()),
                       .shared_contents = config.shared_contents,
                       .unpaired = config.unpaired,
                       .mirror = config.mirror,
                       .seed = seed}),
      networks_(ShapeOf(config, domains), device, config.scaled_heads),
      average_(ShapeOf(config, domains), device, config.scaled_heads),
      critic_(ShapeOf(config, domains),
              config.content_critic ? static_cast<int64_t>(single_act.size()) : 0, device,
              config.scaled_heads ? kLogitScale : 1.0),
      generator_adam_(networks_.generator.parameters, config.beta1, config.beta2),
      encoder_adam_(networks_.encoder.parameters, config.beta1, config.beta2),
      mapping_adam_(networks_.mapping.parameters, config.beta1, config.beta2),
      critic_adam_(critic_.parameters, config.beta1, config.beta2),
      diversity_{DiversityWeight(config.w_diversity, config.diversity_target_cm),
                 DiversityWeight(config.w_diversity, config.diversity_target_cm)} {
  auto from = networks_.parts();
  auto to = average_.parts();
  for (std::size_t i = 0; i < from.size(); ++i) {
    to[i].second->RequireGradient(false);
    to[i].second->flat().copy_(from[i].second->flat());
  }
}

Learner::Batch Learner::NextBatch() {
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
  const std::vector<Tensor> parts = store_.Read(windows).to(device_).chunk(4, 0);
  Batch batch{.source = parts[0],
              .same_clip = parts[1],
              .reference1 = parts[2],
              .reference2 = parts[3],
              .domain = Indices(domain, device_),
              .target = Indices(target, device_),
              .content = Indices(content, device_),
              .paired = torch::tensor(paired).to(device_),
              .wanted = {},
              .has_wanted = {}};
  if (config_.w_posture > 0) AddWanted(samples, batch);
  return batch;
}

void Learner::AddWanted(const std::vector<Sample>& samples, Batch& batch) const {
  std::vector<float> has_wanted;
  std::vector<Tensor> shifts;
  for (const Sample& sample : samples) {
    Tensor shift = torch::zeros({body::kJointCount, stgcn::kChannels});
    has_wanted.push_back(postures_.Wanted(sample, shift) ? 1.0F : 0.0F);
    shifts.push_back(shift);
  }
  batch.wanted = batch.source.mean(1) + torch::stack(shifts).to(device_);
  batch.has_wanted = torch::tensor(has_wanted).to(device_);
}

// Seeded by the iteration, so that a resumed run draws the same.
Tensor Learner::Noise(int64_t stream) const {
  const uint64_t seed =
      (seed_ * 1000003 + static_cast<uint64_t>(iteration_)) * 2 + static_cast<uint64_t>(stream);
  const at::Generator random = at::detail::createCPUGenerator(seed);
  return torch::randn({config_.batch, networks_.generator.shape.noise}, random).to(device_);
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
    made.target_code = n.mapping(Noise(0), batch.target);
    const torch::NoGradGuard no_grad;
    other_code = n.mapping(Noise(1), batch.target);
  }
  // The content is encoded once for all codes.
  const Tensor content = n.generator.Encode(graph_, batch.source);
  const Tensor both = n.generator.Decode(graph_, torch::cat({content, content}),
                                         torch::cat({made.own_code, made.target_code}));
  made.reconstruction = both.narrow(0, 0, config_.batch);
  made.raw = both.narrow(0, config_.batch, config_.batch);
  made.fake = kinematics_.Published(made.raw);
  const torch::NoGradGuard no_grad;
  made.other_fake = kinematics_.Published(n.generator.Decode(graph_, content, other_code));
  return made;
}

void Learner::StepAdam(Parameters& parameters, AdamWithDecay& adam, double rate) const {
  adam.Step(parameters, rate, config_.weight_decay);
}

void Learner::StepWarmUp(const Batch& batch) {
  Networks& n = networks_;
  const Tensor own = config_.same_clip ? batch.same_clip : batch.source;
  const Tensor features = n.encoder.Features(graph_, own);
  const Tensor code = n.encoder.Code(features, batch.domain);
  const Tensor decoded = n.generator.Decode(graph_, n.generator.Encode(graph_, batch.source), code);
  const Tensor identity = JointNorm(decoded - batch.source);
  const Tensor fk = (decoded - kinematics_.Published(decoded)).abs().mean();
  n.generator.parameters.ZeroGradient();
  n.encoder.parameters.ZeroGradient();
  Tensor loss = identity + config_.w_fk * fk + config_.w_free * FreeLoss(features, code);
  if (config_.w_read > 0) loss = loss + ReadPosture(batch);
  loss.backward();
  StepAdam(n.generator.parameters, generator_adam_, config_.warm_up_rate);
  StepAdam(n.encoder.parameters, encoder_adam_, config_.warm_up_rate);
  means_.Add("identity", identity);
}

void Learner::StepTurn(const Batch& batch, Turn turn, double decay) {
  const Made made = Make(batch, turn);
  StepCritic(batch, made.fake, decay);
  StepGenerator(batch, made, turn, decay);
}

void Learner::Step(double progress) {
  const Batch batch = NextBatch();
  const double left = 1.0 - std::clamp(progress, 0.0, 1.0);
  const double decay = config_.decay_to + (1.0 - config_.decay_to) * left * left;
  if (iteration_ < config_.warm_up) {
    StepWarmUp(batch);
  } else if (!config_.both_turns) {
    StepTurn(batch, iteration_ % 2 == 0 ? Turn::kNoise : Turn::kReferences, decay);
  } else {  // as in the authors' code: first the critic on both
    for (const Turn turn : {Turn::kNoise, Turn::kReferences}) {
      const Tensor fake = [&] {
        const torch::NoGradGuard no_grad;
        return Make(batch, turn).fake;
      }();
      StepCritic(batch, fake, decay);
    }
    for (const Turn turn : {Turn::kNoise, Turn::kReferences}) {
      StepGenerator(batch, Make(batch, turn), turn, decay);
    }
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
