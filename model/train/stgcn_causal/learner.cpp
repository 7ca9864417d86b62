#include "model/train/stgcn_causal/learner.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <utility>

#include "model/net/styles.h"

namespace styled::train::st_gcn_causal {
namespace {

using st_gcn::kWindowFrames;
using torch::Tensor;

void RestoreFlat(const Tensor& from, Parameters& to) {
  TORCH_CHECK(from.sizes() == to.flat().sizes(), "is of another width");
  to.flat().copy_(from);
}

}  // namespace

Teacher::Teacher(const st_gcn::Generator& generator, const Tensor& codes, const Tensor& singles,
                 const torch::Device& device)
    : graph_(device, torch::kFloat32),
      generator_(generator.shape, device),
      codes_(codes.to(device)),
      singles_(singles.to(device)) {
  const torch::NoGradGuard no_grad;
  generator_.parameters.RequireGradient(false);
  generator_.parameters.flat().copy_(generator.parameters.flat());
}

Tensor Teacher::operator()(const Tensor& windows, const Tensor& code) const {
  const torch::NoGradGuard no_grad;
  const Tensor content = generator_.Encode(graph_, windows);
  return generator_.Decode(graph_, content.repeat({code.size(0) / windows.size(0), 1, 1, 1}), code);
}

Tensor Teacher::CodeOf(const Tensor& style) const { return codes_.index_select(0, style); }

Tensor WeightedL1(const Tensor& difference, double first) {
  Tensor weight = torch::ones({difference.size(1)});
  weight.narrow(0, 0, std::min(kFirst, difference.size(1))).fill_(first);
  return torch::dot(difference.abs().mean({0, 2, 3}),
                    (weight / weight.sum()).to(difference.device()));
}

Learner::Learner(const Config& config, uint64_t seed, const st_gcn::WindowStore& store,
                 std::vector<int64_t> styles, int contents, const Teacher& teacher,
                 const PublishedForm& form, double rate_hz, const torch::Device& device)
    : config_(config),
      seed_(seed),
      device_(device),
      store_(store),
      styles_(std::move(styles)),
      teacher_(teacher),
      form_(form),
      lead_frames_(config.lead_s * rate_hz),
      graph_(device, st_gcn::TypeOf(config.precision, device), kWindowFrames),
      exact_graph_(device, torch::kFloat32, kWindowFrames),
      sampler_(store, {.domains = static_cast<int>(styles_.size()),
                       .contents = contents,
                       .unpaired = config.unpaired,
                       .neutral = config.neutral,
                       .mirror = config.mirror,
                       .seed = seed}),
      student_(teacher.generator().shape, device),
      average_(teacher.generator().shape, device),
      adam_(student_.parameters, config.beta1, config.beta2) {
  average_.parameters.RequireGradient(false);
}

void Learner::Start() {
  const torch::NoGradGuard no_grad;
  student_.CopyFrom(teacher_.generator());
  const auto observe = [this](bool on) {
    for (PastNorm* norm : student_.norms()) norm->Observe(on);
  };
  observe(true);
  for (int done = 0; done < config_.start_windows; done += config_.batch) {
    const Batch batch = NextBatch();
    const Tensor content = student_.Encode(exact_graph_, batch.source);
    student_.Decode(exact_graph_, torch::cat({content, content}), batch.code);
  }
  observe(false);
  average_.parameters.flat().copy_(student_.parameters.flat());
}

// Seeded by the iteration, so that a resumed run draws the same.
std::vector<Learner::Target> Learner::DrawTargets() const {
  std::mt19937_64 random(seed_ * 1000003 + static_cast<uint64_t>(iteration_));
  const auto uniform = [&random] { return static_cast<double>(random() >> 11) * 0x1p-53; };
  std::vector<Target> targets;
  for (int i = 0; i < config_.batch; ++i) {
    const bool varied = uniform() < config_.varied;
    const double drawn = net::kMaxStrength * uniform();
    const bool single = uniform() < config_.single;
    const auto which = static_cast<int64_t>(uniform() * config_.single_codes);
    targets.push_back({varied ? static_cast<float>(drawn) : 1.0F, single ? which : -1});
  }
  return targets;
}

Learner::Batch Learner::NextBatch() {
  const std::vector<st_gcn::Sample> samples = sampler_.Next(config_.batch);
  std::vector<st_gcn::Window> windows;
  std::vector<int64_t> domain, target;
  for (const st_gcn::Sample& sample : samples) {
    windows.push_back(sample.source);
    domain.push_back(styles_[static_cast<std::size_t>(sample.domain)]);
    target.push_back(styles_[static_cast<std::size_t>(sample.target)]);
  }
  const auto code_of = [this](const std::vector<int64_t>& style) {
    return teacher_.CodeOf(torch::tensor(style, torch::kInt64).to(device_));
  };
  const Tensor neutral = teacher_.codes()[0];
  const std::vector<Target> drawn = DrawTargets();
  std::vector<Tensor> wanted;
  for (std::size_t i = 0; i < drawn.size(); ++i) {
    const Tensor code = drawn[i].single < 0 ? teacher_.codes()[target[i]]
                                            : teacher_.singles()[target[i]][drawn[i].single];
    wanted.push_back(neutral + drawn[i].strength * (code - neutral));
  }
  return {.source = store_.Read(windows).to(device_),
          .code = torch::cat({code_of(domain), torch::stack(wanted)})};
}

Tensor Learner::Wanted(const Batch& batch) const {
  const Tensor made = teacher_(batch.source, batch.code);
  if (lead_frames_ == 0 && config_.gain == 1) return made;
  const torch::NoGradGuard no_grad;
  const std::vector<Tensor> both = made.to(torch::kCPU).chunk(2, 0);
  return torch::cat({both[0], form_.Later(both[0], both[1], lead_frames_, config_.gain)})
      .to(device_);
}

void Learner::Step(double progress) {
  const Batch batch = NextBatch();
  // The last frames of a window have no later change.
  const auto known = kWindowFrames - static_cast<int64_t>(std::ceil(lead_frames_));
  const Tensor wanted = Wanted(batch);
  // The content is encoded once for both codes.
  const Tensor content = student_.Encode(graph_, batch.source);
  const Tensor made = student_.Decode(graph_, torch::cat({content, content}), batch.code);
  const Tensor off = (made - wanted).narrow(1, 0, known);
  Tensor loss = torch::zeros({}, off.options().requires_grad(false));
  if (config_.w_smooth > 0) {
    const std::vector<Tensor> two = made.chunk(2, 0);
    const Tensor smooth = (two[1] - two[0]).diff(2, 1).square().mean();
    loss = loss + config_.w_smooth * smooth;
    means_.Add("smooth", smooth);
  }
  const std::vector<Tensor> both = off.chunk(2, 0);
  for (const auto& [name, part] : {std::pair{"reconstruction", both[0]}, {"styled", both[1]}}) {
    const Tensor distance = WeightedL1(part, config_.w_first);
    const Tensor velocity = WeightedL1(part.diff(1, 1), config_.w_first);
    loss = loss + 0.5 * (distance + config_.w_velocity * velocity);
    means_.Add(name, distance);
    means_.Add(std::string(name) + "_velocity", velocity);
  }
  student_.parameters.ZeroGradient();
  loss.backward();
  const double left = 1.0 - std::clamp(progress, 0.0, 1.0);
  const double decay = config_.decay_to + (1.0 - config_.decay_to) * left * left;
  adam_.Step(student_.parameters, config_.generator_rate * decay, 0);
  ++iteration_;
  const torch::NoGradGuard no_grad;
  const auto n = static_cast<double>(iteration_);
  const double keep = std::min(config_.ema, (1.0 + n) / (50.0 + n));
  average_.parameters.flat().lerp_(student_.parameters.flat(), 1.0 - keep);
}

void Learner::Save(Checkpoint& checkpoint) const {
  auto& t = checkpoint.tensors;
  t["student"] = student_.parameters.flat();
  t["average"] = average_.parameters.flat();
  t["teacher"] = teacher_.generator().parameters.flat();
  t["codes.mean"] = teacher_.codes();
  t["codes.single"] = teacher_.singles();
  SaveAdam("student", adam_, checkpoint);
  t["iteration"] = torch::tensor({iteration_}, torch::kInt64);
  checkpoint.strings["sampler"] = sampler_.Save();
}

Status Learner::Restore(const Checkpoint& checkpoint) {
  const torch::NoGradGuard no_grad;
  try {
    const auto& t = checkpoint.tensors;
    if (!torch::equal(t.at("teacher"), teacher_.generator().parameters.flat().cpu()) ||
        !torch::equal(t.at("codes.mean"), teacher_.codes().cpu()) ||
        !torch::equal(t.at("codes.single"), teacher_.singles().cpu())) {
      return Status::Error("was made with other weights of --init, or other --single-codes");
    }
    RestoreFlat(t.at("student"), student_.parameters);
    RestoreFlat(t.at("average"), average_.parameters);
    RestoreAdam("student", checkpoint, adam_);
    iteration_ = t.at("iteration").item<int64_t>();
    sampler_.Restore(checkpoint.strings.at("sampler"));
  } catch (const std::exception& error) {
    return Status::Error(Reason(error));
  }
  return Status::Ok();
}

bool Learner::Finite() const {
  return torch::isfinite(student_.parameters.flat()).all().item<bool>();
}

}  // namespace styled::train::st_gcn_causal
