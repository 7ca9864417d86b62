#include "model/train/erd/monitor.h"

#include <algorithm>

#include "model/train/erd/moments.h"
#include "model/train/geometry.h"

namespace styled::train {
namespace {

constexpr int kEffectFrames = 24;

using torch::Tensor;

// Mean joint jerk, up to a factor of the rate: [T, B, 63] -> scalar.
double MeanJerk(const Tensor& positions) {
  const Tensor p = positions.view({positions.size(0), positions.size(1), -1, 3});
  return p.diff(3, 0).square().sum(-1).sqrt().mean().item<double>();
}

}  // namespace

Monitor::Monitor(const std::vector<TrainingClip>& clips, int styles, int contents,
                 const erd::FeatureParameters& parameters, const Tensor& mean,
                 const Tensor& deviation)
    : styles_(styles) {
  // Fixed windows: the first clips of each neutral cell, from their middle.
  std::vector<Tensor> windows;
  std::vector<int> window_content;
  std::vector<int> kept;
  for (int content = 0; content < contents; ++content) {
    int found = 0;
    for (const TrainingClip& clip : clips) {
      const int length = static_cast<int>(clip.poses.size());
      if (clip.style != 0 || clip.content != content || length <= kFrames) continue;
      if (found == kWindowsPerContent) break;
      Tensor window = torch::empty({kFrames, erd::kFeatureCount});
      FillWindow(clip, (length - kFrames) / 2, kFrames, false, false, parameters,
                 {.features = window.data_ptr<float>()});
      windows.push_back(window);
      window_content.push_back(static_cast<int>(kept.size()));
      ++found;
    }
    if (found > 0) kept.push_back(content);
  }
  TORCH_CHECK(!windows.empty(), "the validation split has no neutral clip of ", kFrames + 1,
              " frames");
  features_ = torch::stack(windows, 1).to(mean.device());
  u_ = (features_ - mean) / deviation;
  content_ =
      torch::zeros({static_cast<int64_t>(kept.size()), static_cast<int64_t>(windows.size())});
  for (std::size_t i = 0; i < windows.size(); ++i) {
    content_[window_content[i]][static_cast<int64_t>(i)] = 1.0F;
  }
  content_ = (content_ / content_.sum(1, true)).to(mean.device());
  const Tensor kept_index =
      torch::tensor(std::vector<int64_t>(kept.begin(), kept.end()), torch::kInt64);
  const StyleEffects real = MeasureEffects(clips, styles, contents, kEffectFrames, 1, parameters);
  real_shift_ = real.moments.narrow(2, erd::kPositionBegin, erd::kPositionFeatures)
                    .index_select(1, kept_index)
                    .to(mean.device());
  present_ = real.known.index_select(1, kept_index).to(mean.device());
}

MonitorRow Monitor::Evaluate(const Generator& generator) const {
  torch::NoGradGuard no_grad;
  const int64_t batch = u_.size(1);
  const int64_t branches = styles_ - 1;
  const Tensor styles = torch::zeros({batch}, torch::kInt64).to(u_.device());
  const Tensor z = generator.Encode(u_, styles);
  StackState neutral_state = generator.neutral.Initial(batch);
  StackState branch_state = generator.branches.Initial(batch);
  const Tensor r0 = generator.Neutral(z, neutral_state);
  const Tensor residual = generator.Branches(z.repeat({1, branches, 1}), branch_state);
  const Tensor one_hot = torch::eye(styles_).to(u_.device());
  const Tensor rec = generator.Decode(r0, one_hot.narrow(0, 0, 1).expand({batch, -1})).rotations;
  const Tensor input = features_.narrow(2, 0, erd::kRotationFeatures)
                           .reshape({kFrames, batch, body::kJointCount, 4});
  const Tensor positions = features_.narrow(2, erd::kPositionBegin, erd::kPositionFeatures)
                               .narrow(0, kSkipped, kFrames - kSkipped);
  const double input_jerk = MeanJerk(positions);

  MonitorRow row;
  const Tensor dot = (rec * input).sum(-1).abs().clamp_max(1.0);
  row.reconstruction_deg = torch::acos(dot).mean().item<double>() * 2.0 * 180.0 / M_PI;
  for (int64_t style = 1; style < styles_; ++style) {
    const Tensor sty = generator
                           .Decode(r0 + residual.narrow(1, (style - 1) * batch, batch),
                                   one_hot.narrow(0, style, 1).expand({batch, -1}))
                           .rotations;
    const Tensor published = Multiply(input, Multiply(Conjugate(rec), sty));
    const Tensor styled =
        HipsRelativePositions(published).narrow(0, kSkipped, kFrames - kSkipped).flatten(2, 3);
    const Tensor shift =
        (torch::matmul(content_, (styled - positions).mean(0)) * present_[style]).flatten();
    const Tensor real = real_shift_[style].flatten();
    const double along = torch::dot(shift, real).item<double>();
    const double real_norm = real.norm().item<double>();
    row.expression.push_back(along / (real_norm * real_norm + 1e-12));
    row.cosine.push_back(along / (real_norm * shift.norm().item<double>() + 1e-12));
    row.jerk_ratio.push_back(MeanJerk(styled) / input_jerk);
  }
  return row;
}

}  // namespace styled::train
