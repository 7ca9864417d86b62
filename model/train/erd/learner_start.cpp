// How a run starts otherwise than from random weights, all of them trained.
#include <algorithm>
#include <iostream>

#include "model/train/erd/learner.h"
#include "model/train/geometry.h"

namespace styled::train {

using torch::Tensor;

// For each of our styles, the style of `from` whose branch reconstructs windows of it best.
std::vector<int64_t> Learner::NearestStyles(const Generator& from) const {
  constexpr int64_t kWindows = 32;
  Sampler::Options options = sampler_.options();
  options.seed += 2000003;
  Sampler sampler(clips_, options);
  const int64_t branches = from.branches.groups;
  const Tensor styles = torch::arange(1, branches + 1).repeat_interleave(kWindows);
  std::vector<int64_t> nearest{0};
  for (int style = 1; style < options.styles; ++style) {
    std::vector<Sampler::Window> windows;
    for (int64_t i = 0; i < kWindows; ++i) windows.push_back(sampler.Draw(style));
    const Batch batch = MakeBatch(windows);
    const Tensor z = from.Encode(batch.u.cpu().repeat({1, branches, 1}), styles);
    StackState neutral_state = from.neutral.Initial(kWindows * branches);
    StackState branch_state = from.branches.Initial(kWindows);
    const Tensor target = torch::one_hot(styles, branches + 1).to(torch::kFloat32);
    const Tensor rec =
        from.Decode(from.Neutral(z, neutral_state) + from.Branches(z, branch_state), target)
            .rotations;
    const Tensor error = SquaredHalfAngle(rec, batch.rotations.cpu().repeat({1, branches, 1, 1}));
    nearest.push_back(1 + error.mean(torch::IntArrayRef({0, 2}))
                              .view({branches, kWindows})
                              .mean(1)
                              .argmin()
                              .item<int64_t>());
  }
  return nearest;
}

Status Learner::Adopt(const LoadedWeights& weights) {
  const torch::NoGradGuard no_grad;
  const Generator& from = *weights.generator;
  std::vector<int64_t> source = NearestStyles(from);
  for (std::size_t style = 0; style < source.size(); ++style) {
    const std::string& name = manifest_.styles[style].name;
    const auto found = std::find(weights.styles.begin(), weights.styles.end(), name);
    if (found != weights.styles.end()) {
      source[style] = found - weights.styles.begin();
    } else if (style == 0) {
      return Status::Error("has no style \"" + name + "\", which the manifest calls neutral");
    } else {
      std::cout << name << " starts as " << weights.styles[source[style]] << std::endl;
    }
  }
  const Status copied = generator_.CopyStyles(from, source);
  if (!copied.ok()) return copied;
  average_.parameters.flat().copy_(generator_.parameters.flat());
  carried_ = generator_.Start(slots_);
  return Status::Ok();
}

Status Learner::ExpectIdle() {
  const std::vector<std::string>& all = manifest_.contents;
  const auto found = std::find(all.begin(), all.end(), config_.idle_as);
  if (found == all.end() || manifest_.still_content.empty()) {
    return Status::Error("--idle needs a manifest with [still] and with the content \"" +
                         config_.idle_as + "\" of --idle-as");
  }
  if (!sampler_.HasIdleFrames()) {
    return Status::Error("--idle: no neutral clip shows who stands on both feet with hands down");
  }
  idle_as_ = found - all.begin();
  return Status::Ok();
}

Status Learner::LearnFrom(const LoadedWeights& weights, const std::vector<Lesson>& lessons) {
  const torch::NoGradGuard no_grad;
  if (!torch::equal(weights.mean, mean_.cpu()) ||
      !torch::equal(weights.deviation, deviation_.cpu())) {
    return Status::Error("has other feature statistics than the run; both must be of one kin");
  }
  const auto has = [](const std::vector<std::string>& names, const std::string& name) {
    return std::find(names.begin(), names.end(), name) != names.end();
  };
  const auto contents = static_cast<int64_t>(manifest_.contents.size());
  std::vector<int64_t> source{0};
  Tensor gain = torch::zeros({generator_.shape.styles, contents});
  std::vector<std::string> shared;
  for (int64_t style = 1; style < generator_.shape.styles; ++style) {
    const std::string& name = manifest_.styles[static_cast<std::size_t>(style)].name;
    const auto found = std::find(weights.styles.begin() + 1, weights.styles.end(), name);
    const bool known = found != weights.styles.end();
    source.push_back(known ? found - weights.styles.begin() : 1);
    shared.push_back(known ? name : "");
    if (known && lessons.empty()) gain.select(0, style).fill_(1);
  }
  for (const Lesson& lesson : lessons) {
    const auto style = std::find(shared.begin(), shared.end(), lesson.style);
    if (lesson.style == manifest_.styles[0].name) {
      return Status::Error("cannot teach \"" + lesson.style +
                           "\": it is what changes are taken from");
    }
    if (lesson.style.empty() || style == shared.end()) {
      return Status::Error("cannot teach \"" + lesson.style +
                           "\": it and the run must both have it");
    }
    const std::vector<std::string>& all = manifest_.contents;
    if (!lesson.content.empty() && !has(all, lesson.content)) {
      return Status::Error("cannot teach \"" + lesson.style + "/" + lesson.content +
                           "\": the manifest has no such content");
    }
    for (int64_t content = 0; content < contents; ++content) {
      if (!lesson.content.empty() && lesson.content != all[content]) continue;
      gain.index_put_({style - shared.begin() + 1, content}, lesson.gain);
    }
  }
  if (gain.sum().item<double>() == 0) return Status::Error("has none of the run's styles");

  GeneratorShape shape = weights.generator->shape;
  shape.styles = generator_.shape.styles;
  Teacher teacher;
  teacher.generator = std::make_unique<Generator>(shape, mean_, deviation_);
  const Status copied = teacher.generator->CopyStyles(*weights.generator, source);
  if (!copied.ok()) return copied;
  teacher.carried = teacher.generator->Start(slots_);
  // One of a slot's two styles is neutral, number 0.
  teacher.gain = gain.to(device_).index_select(0, slots_.own + slots_.target);
  for (Teacher& earlier : teachers_) earlier.gain.masked_fill_(teacher.gain > 0, 0);
  const Tensor from_it = slots_.styled.flatten().unsqueeze(1) * (teacher.gain > 0);
  teacher.gain = torch::where(from_it > 0, torch::ones_like(teacher.gain), teacher.gain);
  if (config_.idle > 0) {
    teacher.mean_sum =
        torch::zeros({generator_.shape.styles, body::kJointCount, 3}, mean_.options());
    teacher.mean_count = torch::zeros({generator_.shape.styles}, mean_.options());
  }
  teachers_.push_back(std::move(teacher));
  return Status::Ok();
}

// The branches, and their columns of the style inputs of encoder and decoder.
void Learner::FreezeAllButTheStyles() {
  const torch::NoGradGuard no_grad;
  trained_ = torch::zeros_like(generator_.parameters.flat());
  for (const auto& [name, tensor] : generator_.parameters.named()) {
    const Tensor mask =
        trained_.narrow(0, tensor.storage_offset(), tensor.numel()).view(tensor.sizes());
    if (name.starts_with("branches.")) mask.fill_(1);
    if (name == "encoder.0.weight" || name == "decoder.0.weight") {
      const int64_t added = generator_.shape.styles - 1;
      mask.narrow(1, mask.size(1) - added, added).fill_(1);
    }
  }
}

void Learner::StartFromZeros() {
  const torch::NoGradGuard no_grad;
  if (!trained_.defined()) trained_ = torch::ones_like(generator_.parameters.flat());
  for (const Stack* stack : {&generator_.neutral, &generator_.branches}) {
    for (const std::vector<Tensor>* states : {&stack->h0, &stack->c0}) {
      for (const Tensor& state : *states) {
        state.detach().zero_();
        trained_.narrow(0, state.storage_offset(), state.numel()).zero_();
      }
    }
  }
  average_.parameters.flat().copy_(generator_.parameters.flat());
}

}  // namespace styled::train
