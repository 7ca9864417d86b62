// The start of a run: the classifier, initial weights other than random ones, and the selection of
// trained weights.
#include <algorithm>
#include <iostream>

#include "model/train/erd/learner.h"
#include "model/train/geometry.h"

namespace styled::train::style_erd {
namespace {

using torch::Tensor;

// Added to the run's seed, so that these windows are not those of the first iterations.
constexpr uint64_t kClassifierSeed = 1000003, kNearestSeed = 2000003;
// The classifier's learning rate, which falls linearly to a tenth over its iterations.
constexpr double kClassifierRate = 1e-3, kClassifierDecay = 0.9;
constexpr int kClassifierLogEvery = 250;  // iterations

}  // namespace

void Learner::TrainClassifier() {
  Sampler::Options options = sampler_.options();
  options.seed += kClassifierSeed;
  Sampler sampler(clips_, options);
  Adam adam(classifier_.parameters);
  const int styles = options.styles;
  double loss_sum = 0;
  double right_sum = 0;
  for (int i = 0; i < config_.classifier_iterations; ++i) {
    std::vector<Sampler::Window> windows;
    for (int64_t k = 0; k < slots_.count(); ++k)
      windows.push_back(sampler.Draw(static_cast<int>(k) % styles));
    const Batch batch = batches_.Make(windows);
    const Tensor u = batch.u.narrow(0, 1, frames_ - 1).narrow(2, 0, kContentFeatures).to(device_);
    const Tensor logits = classifier_.Logits(u);
    const Tensor label = batch.content.argmax(1).to(device_);
    const Tensor loss = torch::nn::functional::cross_entropy(logits, label);
    classifier_.parameters.ZeroGradient();
    loss.backward();
    adam.Step(classifier_.parameters,
              kClassifierRate * (1.0 - kClassifierDecay * i / config_.classifier_iterations));
    loss_sum += loss.item<double>();
    right_sum += (logits.argmax(1) == label).to(torch::kFloat32).mean().item<double>();
    if ((i + 1) % kClassifierLogEvery == 0) {
      std::cout << "classifier " << i + 1 << ": loss " << loss_sum / kClassifierLogEvery
                << ", right " << right_sum / kClassifierLogEvery << std::endl;
      loss_sum = right_sum = 0;
    }
  }
  classifier_.parameters.RequireGradient(false);
}

// For each of the run's styles, the style of `from` whose branch reconstructs windows of it best.
std::vector<int64_t> Learner::NearestStyles(const Generator& from) const {
  constexpr int64_t kWindows = 32;  // per style; enough for a mean over contents
  Sampler::Options options = sampler_.options();
  options.seed += kNearestSeed;
  Sampler sampler(clips_, options);
  const int64_t branches = from.branches.groups;
  const Tensor styles = torch::arange(1, branches + 1).repeat_interleave(kWindows);
  std::vector<int64_t> nearest{0};
  for (int style = 1; style < options.styles; ++style) {
    std::vector<Sampler::Window> windows;
    for (int64_t i = 0; i < kWindows; ++i) windows.push_back(sampler.Draw(style));
    const Batch batch = batches_.Make(windows);
    const Tensor target = torch::one_hot(styles, branches + 1).to(torch::kFloat32);
    const bool knows_contents = from.shape.contents > 0;
    const Tensor content = batch.content.repeat({branches, 1});
    const Tensor z = from.Encode(batch.u.repeat({1, branches, 1}), target,
                                 content.unsqueeze(0).expand({frames_, -1, -1}));
    StackState neutral_state = knows_contents ? from.neutral.InitialOf(content.argmax(1))
                                              : from.neutral.Initial(kWindows * branches);
    StackState branch_state = from.branches.Initial(kWindows);
    const Tensor rec =
        from.Decode(from.Neutral(z, neutral_state) + from.Branches(z, branch_state), target)
            .rotations;
    const Tensor error = SquaredHalfAngle(rec, batch.rotations().repeat({1, branches, 1, 1}));
    nearest.push_back(1 + error.mean(torch::IntArrayRef({0, 2}))
                              .view({branches, kWindows})
                              .mean(1)
                              .argmin()
                              .item<int64_t>());
  }
  return nearest;
}

Status Learner::StartFrom(const LoadedWeights& weights) {
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
      const int64_t after = name == "encoder.0.weight" ? generator_.shape.contents : 0;
      mask.narrow(1, mask.size(1) - after - added, added).fill_(1);
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

}  // namespace styled::train::style_erd
