// How a run starts otherwise than from random weights, all of them trained.
#include <algorithm>
#include <iostream>

#include "model/train/geometry.h"
#include "model/train/learner.h"

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
    for (int64_t i = 0; i < kWindows; ++i) windows.push_back(sampler.Any(style));
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
  const int64_t known = from.shape.styles;
  // 1. Which of its styles each of ours starts as.
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

  // 2. Shared parameters as they are; per style, rows of branches and columns of one-hot inputs.
  const Tensor index = torch::tensor(source, torch::kInt64);
  const Tensor branch_index = index.narrow(0, 1, index.size(0) - 1) - 1;
  for (const auto& [name, tensor] : generator_.parameters.named()) {
    Tensor value = from.parameters.Find(name).detach();
    if (name.starts_with("branches.")) value = value.index_select(0, branch_index);
    if (name == "encoder.0.weight" || name == "decoder.0.weight") {
      const int64_t plain = value.size(1) - known;
      value = torch::cat(
          {value.narrow(1, 0, plain), value.narrow(1, plain, known).index_select(1, index)}, 1);
    }
    if (value.sizes() != tensor.sizes()) return Status::Error("tensor " + name + " does not fit");
    tensor.copy_(value);
  }
  average_.parameters.flat().copy_(generator_.parameters.flat());
  neutral_carried_ = generator_.neutral.Initial(slots_).Concrete();
  branch_carried_ = generator_.branches.Initial(slots_ / (generator_.shape.styles - 1)).Concrete();
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
