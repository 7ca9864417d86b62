#include "model/train/judge/parts.h"

#include <torch/torch.h>

#include <cstdio>

#include "model/train/judge/classifier.h"

namespace styled::judge {
namespace {

using namespace body;  // NOLINT: the joints

constexpr std::array kAll{kSpine,         kChest,         kNeck,          kHead,
                          kLeftShoulder,  kLeftUpperArm,  kLeftLowerArm,  kLeftHand,
                          kRightShoulder, kRightUpperArm, kRightLowerArm, kRightHand,
                          kLeftUpperLeg,  kLeftLowerLeg,  kLeftFoot,      kLeftToes,
                          kRightUpperLeg, kRightLowerLeg, kRightFoot,     kRightToes};

template <std::size_t kCount, std::size_t kFrom>
constexpr std::array<int, kCount> Joints() {
  std::array<int, kCount> joints{};
  for (std::size_t i = 0; i < kCount; ++i) joints[i] = kAll[kFrom + i];
  return joints;
}
constexpr auto kBody = Joints<20, 0>();
constexpr auto kTrunk = Joints<4, 0>();
constexpr auto kArms = Joints<8, 4>();
constexpr auto kLegs = Joints<8, 12>();

// The smallest deviation by which a view is standardized: nearly constant values must not be
// enlarged.
constexpr float kLeastDeviation_m = 0.005F;
// Both in deviations of the view, during training: noise on every frame, and on each window of the
// judges of a pose a constant offset (see kStyleOffset in nets.cpp). Noise of 0.15, as the
// judges of all features have, hides how legs move in gestures: on real clips of bandai-2's
// validation split the legs' movement is recognized in 0.76 with 0.15, 0.80 with 0.05, 0.84 with
// 0.02, and the constant offset in 0.12, 0.12, 0.09. Poses of legs with an offset of 0.5: 0.94,
// of 0.25: 0.99.
constexpr float kPartNoise = 0.02F;
constexpr float kPoseOffset = 0.25F;
constexpr int kStatisticsBatches = 32;

}  // namespace

const std::array<PartView, kPartViewCount>& PartViews() {
  static const std::array<PartView, kPartViewCount> views{{
      {"movement", "movement", kBody, kHips, true, true},
      {"legs_pose", "legs, pose", kLegs, kHips, false, false},
      {"legs_movement", "legs, movement", kLegs, kHips, false, true},
      {"arms_pose", "arms, pose", kArms, kChest, false, false},
      {"arms_movement", "arms, movement", kArms, kChest, false, true},
      {"trunk_pose", "trunk, pose", kTrunk, kHips, false, false},
      {"trunk_movement", "trunk, movement", kTrunk, kHips, false, true},
  }};
  return views;
}

namespace {

// One view's classifier.
struct ViewJudgeImpl : torch::nn::Module {
  ViewJudgeImpl(const PartView& of, int styles) : view(of) {
    std::vector<std::int64_t> taken;
    std::vector<std::int64_t> origins;
    for (const int joint : view.joints) {
      for (int axis = 0; axis < 3; ++axis) {
        taken.push_back(erd::kPositionBegin + 3 * joint + axis);
        origins.push_back(erd::kPositionBegin + 3 * view.origin + axis);
      }
    }
    if (view.height) {
      // The hips' own position is zero in the features, so it subtracts nothing.
      taken.push_back(erd::kHipsHeightIndex);
      origins.push_back(erd::kPositionBegin + 3 * kHips);
    }
    const long count = static_cast<long>(taken.size());
    columns = torch::tensor(taken, torch::kLong);
    origin_columns = torch::tensor(origins, torch::kLong);
    mean = register_buffer("mean", torch::zeros({1, count, 1}));
    deviation = register_buffer("deviation", torch::ones({1, count, 1}));
    classifier = register_module("classifier", Classifier(static_cast<int>(count), styles));
  }

  // The view of windows' features, [N, T, F] to [N, columns, T], metres.
  torch::Tensor See(const torch::Tensor& windows) const {
    const torch::Tensor seen =
        (windows.index_select(2, columns) - windows.index_select(2, origin_columns))
            .transpose(1, 2);
    return view.movement ? seen - seen.mean(2, true) : seen;
  }
  torch::Tensor Standardize(const torch::Tensor& seen) const { return (seen - mean) / deviation; }

  PartView view;
  torch::Tensor columns, origin_columns, mean, deviation;
  Classifier classifier{nullptr};
};
TORCH_MODULE(ViewJudge);

}  // namespace

struct PartJudges::Impl : torch::nn::Module {
  Impl(int styles, const JudgeSettings& s) : settings(s) {
    parameters_of_features.rate_hz = static_cast<float>(kJudgeRate_hz);
    for (const PartView& view : PartViews()) {
      views.push_back(register_module(std::string(view.key), ViewJudge(view, styles)));
    }
  }

  void TrainOn(const std::vector<train::TrainingClip>& clips, int styles, int contents);
  void Train(const std::vector<Sequence>& sequences, int styles, int contents);

  JudgeSettings settings;
  erd::FeatureParameters parameters_of_features;
  mutable std::vector<ViewJudge> views;
};

void PartJudges::Impl::Train(const std::vector<Sequence>& sequences, int styles, int contents) {
  const int batch = settings.batch;
  WindowSampler sampler(sequences, styles, contents, settings.window, settings.seed);
  torch::Tensor windows = torch::empty({batch, settings.window, erd::kFeatureCount});
  torch::Tensor label = torch::empty({batch}, torch::kLong);
  torch::Tensor content = torch::empty({batch}, torch::kLong);
  const auto draw = [&] {
    sampler.Fill(batch, windows.data_ptr<float>(), label.data_ptr<std::int64_t>(),
                 content.data_ptr<std::int64_t>());
  };
  std::vector<torch::Tensor> batches;
  for (int i = 0; i < kStatisticsBatches; ++i) {
    draw();
    batches.push_back(windows.clone());
  }
  const torch::Tensor drawn = torch::cat(batches);
  const std::vector<std::int64_t> over{0, 2};  // windows and frames
  for (ViewJudge& view : views) {
    const torch::Tensor seen = view->See(drawn);
    view->mean.copy_(seen.mean(over, true));
    view->deviation.copy_(
        (seen - view->mean).square().mean(over, true).sqrt().clamp_min(kLeastDeviation_m));
  }

  train();
  std::vector<torch::Tensor> losses(views.size());
  const auto loss = [&] {
    draw();
    torch::Tensor sum = torch::zeros({});
    for (std::size_t i = 0; i < views.size(); ++i) {
      ViewJudge& view = views[i];
      torch::Tensor x = view->Standardize(view->See(windows));
      x = x + kPartNoise * torch::randn_like(x);
      if (!view->view.movement) x = x + kPoseOffset * torch::randn({x.size(0), x.size(1), 1});
      losses[i] = torch::nn::functional::cross_entropy(view->classifier(x), label);
      sum = sum + losses[i];
    }
    return sum;
  };
  const auto state = [&] {
    std::string text;
    for (std::size_t i = 0; i < views.size(); ++i) {
      char one[64];
      std::snprintf(one, sizeof one, "%s%s %.2f", i > 0 ? "; " : "",
                    std::string(views[i]->view.title).c_str(), losses[i].item<double>());
      text += one;
    }
    return text;
  };
  Optimize("judges of parts of seed " + std::to_string(settings.seed),
           torch::nn::Module::parameters(), settings.iterations, loss, state);
}

void PartJudges::Impl::TrainOn(const std::vector<train::TrainingClip>& clips, int styles,
                               int contents) {
  Train(MakeSequences(clips, parameters_of_features), styles, contents);
}

PartJudges::PartJudges(const JudgeSettings& settings) : settings_(settings) {}
PartJudges::~PartJudges() = default;
PartJudges::PartJudges(PartJudges&&) noexcept = default;
PartJudges& PartJudges::operator=(PartJudges&&) noexcept = default;

Result<PartJudges> PartJudges::TrainOrLoad(const std::vector<train::TrainingClip>& clips,
                                           int styles, int contents, const JudgeSettings& settings,
                                           const std::filesystem::path& cache,
                                           const std::string& key) {
  torch::set_num_threads(1);
  PartJudges judges(settings);
  for (const JudgeSettings& one : EachSeed(settings)) {
    torch::manual_seed(one.seed);
    const std::filesystem::path file = CacheFile(cache, "parts", key, one.seed);
    try {
      auto impl = std::make_unique<Impl>(styles, one);
      if (std::filesystem::exists(file)) {
        torch::serialize::InputArchive archive;
        archive.load_from(file.string());
        impl->load(archive);
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

PartJudges PartJudges::Read(net::TensorReader& tensors, int styles, const JudgeSettings& settings) {
  PartJudges judges(settings);
  for (const JudgeSettings& one : EachSeed(settings)) {
    auto impl = std::make_unique<Impl>(styles, one);
    ReadTensors(*impl, std::to_string(one.seed) + ".parts.", tensors);
    impl->eval();
    judges.judges_.push_back(std::move(impl));
  }
  return judges;
}

std::vector<net::NamedTensor> PartJudges::Tensors() const {
  std::vector<net::NamedTensor> tensors;
  for (const auto& judge : judges_) {
    AppendTensors(*judge, std::to_string(judge->settings.seed) + ".parts.", tensors);
  }
  return tensors;
}

std::vector<PartJudges::Answers> PartJudges::Judge(std::span<const Pose> poses, int stride) const {
  torch::NoGradGuard no_grad;
  const Sequence sequence =
      MakeSequence(poses, 0, 0, false, judges_.front()->parameters_of_features);
  const std::vector<int> starts = WindowStarts(sequence, settings_.window, stride);
  std::vector<Answers> by_judge(judges_.size());
  if (starts.empty()) return by_judge;
  const torch::Tensor windows = Windows(sequence, starts, settings_.window);
  for (std::size_t j = 0; j < judges_.size(); ++j) {
    for (std::size_t i = 0; i < kPartViewCount; ++i) {
      ViewJudge& view = judges_[j]->views[i];
      by_judge[j][i] = judge::Answers(view->classifier(view->Standardize(view->See(windows))));
    }
  }
  return by_judge;
}

}  // namespace styled::judge
