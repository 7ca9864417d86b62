#include "model/train/erd/monitor.h"

#include <cmath>
#include <sstream>

#include "model/train/erd/moments.h"
#include "model/train/geometry.h"

namespace styled::train::style_erd {
namespace {

constexpr int kEffectFrames = 24;  // of the windows in which the clips' own shifts are measured
constexpr double kTiny = 1e-12;    // m or m²; keeps a style without clips at 0

using torch::Tensor;

// Mean joint jerk, up to a factor of the rate: [T, B, 63] -> scalar.
double MeanJerk(const Tensor& positions) {
  const Tensor p = positions.view({positions.size(0), positions.size(1), -1, 3});
  return p.diff(3, 0).square().sum(-1).sqrt().mean().item<double>();
}

// The columns of one figure, and its part of the summary.
void AddFigure(const std::string& figure, const std::vector<std::string>& styles,
               const std::vector<double>& values, MonitorReport& report) {
  std::ostringstream text;
  text << " | " << figure;
  for (std::size_t i = 0; i < styles.size(); ++i) {
    report.figures.emplace_back(figure + '_' + styles[i], values[i]);
    text << ' ' << std::round(values[i] * 100) / 100;
  }
  report.summary += text.str();
}

}  // namespace

// Fixed windows: the first clips of each neutral cell, from their middle. `kept`: the contents that
// have any.
void Monitor::AddWindows(const std::vector<TrainingClip>& clips, int contents,
                         const erd::FeatureParameters& parameters, std::vector<int64_t>& kept) {
  std::vector<Tensor> windows;
  std::vector<int64_t> content_of;  // each window's place in `kept`
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
      content_of.push_back(static_cast<int64_t>(kept.size()));
      ++found;
    }
    if (found > 0) kept.push_back(content);
  }
  TORCH_CHECK(!windows.empty(), "the validation split has no neutral clip of ", kFrames + 1,
              " frames");
  features_ = torch::stack(windows, 1);
  labels_ = torch::zeros({static_cast<int64_t>(windows.size()), contents});
  for (std::size_t i = 0; i < windows.size(); ++i) {
    labels_[static_cast<int64_t>(i)][kept[static_cast<std::size_t>(content_of[i])]] = 1.0F;
  }
  content_ =
      torch::zeros({static_cast<int64_t>(kept.size()), static_cast<int64_t>(windows.size())});
  for (std::size_t i = 0; i < windows.size(); ++i) {
    content_[content_of[i]][static_cast<int64_t>(i)] = 1.0F;
  }
  content_ = content_ / content_.sum(1, true);
}

Monitor::Monitor(const std::vector<TrainingClip>& clips,
                 const std::vector<clip::ManifestStyle>& styles, int contents,
                 const erd::FeatureParameters& parameters, const Tensor& mean,
                 const Tensor& deviation) {
  for (std::size_t i = 1; i < styles.size(); ++i) names_.push_back(styles[i].name);
  std::vector<int64_t> kept;
  AddWindows(clips, contents, parameters, kept);
  const torch::Device device = mean.device();
  features_ = features_.to(device);
  content_ = content_.to(device);
  labels_ = labels_.to(device);
  u_ = (features_ - mean) / deviation;
  const Tensor kept_index = torch::tensor(kept, torch::kInt64);
  const StyleEffects real = MeasureEffects(clips, static_cast<int>(styles.size()), contents,
                                           kEffectFrames, 1, parameters);
  real_shift_ = real.moments.narrow(2, erd::kPositionBegin, erd::kPositionFeatures)
                    .index_select(1, kept_index)
                    .to(device);
  present_ = real.known.index_select(1, kept_index).to(device);
}

// Encoder and recurrent layers, for all styles at once.
Monitor::Sequences Monitor::Run(const Generator& generator) const {
  const int64_t batch = u_.size(1);
  const auto branches = static_cast<int64_t>(names_.size());
  const Tensor one_hot = torch::eye(branches + 1).to(u_.device());
  const bool knows_contents = generator.shape.contents > 0;
  const Tensor z = generator.Encode(u_, one_hot.narrow(0, 0, 1).expand({batch, -1}),
                                    labels_.unsqueeze(0).expand({kFrames, -1, -1}));
  StackState neutral_state = knows_contents ? generator.neutral.InitialOf(labels_.argmax(1))
                                            : generator.neutral.Initial(batch);
  StackState branch_state = generator.branches.Initial(batch);
  Sequences run;
  run.z_neutral = generator.Neutral(z, neutral_state);
  run.z_residual = generator.Branches(z.repeat({1, branches, 1}), branch_state);
  run.one_hot = one_hot;
  run.rec =
      generator.Decode(run.z_neutral, run.one_hot.narrow(0, 0, 1).expand({batch, -1})).rotations;
  run.input = features_.narrow(2, 0, erd::kRotationFeatures)
                  .reshape({kFrames, batch, body::kJointCount, 4});
  run.positions = features_.narrow(2, erd::kPositionBegin, erd::kPositionFeatures)
                      .narrow(0, kSkipped, kFrames - kSkipped);
  return run;
}

Tensor Monitor::StyledPositions(const Generator& generator, const Sequences& run,
                                int64_t style) const {
  const int64_t batch = u_.size(1);
  const Tensor sty =
      generator
          .Decode(run.z_neutral + run.z_residual.narrow(1, (style - 1) * batch, batch),
                  run.one_hot.narrow(0, style, 1).expand({batch, -1}))
          .rotations;
  const Tensor published = Multiply(run.input, Multiply(Conjugate(run.rec), sty));
  return HipsRelativePositions(published).narrow(0, kSkipped, kFrames - kSkipped).flatten(2, 3);
}

MonitorReport Monitor::Evaluate(const Generator& generator) const {
  const torch::NoGradGuard no_grad;
  const Sequences run = Run(generator);
  const Tensor dot = (run.rec * run.input).sum(-1).abs().clamp_max(1.0);
  const double reconstruction_deg = torch::acos(dot).mean().item<double>() * 2.0 * 180.0 / M_PI;
  const double input_jerk = MeanJerk(run.positions);
  std::vector<double> expression;
  std::vector<double> cosine;
  std::vector<double> jerk_ratio;
  for (int64_t style = 1; style <= static_cast<int64_t>(names_.size()); ++style) {
    const Tensor styled = StyledPositions(generator, run, style);
    const Tensor change = (styled - run.positions).mean(0);
    const Tensor shift = (torch::matmul(content_, change) * present_[style]).flatten();
    const Tensor real = real_shift_[style].flatten();
    const double along = torch::dot(shift, real).item<double>();
    const double real_norm = real.norm().item<double>();
    expression.push_back(along / (real_norm * real_norm + kTiny));
    cosine.push_back(along / (real_norm * shift.norm().item<double>() + kTiny));
    jerk_ratio.push_back(MeanJerk(styled) / input_jerk);
  }
  MonitorReport report;
  report.figures.emplace_back("reconstruction_deg", reconstruction_deg);
  std::ostringstream text;
  text << "rec " << reconstruction_deg << " deg";
  report.summary = text.str();
  AddFigure("expression", names_, expression, report);
  AddFigure("cosine", names_, cosine, report);
  AddFigure("jerk_ratio", names_, jerk_ratio, report);
  return report;
}

}  // namespace styled::train::style_erd
