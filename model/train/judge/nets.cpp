#include "model/train/judge/nets.h"

#include <torch/torch.h>

#include <algorithm>
#include <cstdio>

#include "model/train/judge/auto_encoder.h"
#include "model/train/judge/classifier.h"

namespace styled::judge {
namespace {

// During training each window and feature also gets a constant offset, in the feature's deviations.
// Common properties of a recording session's clips (markers, actor) must not decide the style, and
// a small constant signature must not pass for one. The content judge also sees poses between
// styles; half a deviation worked best for styles left out of its training.
constexpr float kStyleOffset = 1.0F;
constexpr float kContentOffset = 0.5F;

}  // namespace

Sequence MakeSequence(std::span<const body::Pose> poses, int style, int content, bool mirrored,
                      const erd::FeatureParameters& parameters) {
  Sequence sequence{.style = style, .content = content, .frames = {}};
  erd::FeatureState state;
  erd::Features features;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    body::Pose pose = poses[i];
    if (mirrored) body::Mirror(poses[i], pose);
    erd::ComputeFeatures(pose, parameters, state, features);
    if (i > 0) sequence.frames.push_back(features);
  }
  return sequence;
}

struct Judges::Impl : torch::nn::Module {
  Impl(int styles, int contents, const JudgeSettings& s)
      : settings(s),
        style(register_module("style", Classifier(erd::kFeatureCount, styles))),
        content(register_module("content", Classifier(erd::kFeatureCount, contents))),
        encoder(register_module("encoder", AutoEncoder())),
        mean(register_buffer("mean", torch::zeros({1, erd::kFeatureCount, 1}))),
        deviation(register_buffer("deviation", torch::ones({1, erd::kFeatureCount, 1}))) {}

  // [N, T, F] as sampled -> [N, F, T] standardized.
  torch::Tensor Standardize(const torch::Tensor& windows) const {
    return (windows.transpose(1, 2) - mean) / deviation;
  }
  torch::Tensor Rotations(const torch::Tensor& windows) const {
    return windows.slice(2, 0, erd::kRotationFeatures).transpose(1, 2);
  }
  torch::Tensor RotationMean() const { return mean.slice(1, 0, erd::kRotationFeatures); }

  void TrainOn(const std::vector<train::TrainingClip>& clips, int styles, int contents);
  void Train(const std::vector<Sequence>& sequences, int styles, int contents);
  Verdicts Judge(const torch::Tensor& windows) const;
  void SetParameters() {
    erd::Features values;
    const torch::Tensor flat = mean.contiguous();
    std::copy_n(flat.data_ptr<float>(), values.size(), values.begin());
    feature_parameters.rate_hz = static_cast<float>(kJudgeRate_hz);
    train::SetHemisphere(values, feature_parameters);
  }

  JudgeSettings settings;
  erd::FeatureParameters feature_parameters;
  mutable Classifier style, content;
  mutable AutoEncoder encoder;
  torch::Tensor mean, deviation;
};

void Judges::Impl::TrainOn(const std::vector<train::TrainingClip>& clips, int styles,
                           int contents) {
  const train::FeatureStatistics statistics = train::ComputeStatistics(clips, feature_parameters);
  for (int i = 0; i < erd::kFeatureCount; ++i) {
    mean[0][i][0] = statistics.mean[i];
    deviation[0][i][0] = statistics.deviation[i];
  }
  SetParameters();
  Train(MakeSequences(clips, feature_parameters), styles, contents);
}

void Judges::Impl::Train(const std::vector<Sequence>& sequences, int styles, int contents) {
  const int batch = settings.batch;
  WindowSampler sampler(sequences, styles, contents, settings.window, settings.seed);
  torch::Tensor windows = torch::empty({batch, settings.window, erd::kFeatureCount});
  torch::Tensor style_label = torch::empty({batch}, torch::kLong);
  torch::Tensor content_label = torch::empty({batch}, torch::kLong);
  train();
  torch::Tensor style_loss;
  torch::Tensor content_loss;
  torch::Tensor encoder_loss;
  const auto loss = [&] {
    sampler.Fill(batch, windows.data_ptr<float>(), style_label.data_ptr<std::int64_t>(),
                 content_label.data_ptr<std::int64_t>());
    const torch::Tensor x = Standardize(windows);
    const torch::Tensor noisy = x + kFeatureNoise * torch::randn_like(x);
    const auto with_offset = [&noisy](float deviation) {
      return noisy + deviation * torch::randn({noisy.size(0), erd::kFeatureCount, 1});
    };
    style_loss =
        torch::nn::functional::cross_entropy(style(with_offset(kStyleOffset)), style_label);
    content_loss =
        torch::nn::functional::cross_entropy(content(with_offset(kContentOffset)), content_label);
    encoder_loss = encoder->Loss(Rotations(windows), RotationMean());
    return style_loss + content_loss + encoder_loss;
  };
  const auto state = [&] {
    char text[96];
    std::snprintf(text, sizeof text, "style %.3f, content %.3f, encoder %.4f",
                  style_loss.item<double>(), content_loss.item<double>(),
                  encoder_loss.item<double>());
    return std::string(text);
  };
  Optimize("judges of seed " + std::to_string(settings.seed), torch::nn::Module::parameters(),
           settings.iterations, loss, state);
}

Judges::Judges(const JudgeSettings& settings) : settings_(settings) {}
Judges::~Judges() = default;
Judges::Judges(Judges&&) noexcept = default;
Judges& Judges::operator=(Judges&&) noexcept = default;
const JudgeSettings& Judges::settings() const { return settings_; }
// The same for all seeds: they follow from the clips.
const erd::FeatureParameters& Judges::parameters() const {
  return judges_.front()->feature_parameters;
}

std::vector<double> Hits(std::span<const Verdicts> by_judge, std::vector<int> Verdicts::*answers,
                         int right) {
  std::vector<double> hits;
  for (const Verdicts& verdicts : by_judge) {
    const std::vector<int>& given = verdicts.*answers;
    hits.push_back(static_cast<double>(std::count(given.begin(), given.end(), right)));
  }
  return hits;
}

Result<Judges> Judges::TrainOrLoad(const std::vector<train::TrainingClip>& clips, int styles,
                                   int contents, const JudgeSettings& settings,
                                   const std::filesystem::path& cache, const std::string& key) {
  torch::set_num_threads(1);
  Judges judges(settings);
  for (const JudgeSettings& one : EachSeed(settings)) {
    torch::manual_seed(one.seed);
    const std::filesystem::path file = CacheFile(cache, "judges", key, one.seed);
    try {
      auto impl = std::make_unique<Impl>(styles, contents, one);
      if (std::filesystem::exists(file)) {
        torch::serialize::InputArchive archive;
        archive.load_from(file.string());
        impl->load(archive);
        impl->SetParameters();
      } else {
        impl->TrainOn(clips, styles, contents);
        SaveModule(*impl, file);
      }
      impl->eval();
      judges.judges_.push_back(std::move(impl));
    } catch (const std::exception& error) {
      return Status::Error(file.string() + ": " + error.what());
    }
  }
  return judges;
}

Judges Judges::Read(net::TensorReader& tensors, int styles, int contents,
                    const JudgeSettings& settings) {
  torch::set_num_threads(1);
  Judges judges(settings);
  for (const JudgeSettings& one : EachSeed(settings)) {
    auto impl = std::make_unique<Impl>(styles, contents, one);
    ReadTensors(*impl, std::to_string(one.seed) + ".", tensors);
    impl->SetParameters();
    impl->eval();
    judges.judges_.push_back(std::move(impl));
  }
  return judges;
}

std::vector<net::NamedTensor> Judges::Tensors() const {
  std::vector<net::NamedTensor> tensors;
  for (const auto& judge : judges_) {
    AppendTensors(*judge, std::to_string(judge->settings.seed) + ".", tensors);
  }
  return tensors;
}

std::vector<std::vector<int>> Judges::JudgeStyle(const Sequence& sequence, int window) const {
  torch::NoGradGuard no_grad;
  const std::vector<int> starts = WindowStarts(sequence, window, 1);
  std::vector<std::vector<int>> by_judge(judges_.size());
  if (starts.empty()) return by_judge;
  const torch::Tensor windows = Windows(sequence, starts, window);
  for (std::size_t i = 0; i < judges_.size(); ++i) {
    by_judge[i] = Answers(judges_[i]->style(judges_[i]->Standardize(windows)));
  }
  return by_judge;
}

Verdicts Judges::Impl::Judge(const torch::Tensor& windows) const {
  Verdicts verdicts;
  const torch::Tensor x = Standardize(windows);
  verdicts.style = Answers(style(x));
  const torch::Tensor pooled = content->Pool(x);
  verdicts.content = Answers(content->head(pooled));
  verdicts.content_features = Rows(pooled.slice(1, 0, pooled.size(1) / 2));
  verdicts.embedding = Rows(encoder->Encode(Rotations(windows) - RotationMean()).mean(2));
  return verdicts;
}

std::vector<Verdicts> Judges::Judge(const Sequence& sequence, int stride) const {
  torch::NoGradGuard no_grad;
  const std::vector<int> starts = WindowStarts(sequence, settings_.window, stride);
  std::vector<Verdicts> by_judge(judges_.size());
  if (starts.empty()) return by_judge;
  const torch::Tensor windows = Windows(sequence, starts, settings_.window);
  for (std::size_t i = 0; i < judges_.size(); ++i) {
    by_judge[i] = judges_[i]->Judge(windows);
    by_judge[i].starts = starts;
  }
  return by_judge;
}

}  // namespace styled::judge
