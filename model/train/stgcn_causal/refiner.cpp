#include "model/train/stgcn_causal/refiner.h"

#include <algorithm>

#include "model/net/stgcn/codes.h"
#include "model/train/stgcn/learner.h"

namespace styled::train::st_gcn_causal {
namespace {

using torch::Tensor;

// Of the windows. The first ones are not compared, because their statistics are mostly the learned
// start, which is long past live.
constexpr int64_t kFrames = 96, kFirstCompared = 32;
constexpr int64_t kNeutralWindows = 160, kTakeWindows = 48, kJudgedWindows = 24;
constexpr int64_t kAtOnce = 8;  // windows that are encoded together
constexpr double kChange = 3;   // weight of differences from frame to frame, beside poses
constexpr int64_t kDirections = 64, kQuantiles = 48;  // of the distribution

Tensor Compared(const Tensor& windows) {
  return windows.narrow(1, kFirstCompared, windows.size(1) - kFirstCompared);
}

// Poses with their changes from frame to frame, [frames, 294].
Tensor Described(const Tensor& windows) {
  const Tensor now = windows.narrow(1, 1, windows.size(1) - 1);
  return torch::cat({now.flatten(2), kChange * windows.diff(1, 1).flatten(2)}, 2).flatten(0, 1);
}

// At kQuantiles places of each sorted column.
Tensor Quantiles(const Tensor& values) {
  const Tensor sorted = std::get<0>(values.sort(0));
  const Tensor places = ((torch::arange(kQuantiles) + 0.5) / static_cast<double>(kQuantiles) *
                         static_cast<double>(values.size(0)))
                            .to(torch::kInt64);
  return sorted.index_select(0, places);
}

}  // namespace

Status Check(const RefineConfig& config) {
  const auto refuse = [](const std::string& flag, const std::string& expected) {
    return Status::Error("--" + flag + ": expected " + expected);
  };
  for (const auto& [flag, value] :
       {std::pair{"w-moments", config.w_moments},
        std::pair{"w-distribution", config.w_distribution},
        std::pair{"w-reproduce", config.w_reproduce}, std::pair{"w-small", config.w_small},
        std::pair{"code-rate", config.code_rate}, std::pair{"rate", config.rate}}) {
    if (!(value >= 0 && value <= 1000)) return refuse(flag, "a number from 0 to 1000");
  }
  if (!(config.code_alone >= 0 && config.code_alone <= 1)) {
    return refuse("code-alone", "a number from 0 to 1");
  }
  if (config.batch < 1 || config.batch > 256) return refuse("batch", "1 to 256");
  return Status::Ok();
}

Refiner::Refiner(const RefineConfig& config, const LoadedStudent& network,
                 const RefineMotion& motion, const FullStyle& start)
    : config_(config),
      network_(network),
      form_(network.statistics),
      graph_(torch::kCPU, st_gcn::TypeOf(config.precision, torch::kCPU), kFrames),
      exact_graph_(torch::kCPU, torch::kFloat32, kFrames),
      random_(config.seed),
      neutral_(MakePool(motion.neutral, kNeutralWindows, graph_, random_)),
      take_(MakePool(motion.take, kTakeWindows, graph_, random_)),
      judged_(MakePool(motion.judged_neutral, kJudgedWindows, exact_graph_, random_)),
      wanted_(MomentsOf(motion.take)),
      judged_wanted_(MomentsOf(motion.judged_take)),
      code_value_(code_.Add("code", start.code.sizes(), 0)),
      bias_(more_.Add("bias", start.bias.sizes(), 0)),
      additions_(more_.Add("additions", start.additions.sizes(), 0)),
      code_adam_((code_.Flatten(torch::kCPU), code_), 0.9, 0.99),
      more_adam_((more_.Flatten(torch::kCPU), more_), 0.9, 0.99) {
  torch::manual_seed(config.seed);  // of the directions
  const torch::NoGradGuard no_grad;
  code_value_.copy_(start.code);
  bias_.copy_(start.bias);
  additions_.copy_(start.additions);
  std::vector<Tensor> described;
  for (const Tensor& clip : motion.take) {
    if (clip.size(0) > 1) described.push_back(Described(clip.unsqueeze(0)));
  }
  described_ = torch::cat(described);
}

Refiner::Pool Refiner::MakePool(const Frames& clips, int64_t count, const Graph& graph,
                                std::mt19937_64& random) const {
  const torch::NoGradGuard no_grad;
  const Tensor neutral = network_.codes.narrow(0, 0, 1);
  std::vector<Tensor> contents, rotations, hips_m;
  const Tensor windows = DrawWindows(clips, kFrames, count, random);
  for (const Tensor& some : windows.split(kAtOnce)) {
    contents.push_back(network_.student->Encode(graph, some));
    const Tensor reconstruction =
        network_.student->Decode(graph, contents.back(), neutral.expand({some.size(0), -1}));
    const PublishedForm::Basis basis = form_.BasisOf(some, reconstruction);
    rotations.push_back(basis.rotations);
    hips_m.push_back(basis.hips_m);
  }
  return {torch::cat(contents), {torch::cat(rotations), torch::cat(hips_m)}, windows};
}

Tensor Refiner::Draw(int64_t below) {
  std::vector<int64_t> samples;
  for (int i = 0; i < config_.batch; ++i) {
    samples.push_back(static_cast<int64_t>(random_() % static_cast<uint64_t>(below)));
  }
  return torch::tensor(samples);
}

Tensor Refiner::Publish(const Pool& pool, const Tensor& samples, const FullStyle& style,
                        const Graph& graph) const {
  const Tensor styled =
      network_.student->Decode(graph, pool.content.index_select(0, samples), style);
  return Compared(form_(pool.basis.Select(samples), styled));
}

Tensor Refiner::MomentsLoss(const Tensor& published) const {
  const Moments found = MomentsOf(published);
  return (found.mean - wanted_.mean).abs().mean() +
         (found.deviation - wanted_.deviation).abs().mean() +
         kChange * (found.change - wanted_.change).abs().mean();
}

Tensor Refiner::DistributionLoss(const Tensor& published) const {
  const Tensor directions =
      torch::nn::functional::normalize(torch::randn({described_.size(1), kDirections}),
                                       torch::nn::functional::NormalizeFuncOptions().dim(0));
  const Tensor found = Quantiles(torch::matmul(Described(published), directions));
  const Tensor wanted = Quantiles(torch::matmul(described_, directions));
  return (found - wanted).abs().mean();
}

Tensor Refiner::ReproductionLoss(const FullStyle& style) {
  const Tensor samples = Draw(take_.window.size(0));
  const Tensor styled =
      network_.student->Decode(graph_, take_.content.index_select(0, samples), style);
  const Tensor off =
      Compared(form_.kinematics().Published(styled) - take_.window.index_select(0, samples));
  return off.abs().mean() + kChange * off.diff(1, 1).abs().mean();
}

double Refiner::Step(double progress) {
  const double all = std::clamp(progress, 0.0, 1.0);
  const bool code_alone = all < config_.code_alone;
  const FullStyle style{code_value_, bias_, additions_};
  Tensor loss = config_.w_small * (bias_.square().mean() + additions_.square().mean());
  if (config_.w_moments > 0 || config_.w_distribution > 0) {
    const Tensor published = Publish(neutral_, Draw(neutral_.window.size(0)), style, graph_);
    if (config_.w_moments > 0) loss = loss + config_.w_moments * MomentsLoss(published);
    if (config_.w_distribution > 0) {
      loss = loss + config_.w_distribution * DistributionLoss(published);
    }
  }
  if (config_.w_reproduce > 0) loss = loss + config_.w_reproduce * ReproductionLoss(style);
  code_.ZeroGradient();
  more_.ZeroGradient();
  loss.backward();
  const double left = 1 - all;
  const double decay = config_.decay_to + (1 - config_.decay_to) * left * left;
  code_adam_.Step(code_, config_.code_rate * decay);
  if (!code_alone) more_adam_.Step(more_, config_.rate * decay);
  PullIn();
  return loss.item<double>();
}

// The code stays where the runtime would allow it (stgcn::PulledIn).
void Refiner::PullIn() {
  const torch::NoGradGuard no_grad;
  const stgcn::Code code = Eigen::Map<const stgcn::Code>(code_value_.data_ptr<float>());
  const stgcn::Code limited = stgcn::PulledIn(network_.network->space(), code);
  std::copy_n(limited.data(), limited.size(), code_value_.data_ptr<float>());
}

FullStyle Refiner::style() const {
  return {code_value_.detach().clone(), bias_.detach().clone(), additions_.detach().clone()};
}

RefineFigures Refiner::Measure(const FullStyle& style) const {
  const torch::NoGradGuard no_grad;
  std::vector<Tensor> published;
  for (const Tensor& some : torch::arange(judged_.window.size(0)).split(kAtOnce)) {
    published.push_back(Publish(judged_, some, style, exact_graph_));
  }
  const Moments found = MomentsOf(torch::cat(published));
  const Tensor& deviation = form_.kinematics().deviation();
  return {MeanDistance_cm(found, judged_wanted_, deviation),
          SpreadDistance_cm(found, judged_wanted_, deviation)};
}

RefineFigures Refiner::MeasureNeutral() const {
  const Moments found = MomentsOf(Compared(judged_.window));
  const Tensor& deviation = form_.kinematics().deviation();
  return {MeanDistance_cm(found, judged_wanted_, deviation),
          SpreadDistance_cm(found, judged_wanted_, deviation)};
}

bool Refiner::Finite() const {
  return torch::isfinite(code_.flat()).all().item<bool>() &&
         torch::isfinite(more_.flat()).all().item<bool>();
}

}  // namespace styled::train::st_gcn_causal
