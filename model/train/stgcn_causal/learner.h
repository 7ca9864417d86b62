#pragma once

#include <torch/torch.h>

#include <cstdint>
#include <vector>

#include "model/base/status.h"
#include "model/train/checkpoint.h"
#include "model/train/recipe.h"
#include "model/train/stgcn/adam_with_decay.h"
#include "model/train/stgcn/learner.h"
#include "model/train/stgcn/windows.h"
#include "model/train/stgcn_causal/config.h"
#include "model/train/stgcn_causal/published_form.h"
#include "model/train/stgcn_causal/student.h"

namespace styled::train::st_gcn_causal {

// The network of whole clips that is the teacher. Its outputs are float32, without gradients.
class Teacher {
 public:
  // `codes` [n, code]: the mean code of each style; `singles` [n, m, code]: of its examples and
  // noises.
  Teacher(const st_gcn::Generator& generator, const torch::Tensor& codes,
          const torch::Tensor& singles, const torch::Device& device);

  // Its outputs for whole windows [B, 64, 21, 7] in the codes [n B, code], codes of all windows one
  // after the other.
  torch::Tensor operator()(const torch::Tensor& windows, const torch::Tensor& code) const;
  torch::Tensor CodeOf(const torch::Tensor& style) const;  // int64 [B] to [B, code]

  const st_gcn::Generator& generator() const { return generator_; }
  const torch::Tensor& codes() const { return codes_; }
  const torch::Tensor& singles() const { return singles_; }

 private:
  const st_gcn::Graph graph_;
  st_gcn::Generator generator_;
  torch::Tensor codes_, singles_;
};

// The mean size of a difference of two outputs [B, T, 21, 7]; the first frames, kFirst of them,
// count `first`, the others 1.
inline constexpr int64_t kFirst = 8;
torch::Tensor WeightedL1(const torch::Tensor& difference, double first);

// The student being trained, its optimizer, and one iteration of training: a regression on the
// teacher's output for the same window, in the code of the source's own style and in that of
// another. Knows nothing of files, logs and clocks. References must outlive it. One thread.
class Learner {
 public:
  // `styles`: of each style of `store`, the teacher's. `rate_hz`: of the windows.
  Learner(const Config& config, uint64_t seed, const st_gcn::WindowStore& store,
          std::vector<int64_t> styles, int contents, const Teacher& teacher,
          const PublishedForm& form, double rate_hz, const torch::Device& device);

  // The teacher's weights, and the start of the statistics by `start_windows` windows.
  void Start();
  // One iteration. `progress` in [0, 1] decides the learning rate.
  void Step(double progress);

  // Everything that the next Step depends on. Restore refuses a checkpoint of another teacher, and
  // leaves the learner unusable then.
  void Save(Checkpoint& checkpoint) const;
  Status Restore(const Checkpoint& checkpoint);

  bool Finite() const;
  int64_t iteration() const { return iteration_; }
  const Student& student() const { return student_; }
  const Student& average() const { return average_; }  // running mean of the weights
  const Graph& graph() const { return exact_graph_; }  // float32
  Means& means() { return means_; }
  bool HasAllStyles() const { return sampler_.HasAll(); }

 private:
  struct Batch {
    torch::Tensor source;  // [B, 64, 21, 7]
    torch::Tensor code;    // [2B, code]: of the sources' own styles, then of the targets
  };
  Batch NextBatch();
  torch::Tensor Wanted(const Batch& batch) const;  // of each code of the batch
  // The random part of a target besides its style.
  struct Target {
    float strength = 1;
    int64_t single = -1;  // of Teacher::singles, or -1: the style's mean
  };
  std::vector<Target> DrawTargets() const;  // [B]

  const Config& config_;
  const uint64_t seed_;
  const torch::Device device_;
  const st_gcn::WindowStore& store_;
  const std::vector<int64_t> styles_;
  const Teacher& teacher_;
  const PublishedForm& form_;
  const double lead_frames_;
  const Graph graph_, exact_graph_;
  st_gcn::Sampler sampler_;
  Student student_, average_;
  st_gcn::AdamWithDecay adam_;
  int64_t iteration_ = 0;
  Means means_;
};

}  // namespace styled::train::st_gcn_causal
