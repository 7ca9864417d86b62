#include "model/train/judge/judge_nets.h"

#include <torch/torch.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <numeric>
#include <random>

namespace styled::judge {
namespace {

constexpr float kFeatureNoise = 0.15F;  // on standardized features, during training
// During training each window and feature also gets a constant offset, in the feature's deviations:
// what the clips of a recording session share (markers, actor) must not decide the style, and a
// small constant signature must not pass for one. The content judge also sees poses between styles;
// half a deviation worked best for styles left out of its training.
constexpr float kStyleOffset = 1.0F;
constexpr float kContentOffset = 0.5F;
constexpr float kRotationNoise = 0.03F;  // the auto-encoder's, on quaternions
constexpr float kDropout = 0.3F;
constexpr float kRate = 1e-3F;
constexpr float kWeightDecay = 1e-3F;

// [N, features, T] -> [N, classes].
struct ClassifierImpl : torch::nn::Module {
  ClassifierImpl(int features, int classes) {
    using namespace torch::nn;  // NOLINT
    layers = register_module(
        "layers",
        Sequential(Conv1d(Conv1dOptions(features, 64, 1)), BatchNorm1d(64), ReLU(),
                   Conv1d(Conv1dOptions(64, 96, 5).stride(2).padding(2)), BatchNorm1d(96), ReLU(),
                   Dropout(kDropout), Conv1d(Conv1dOptions(96, 128, 3).stride(2).padding(1)),
                   BatchNorm1d(128), ReLU(), Dropout(kDropout),
                   Conv1d(Conv1dOptions(128, 128, 3).padding(1)), BatchNorm1d(128), ReLU()));
    head = register_module("head", Linear(256, classes));
  }
  torch::Tensor forward(const torch::Tensor& x) {
    const torch::Tensor m = layers->forward(x);
    return head(
        torch::dropout(torch::cat({m.mean(2), std::get<0>(m.max(2))}, 1), kDropout, is_training()));
  }
  torch::nn::Sequential layers{nullptr};
  torch::nn::Linear head{nullptr};
};
TORCH_MODULE(Classifier);

// The denoising auto-encoder over rotations, [N, 4J, T] with T a multiple of 4.
struct AutoEncoderImpl : torch::nn::Module {
  AutoEncoderImpl() {
    using namespace torch::nn;  // NOLINT
    const int c = erd::kRotationFeatures;
    encoder = register_module(
        "encoder",
        Sequential(Conv1d(Conv1dOptions(c, 128, 4).stride(4)), BatchNorm1d(128), ReLU(),
                   Conv1d(Conv1dOptions(128, 256, 3).dilation(2)), BatchNorm1d(256), ReLU(),
                   Conv1d(Conv1dOptions(256, 512, 2)), BatchNorm1d(512), ReLU()));
    decoder = register_module(
        "decoder",
        Sequential(ConvTranspose1d(ConvTranspose1dOptions(512, 256, 2)), BatchNorm1d(256), ReLU(),
                   ConvTranspose1d(ConvTranspose1dOptions(256, 128, 3).dilation(2)),
                   BatchNorm1d(128), ReLU(),
                   ConvTranspose1d(ConvTranspose1dOptions(128, c, 4).stride(4))));
  }
  torch::nn::Sequential encoder{nullptr}, decoder{nullptr};
};
TORCH_MODULE(AutoEncoder);

// Draws windows: styles with equal probability, then contents within the style, then clips.
class Sampler {
 public:
  Sampler(const std::vector<Sequence>& sequences, int styles, int contents, int window,
          unsigned seed)
      : sequences_(sequences), window_(window), random_(seed) {
    std::vector<std::vector<std::vector<int>>> cells(styles,
                                                     std::vector<std::vector<int>>(contents));
    for (std::size_t i = 0; i < sequences.size(); ++i) {
      if (static_cast<int>(sequences[i].frames.size()) < window) continue;
      cells[sequences[i].style][sequences[i].content].push_back(static_cast<int>(i));
    }
    for (auto& style : cells) {
      std::erase_if(style, [](const std::vector<int>& cell) { return cell.empty(); });
      if (!style.empty()) cells_.push_back(std::move(style));
    }
  }

  // Writes `count` windows as [count, window, features] with their labels.
  void Fill(int count, float* out, std::int64_t* style, std::int64_t* content) {
    for (int i = 0; i < count; ++i) {
      const Sequence& sequence = sequences_[Pick(Pick(Pick(cells_)))];
      const int spare = static_cast<int>(sequence.frames.size()) - window_;
      const int start = std::uniform_int_distribution<int>(0, spare)(random_);
      for (int t = 0; t < window_; ++t, out += erd::kFeatureCount) {
        std::copy(sequence.frames[start + t].begin(), sequence.frames[start + t].end(), out);
      }
      style[i] = sequence.style;
      content[i] = sequence.content;
    }
  }

 private:
  template <typename T>
  const T& Pick(const std::vector<T>& from) {
    return from[std::uniform_int_distribution<std::size_t>(0, from.size() - 1)(random_)];
  }

  const std::vector<Sequence>& sequences_;
  int window_;
  std::mt19937 random_;
  std::vector<std::vector<std::vector<int>>> cells_;
};

torch::Tensor QuaternionLoss(const torch::Tensor& expected, const torch::Tensor& found) {
  const auto quaternions = [](const torch::Tensor& x) {  // [N, 4J, T] -> unit, [N, J, 4, T]
    const torch::Tensor q = x.view({x.size(0), body::kJointCount, 4, x.size(2)});
    return q / q.norm(2, {2}, true).clamp_min(1e-6);
  };
  const torch::Tensor dot = (quaternions(expected) * quaternions(found)).sum(2).abs();
  return dot.clamp_max(1 - 1e-6).acos().square().mean();  // eq. 2
}

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

  void Train(const std::vector<Sequence>& sequences, int styles, int contents);
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

void Judges::Impl::Train(const std::vector<Sequence>& sequences, int styles, int contents) {
  const int batch = settings.batch;
  Sampler sampler(sequences, styles, contents, settings.window, settings.seed);
  torch::Tensor windows = torch::empty({batch, settings.window, erd::kFeatureCount});
  torch::Tensor style_label = torch::empty({batch}, torch::kLong);
  torch::Tensor content_label = torch::empty({batch}, torch::kLong);
  torch::optim::AdamW optimizer(torch::nn::Module::parameters(),
                                torch::optim::AdamWOptions(kRate).weight_decay(kWeightDecay));
  train();
  const auto begin = std::chrono::steady_clock::now();
  for (int i = 0; i < settings.iterations; ++i) {
    // Linear warm-up over a tenth of the run, then cosine decay to zero.
    const double done = static_cast<double>(i) / settings.iterations;
    const double rate = kRate * std::min(1.0, done / 0.1) * 0.5 * (1 + std::cos(M_PI * done));
    for (auto& group : optimizer.param_groups()) {
      static_cast<torch::optim::AdamWOptions&>(group.options()).lr(rate);
    }
    sampler.Fill(batch, windows.data_ptr<float>(), style_label.data_ptr<std::int64_t>(),
                 content_label.data_ptr<std::int64_t>());
    const torch::Tensor x = Standardize(windows);
    const torch::Tensor noisy = x + kFeatureNoise * torch::randn_like(x);
    const auto with_offset = [&noisy](float deviation) {
      return noisy + deviation * torch::randn({noisy.size(0), erd::kFeatureCount, 1});
    };
    const torch::Tensor style_loss =
        torch::nn::functional::cross_entropy(style(with_offset(kStyleOffset)), style_label);
    const torch::Tensor content_loss =
        torch::nn::functional::cross_entropy(content(with_offset(kContentOffset)), content_label);
    const torch::Tensor r = Rotations(windows);
    const torch::Tensor corrupt = r + kRotationNoise * torch::randn_like(r) - RotationMean();
    const torch::Tensor decoded =
        encoder->decoder->forward(encoder->encoder->forward(corrupt)) + RotationMean();
    const torch::Tensor encoder_loss = QuaternionLoss(r, decoded);

    optimizer.zero_grad();
    (style_loss + content_loss + encoder_loss).backward();
    optimizer.step();
    if ((i + 1) % 250 == 0) {
      const double seconds =
          std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
      std::fprintf(stderr,
                   "judges: %d of %d, style %.3f, content %.3f, encoder %.4f, %.0f s left\n", i + 1,
                   settings.iterations, style_loss.item<double>(), content_loss.item<double>(),
                   encoder_loss.item<double>(), seconds / (i + 1) * (settings.iterations - i - 1));
    }
  }
}

Judges::Judges(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Judges::~Judges() = default;
Judges::Judges(Judges&&) noexcept = default;
Judges& Judges::operator=(Judges&&) noexcept = default;
const JudgeSettings& Judges::settings() const { return impl_->settings; }
const erd::FeatureParameters& Judges::parameters() const { return impl_->feature_parameters; }

Result<Judges> Judges::TrainOrLoad(const std::vector<train::TrainingClip>& clips, int styles,
                                   int contents, const JudgeSettings& settings,
                                   const std::filesystem::path& cache, const std::string& key) {
  torch::set_num_threads(1);
  torch::manual_seed(settings.seed);
  const std::filesystem::path file = cache / ("judges-" + key + ".pt");
  try {
    auto impl = std::make_unique<Impl>(styles, contents, settings);
    if (std::filesystem::exists(file)) {
      torch::serialize::InputArchive archive;
      archive.load_from(file.string());
      impl->load(archive);
      impl->SetParameters();
    } else {
      const train::FeatureStatistics statistics =
          train::ComputeStatistics(clips, impl->feature_parameters);
      for (int i = 0; i < erd::kFeatureCount; ++i) {
        impl->mean[0][i][0] = statistics.mean[i];
        impl->deviation[0][i][0] = statistics.deviation[i];
      }
      impl->SetParameters();
      std::vector<Sequence> sequences;
      for (const train::TrainingClip& clip : clips) {
        for (const bool mirrored : {false, true}) {
          sequences.push_back(MakeSequence(clip.poses, clip.style, clip.content, mirrored,
                                           impl->feature_parameters));
        }
      }
      impl->Train(sequences, styles, contents);
      std::filesystem::create_directories(cache);
      torch::serialize::OutputArchive archive;
      impl->save(archive);
      const std::filesystem::path part = file.string() + ".part";
      archive.save_to(part.string());
      std::filesystem::rename(part, file);
    }
    impl->eval();
    return Judges(std::move(impl));
  } catch (const std::exception& error) {
    return Status::Error(file.string() + ": " + error.what());
  }
}

namespace {

torch::Tensor Windows(const Sequence& sequence, std::span<const int> starts, int length) {
  torch::Tensor windows =
      torch::empty({static_cast<long>(starts.size()), length, erd::kFeatureCount});
  float* out = windows.data_ptr<float>();
  for (const int start : starts) {
    for (int t = 0; t < length; ++t, out += erd::kFeatureCount) {
      std::copy(sequence.frames[start + t].begin(), sequence.frames[start + t].end(), out);
    }
  }
  return windows;
}

std::vector<int> Answers(const torch::Tensor& logits) {
  const torch::Tensor best = logits.argmax(1).contiguous();
  return {best.data_ptr<std::int64_t>(), best.data_ptr<std::int64_t>() + best.numel()};
}

}  // namespace

std::vector<int> Judges::JudgeStyle(const Sequence& sequence, int window) const {
  torch::NoGradGuard no_grad;
  std::vector<int> starts(
      static_cast<std::size_t>(std::max(0, static_cast<int>(sequence.frames.size()) - window + 1)));
  std::iota(starts.begin(), starts.end(), 0);
  if (starts.empty()) return {};
  return Answers(impl_->style(impl_->Standardize(Windows(sequence, starts, window))));
}

Verdicts Judges::Judge(const Sequence& sequence, int stride) const {
  torch::NoGradGuard no_grad;
  const int window = impl_->settings.window;
  Verdicts verdicts;
  const int last = static_cast<int>(sequence.frames.size()) - window;
  for (int start = 0; start <= last; start += stride) verdicts.starts.push_back(start);
  const long count = static_cast<long>(verdicts.starts.size());
  if (count == 0) return verdicts;

  const torch::Tensor windows = Windows(sequence, verdicts.starts, window);
  const torch::Tensor x = impl_->Standardize(windows);
  verdicts.style = Answers(impl_->style(x));
  verdicts.content = Answers(impl_->content(x));
  const torch::Tensor embedding =
      impl_->encoder->encoder->forward(impl_->Rotations(windows) - impl_->RotationMean())
          .mean(2)
          .to(torch::kDouble)
          .contiguous();
  verdicts.embedding =
      Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>(
          embedding.data_ptr<double>(), count, embedding.size(1));
  return verdicts;
}

}  // namespace styled::judge
