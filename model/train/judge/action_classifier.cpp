#include "model/train/judge/action_classifier.h"

#include <torch/torch.h>

#include <array>
#include <cstdio>

#include "model/net/sha256.h"
#include "model/net/stgcn/graph.h"
#include "model/train/judge/classifier.h"

namespace styled::judge {
namespace {

constexpr int kChannels = 6;  // of a joint: position and velocity
constexpr int kTimeTaps = 9;  // frames of a temporal convolution, as Yan et al.
constexpr double kBlockDropout = 0.3;
// Output channels and stride in time of each block.
struct BlockShape {
  int channels, stride;
};
constexpr std::array<BlockShape, 5> kBlocks{{{16, 1}, {16, 1}, {32, 2}, {32, 1}, {32, 2}}};

torch::Tensor AdjacencyOfSubsets() {  // [labels, from, to]
  const auto labels = stgcn::Adjacency(0, stgcn::Normalization::kSubset);
  torch::Tensor all = torch::zeros({stgcn::kLabelCount, body::kJointCount, body::kJointCount});
  auto out = all.accessor<float, 3>();
  for (int label = 0; label < stgcn::kLabelCount; ++label) {
    for (int from = 0; from < body::kJointCount; ++from) {
      for (int to = 0; to < body::kJointCount; ++to) out[label][from][to] = labels[label](from, to);
    }
  }
  return all;
}

// x [N, C, T, V]: a graph convolution, one over time, and the path around both.
struct BlockImpl : torch::nn::Module {
  BlockImpl(int in, BlockShape shape) {
    using namespace torch::nn;  // NOLINT
    graph = register_module("graph",
                            Conv2d(Conv2dOptions(in, stgcn::kLabelCount * shape.channels, {1, 1})));
    graph_norm = register_module("graph_norm", BatchNorm2d(shape.channels));
    time =
        register_module("time", Conv2d(Conv2dOptions(shape.channels, shape.channels, {kTimeTaps, 1})
                                           .stride({shape.stride, 1})
                                           .padding({kTimeTaps / 2, 0})));
    time_norm = register_module("time_norm", BatchNorm2d(shape.channels));
    if (in == shape.channels && shape.stride == 1) return;
    around = register_module(
        "around",
        Sequential(Conv2d(Conv2dOptions(in, shape.channels, {1, 1}).stride({shape.stride, 1})),
                   BatchNorm2d(shape.channels)));
  }

  torch::Tensor forward(const torch::Tensor& x, const torch::Tensor& adjacency) {
    const torch::Tensor parts =
        graph(x).view({x.size(0), stgcn::kLabelCount, -1, x.size(2), x.size(3)});
    torch::Tensor y;  // the sum over labels of parts times that label's matrix
    for (int label = 0; label < stgcn::kLabelCount; ++label) {
      const torch::Tensor mixed = torch::matmul(parts.select(1, label), adjacency[label]);
      y = label == 0 ? mixed : y + mixed;
    }
    y = time_norm(time(torch::relu(graph_norm(y))));
    y = torch::dropout(y, kBlockDropout, is_training());
    return torch::relu(y + (around ? around->forward(x) : x));
  }

  torch::nn::Conv2d graph{nullptr}, time{nullptr};
  torch::nn::BatchNorm2d graph_norm{nullptr}, time_norm{nullptr};
  torch::nn::Sequential around{nullptr};
};
TORCH_MODULE(Block);

}  // namespace

struct ActionClassifiers::Impl : torch::nn::Module {
  Impl(int contents, const JudgeSettings& s) : settings(s), adjacency(AdjacencyOfSubsets()) {
    feature_parameters.rate_hz = static_cast<float>(kJudgeRate_hz);
    input_norm = register_module(
        "input_norm", torch::nn::BatchNorm1d(kChannels * static_cast<int>(body::kJointCount)));
    int in = kChannels;
    for (std::size_t i = 0; i < kBlocks.size(); ++i) {
      blocks.push_back(register_module("block" + std::to_string(i), Block(in, kBlocks[i])));
      in = kBlocks[i].channels;
    }
    head = register_module("head", torch::nn::Linear(in, contents));
  }

  // Features [N, T, F] to the last pooling, [N, channels].
  torch::Tensor Pool(const torch::Tensor& windows) {
    const torch::Tensor positions =
        windows.slice(2, erd::kPositionBegin, erd::kPositionBegin + erd::kPositionFeatures).clone();
    // The hips lie at the origin of the heading frame: their height takes the place of their y.
    positions.select(2, 3 * body::kHips + 1).copy_(windows.select(2, erd::kHipsHeightIndex));
    const torch::Tensor velocities =
        windows.slice(2, erd::kVelocityBegin, erd::kVelocityBegin + erd::kVelocityFeatures);
    const std::int64_t count = windows.size(0), frames = windows.size(1);
    const torch::Tensor both = torch::cat({positions, velocities}, 2).transpose(1, 2);
    // Channels of the norm are axis by axis of each joint: [N, 2 x V x 3, T] to [N, 6, T, V].
    torch::Tensor x = input_norm(both)
                          .view({count, 2, body::kJointCount, 3, frames})
                          .permute({0, 1, 3, 4, 2})
                          .reshape({count, kChannels, frames, body::kJointCount});
    for (Block& block : blocks) x = block(x, adjacency);
    return x.mean({2, 3});
  }

  void TrainOn(const std::vector<train::TrainingClip>& clips, int styles, int contents);

  JudgeSettings settings;
  erd::FeatureParameters feature_parameters;
  torch::Tensor adjacency;
  torch::nn::BatchNorm1d input_norm{nullptr};
  std::vector<Block> blocks;
  torch::nn::Linear head{nullptr};
};

void ActionClassifiers::Impl::TrainOn(const std::vector<train::TrainingClip>& clips, int styles,
                                      int contents) {
  const std::vector<Sequence> sequences = MakeSequences(clips, feature_parameters);
  const int batch = settings.batch;
  WindowSampler sampler(sequences, styles, contents, settings.window, settings.seed);
  torch::Tensor windows = torch::empty({batch, settings.window, erd::kFeatureCount});
  torch::Tensor style = torch::empty({batch}, torch::kLong);
  torch::Tensor label = torch::empty({batch}, torch::kLong);
  train();
  torch::Tensor value;
  const auto loss = [&] {
    sampler.Fill(batch, windows.data_ptr<float>(), style.data_ptr<std::int64_t>(),
                 label.data_ptr<std::int64_t>());
    value = torch::nn::functional::cross_entropy(head(Pool(windows)), label);
    return value;
  };
  const auto state = [&] {
    char text[32];
    std::snprintf(text, sizeof text, "content %.3f", value.item<double>());
    return std::string(text);
  };
  Optimize("action classifier of seed " + std::to_string(settings.seed),
           torch::nn::Module::parameters(), settings.iterations, loss, state);
}

ActionClassifiers::ActionClassifiers(const JudgeSettings& settings) : settings_(settings) {}
ActionClassifiers::~ActionClassifiers() = default;
ActionClassifiers::ActionClassifiers(ActionClassifiers&&) noexcept = default;
ActionClassifiers& ActionClassifiers::operator=(ActionClassifiers&&) noexcept = default;
const erd::FeatureParameters& ActionClassifiers::parameters() const {
  return classifiers_.front()->feature_parameters;
}

Result<ActionClassifiers> ActionClassifiers::TrainOrLoad(
    const std::vector<train::TrainingClip>& clips, int styles, int contents,
    const JudgeSettings& settings, const std::filesystem::path& cache, const std::string& key) {
  torch::set_num_threads(1);
  ActionClassifiers all(settings);
  for (const JudgeSettings& one : EachSeed(settings)) {
    torch::manual_seed(one.seed);
    const std::filesystem::path file =
        CacheFile(cache, std::string("actions-") + kActionRecipe, key, one.seed);
    try {
      auto impl = std::make_unique<Impl>(contents, one);
      if (std::filesystem::exists(file)) {
        torch::serialize::InputArchive archive;
        archive.load_from(file.string());
        impl->load(archive);
      } else {
        impl->TrainOn(clips, styles, contents);
        SaveModule(*impl, file);
      }
      impl->eval();
      all.classifiers_.push_back(std::move(impl));
    } catch (const std::exception& error) {
      return Status::Error(file.string() + ": " + error.what());
    }
  }
  return all;
}

std::vector<ActionClassifiers::Verdicts> ActionClassifiers::Judge(const Sequence& sequence,
                                                                  int stride) const {
  torch::NoGradGuard no_grad;
  const std::vector<int> starts = WindowStarts(sequence, settings_.window, stride);
  std::vector<Verdicts> by_seed(classifiers_.size());
  if (starts.empty()) return by_seed;
  const torch::Tensor windows = Windows(sequence, starts, settings_.window);
  for (std::size_t i = 0; i < classifiers_.size(); ++i) {
    Impl& classifier = *classifiers_[i];
    const torch::Tensor pooled = classifier.Pool(windows);
    by_seed[i].content = Answers(classifier.head(pooled));
    by_seed[i].features = Rows(pooled);
  }
  return by_seed;
}

std::string ActionClassifiers::hash() const {
  std::vector<net::NamedTensor> tensors;
  for (const auto& classifier : classifiers_) {
    AppendTensors(*classifier, std::to_string(classifier->settings.seed) + ".", tensors);
  }
  return net::Sha256(net::SerializeSafetensors(tensors, {}));
}

}  // namespace styled::judge
