#include "model/train/judge/classifier.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>

namespace styled::judge {
namespace {

constexpr float kDropout = 0.3F;
constexpr float kRate = 1e-3F;
constexpr float kWeightDecay = 1e-3F;
constexpr int kSayEvery = 250;  // iterations

}  // namespace

ClassifierImpl::ClassifierImpl(int features, int classes) {
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

torch::Tensor ClassifierImpl::Pool(const torch::Tensor& x) {
  const torch::Tensor m = layers->forward(x);
  return torch::cat({m.mean(2), std::get<0>(m.max(2))}, 1);
}

torch::Tensor ClassifierImpl::forward(const torch::Tensor& x) {
  return head(torch::dropout(Pool(x), kDropout, is_training()));
}

WindowSampler::WindowSampler(const std::vector<Sequence>& sequences, int styles, int contents,
                             int window, unsigned seed)
    : sequences_(sequences), window_(window), random_(seed) {
  std::vector<std::vector<std::vector<int>>> cells(styles, std::vector<std::vector<int>>(contents));
  for (std::size_t i = 0; i < sequences.size(); ++i) {
    if (static_cast<int>(sequences[i].frames.size()) < window) continue;
    cells[sequences[i].style][sequences[i].content].push_back(static_cast<int>(i));
  }
  for (auto& style : cells) {
    std::erase_if(style, [](const std::vector<int>& cell) { return cell.empty(); });
    if (!style.empty()) cells_.push_back(std::move(style));
  }
}

void WindowSampler::Fill(int count, float* out, std::int64_t* style, std::int64_t* content) {
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

void Optimize(const std::string& name, const std::vector<torch::Tensor>& parameters, int iterations,
              const std::function<torch::Tensor()>& loss,
              const std::function<std::string()>& state) {
  torch::optim::AdamW optimizer(parameters,
                                torch::optim::AdamWOptions(kRate).weight_decay(kWeightDecay));
  const auto begin = std::chrono::steady_clock::now();
  for (int i = 0; i < iterations; ++i) {
    const double done = static_cast<double>(i) / iterations;
    const double rate = kRate * std::min(1.0, done / 0.1) * 0.5 * (1 + std::cos(M_PI * done));
    for (auto& group : optimizer.param_groups()) {
      static_cast<torch::optim::AdamWOptions&>(group.options()).lr(rate);
    }
    const torch::Tensor of_batch = loss();
    optimizer.zero_grad();
    of_batch.backward();
    optimizer.step();
    if ((i + 1) % kSayEvery != 0) continue;
    const double seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    std::fprintf(stderr, "%s: %d of %d, %s, %.0f s left\n", name.c_str(), i + 1, iterations,
                 state().c_str(), seconds / (i + 1) * (iterations - i - 1));
  }
}

std::vector<JudgeSettings> EachSeed(const JudgeSettings& settings) {
  std::vector<JudgeSettings> each(static_cast<std::size_t>(settings.count), settings);
  for (std::size_t i = 0; i < each.size(); ++i) {
    each[i].seed = settings.seed + static_cast<unsigned>(i);
    each[i].count = 1;
  }
  return each;
}

std::filesystem::path CacheFile(const std::filesystem::path& cache, const std::string& kind,
                                const std::string& key, unsigned seed) {
  return cache / (kind + "-" + key + "-seed-" + std::to_string(seed) + ".pt");
}

std::vector<Sequence> MakeSequences(const std::vector<train::TrainingClip>& clips,
                                    const erd::FeatureParameters& parameters) {
  std::vector<Sequence> sequences;
  for (const train::TrainingClip& clip : clips) {
    for (const bool mirrored : {false, true}) {
      sequences.push_back(MakeSequence(clip.poses, clip.style, clip.content, mirrored, parameters));
    }
  }
  return sequences;
}

std::vector<int> WindowStarts(const Sequence& sequence, int length, int stride) {
  std::vector<int> starts;
  const int last = static_cast<int>(sequence.frames.size()) - length;
  for (int start = 0; start <= last; start += stride) starts.push_back(start);
  return starts;
}

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

Eigen::MatrixXd Rows(const torch::Tensor& matrix) {
  const torch::Tensor flat = matrix.to(torch::kDouble).contiguous();
  return Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>(
      flat.data_ptr<double>(), flat.size(0), flat.size(1));
}

void SaveModule(const torch::nn::Module& module, const std::filesystem::path& file) {
  std::filesystem::create_directories(file.parent_path());
  torch::serialize::OutputArchive archive;
  module.save(archive);
  const std::filesystem::path part = file.string() + ".part";
  archive.save_to(part.string());
  std::filesystem::rename(part, file);
}

namespace {

bool IsForTraining(const std::string& name) {
  return name.find(".decoder.") != std::string::npos ||
         name.find("num_batches_tracked") != std::string::npos;
}

template <typename Visit>
void ForEachTensor(torch::nn::Module& module, const Visit& visit) {
  for (const bool buffers : {false, true}) {
    for (auto& item : buffers ? module.named_buffers() : module.named_parameters()) {
      if (!IsForTraining(item.key())) visit(item.key(), item.value());
    }
  }
}

}  // namespace

void AppendTensors(torch::nn::Module& module, const std::string& prefix,
                   std::vector<net::NamedTensor>& tensors) {
  ForEachTensor(module, [&](const std::string& name, const torch::Tensor& tensor) {
    const torch::Tensor values = tensor.detach().contiguous();
    const float* const begin = values.data_ptr<float>();
    tensors.push_back({prefix + name, values.sizes().vec(), {begin, begin + values.numel()}});
  });
}

void ReadTensors(torch::nn::Module& module, const std::string& prefix, net::TensorReader& tensors) {
  torch::NoGradGuard no_grad;
  ForEachTensor(module, [&](const std::string& name, torch::Tensor tensor) {
    const net::RowMajor values = tensors.Tensor(prefix + name, tensor.sizes().vec());
    tensor.copy_(torch::from_blob(const_cast<float*>(values.data()), tensor.sizes()));
  });
}

}  // namespace styled::judge
