#pragma once

#include <torch/torch.h>

#include <cstdint>
#include <functional>
#include <random>
#include <span>
#include <string>
#include <vector>

#include "model/net/weights_file.h"
#include "model/train/judge/nets.h"

namespace styled::judge {

// The shared part of the judges: a classifier of windows, the drawing of windows, and the training.
// Internal: of all headers of this folder only this one and auto_encoder.h use libtorch.

inline constexpr float kFeatureNoise = 0.15F;  // on standardized features, during training

// Windows of standardized features, [N, features, T], to logits, [N, classes]: 1-D convolutions,
// then mean and maximum over time.
struct ClassifierImpl : torch::nn::Module {
  ClassifierImpl(int features, int classes);
  // The last layer's input: mean and maximum over time, [N, 256].
  torch::Tensor Pool(const torch::Tensor& x);
  torch::Tensor forward(const torch::Tensor& x);

  torch::nn::Sequential layers{nullptr};
  torch::nn::Linear head{nullptr};
};
TORCH_MODULE(Classifier);

// Draws windows: styles with equal probability, then contents within the style, then clips. The
// sequences must outlive this object.
class WindowSampler {
 public:
  WindowSampler(const std::vector<Sequence>& sequences, int styles, int contents, int window,
                unsigned seed);
  // Writes `count` windows as [count, window, features] with their labels.
  void Fill(int count, float* out, std::int64_t* style, std::int64_t* content);

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

// Trains `parameters` for `iterations` steps of AdamW: linear warm-up over a tenth of them, then
// cosine decay to zero. `loss` draws a batch and returns its loss; `state` returns the progress for
// the lines on stderr, which begin with `name`.
void Optimize(const std::string& name, const std::vector<torch::Tensor>& parameters, int iterations,
              const std::function<torch::Tensor()>& loss,
              const std::function<std::string()>& state);

// The settings of each judge: `count` is 1, seeds one after the other.
std::vector<JudgeSettings> EachSeed(const JudgeSettings& settings);
// The file of one judge in a cache.
std::filesystem::path CacheFile(const std::filesystem::path& cache, const std::string& kind,
                                const std::string& key, unsigned seed);

// The clips and their mirror images, as sequences.
std::vector<Sequence> MakeSequences(const std::vector<train::TrainingClip>& clips,
                                    const erd::FeatureParameters& parameters);

// Every `stride`-th frame at which a window of `length` frames begins.
std::vector<int> WindowStarts(const Sequence& sequence, int length, int stride);
// Windows of a sequence as [starts, length, features].
torch::Tensor Windows(const Sequence& sequence, std::span<const int> starts, int length);

// The class with the largest logit, per row.
std::vector<int> Answers(const torch::Tensor& logits);

// A matrix of libtorch as Eigen's.
Eigen::MatrixXd Rows(const torch::Tensor& matrix);

// Writes `module` to `file` through a temporary file, so that none is ever incomplete. Throws.
void SaveModule(const torch::nn::Module& module, const std::filesystem::path& file);

// A trained module's parameters and buffers as tensors of a file, their names after `prefix`, and
// back. Without decoders and batches' counters, which only training needs.
void AppendTensors(torch::nn::Module& module, const std::string& prefix,
                   std::vector<net::NamedTensor>& tensors);
void ReadTensors(torch::nn::Module& module, const std::string& prefix, net::TensorReader& tensors);

}  // namespace styled::judge
