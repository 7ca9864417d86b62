#include "model/train/erd/moments.h"

#include <algorithm>

namespace styled::train::style_erd {
namespace {

using torch::Tensor;

// A cell's running mean forgets after about so many windows. Longer: it lags behind the network and
// the two swing; shorter: it is noise.
constexpr double kHorizon = 50.0;
constexpr double kFewestVisits = 10.0;

// Mean and deviation over time of features r and p: [T, B, 147] -> [B, 294].
Tensor WindowMoments(const Tensor& features) {
  const Tensor x = torch::cat({features.narrow(2, 0, erd::kRotationFeatures) * kRotationLever_m,
                               features.narrow(2, erd::kPositionBegin, erd::kPositionFeatures)},
                              2);
  const Tensor mean = x.mean(0);
  // The small term keeps the gradient finite where a joint does not move at all.
  const Tensor deviation = ((x - mean).square().mean(0) + 1e-6).sqrt();
  return torch::cat({mean, deviation}, 1);
}

}  // namespace

StyleEffects MeasureEffects(const std::vector<TrainingClip>& clips, int styles, int contents,
                            int length, int fewest, const erd::FeatureParameters& parameters) {
  int sources = 0;
  for (const TrainingClip& clip : clips) sources = std::max(sources, clip.source + 1);
  const int64_t cells = static_cast<int64_t>(styles) * contents;
  Tensor sum = torch::zeros({sources, cells, 2 * kEffectFeatures});
  Tensor count = torch::zeros({sources, cells, 1});
  Tensor window = torch::empty({length, erd::kFeatureCount});
  for (const TrainingClip& clip : clips) {
    const int frames = static_cast<int>(clip.poses.size());
    for (int start = 0; start + length <= frames; start += length / 2) {
      const int64_t cell =
          static_cast<int64_t>(clip.style) * contents + clip.ContentOf(start, length);
      for (const bool mirrored : {false, true}) {
        FillWindow(clip, start, length, mirrored, false, parameters,
                   {.features = window.data_ptr<float>()});
        sum[clip.source][cell] +=
            WindowMoments(window.narrow(1, 0, kEffectFeatures).unsqueeze(1))[0];
        count[clip.source][cell] += 1;
      }
    }
  }
  // A style's difference from neutral in each folder that has both, folders alike.
  const Tensor mean = (sum / count.clamp_min(1)).view({sources, styles, contents, -1});
  const Tensor present =
      (count.view({sources, styles, contents, 1}) >= 2 * fewest).to(torch::kFloat32);
  const Tensor both = present * present.narrow(1, 0, 1);
  const Tensor folders = both.sum(0);
  return {((mean - mean.narrow(1, 0, 1)) * both).sum(0) / folders.clamp_min(1),
          (folders > 0).to(torch::kFloat32)};
}

Moments::Moments(const StyleEffects& wanted, const torch::Device& device)
    : contents_(wanted.moments.size(1)),
      wanted_(wanted.moments.flatten(0, 1).to(device)),
      known_(wanted.known.flatten(0, 1).to(device)),
      running_(torch::zeros_like(wanted_)),
      visits_(torch::zeros_like(known_)) {}

Tensor Moments::Loss(const Tensor& in, const Tensor& out, const Tensor& style,
                     const Tensor& content, const Tensor& counted) {
  const Tensor cell = style * contents_ + content;
  const Tensor used = counted.view({-1, 1}) * known_.index_select(0, cell);
  const Tensor change = WindowMoments(out) - WindowMoments(in);
  Tensor error;
  {
    const torch::NoGradGuard no_grad;
    const Tensor new_sum = torch::zeros_like(running_).index_add_(0, cell, change * used);
    const Tensor new_count = torch::zeros_like(visits_).index_add_(0, cell, used);
    visits_ += new_count;
    const Tensor rate = (new_count / visits_.clamp(1.0, kHorizon)).clamp_max(1.0);
    running_ += rate * (new_sum / new_count.clamp_min(1) - running_);
    error = ((running_ - wanted_) * (visits_ >= kFewestVisits)).index_select(0, cell) * used;
  }
  // The gradient of |running - wanted|² as if the running mean were this window's: it moves the
  // mean and leaves the windows' own variety alone, which the square of a batch's mean would not.
  return (2.0 * error * change).sum(1).mean();
}

Tensor Moments::Distance() const {
  const Tensor used = known_ * (visits_ >= kFewestVisits);
  return ((running_ - wanted_).square().sum(1, true) * used).sum() / used.sum().clamp_min(1);
}

Tensor Moments::Save() const { return torch::cat({running_, visits_}, 1); }

void Moments::Restore(const Tensor& saved) {
  TORCH_CHECK(saved.size(0) == running_.size(0), "moments of another manifest");
  running_.copy_(saved.narrow(1, 0, running_.size(1)));
  visits_.copy_(saved.narrow(1, running_.size(1), 1));
}

}  // namespace styled::train::style_erd
