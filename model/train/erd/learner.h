#pragma once

#include <torch/torch.h>

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "model/base/status.h"
#include "model/clip/manifest.h"
#include "model/train/adam.h"
#include "model/train/checkpoint.h"
#include "model/train/dataset.h"
#include "model/train/erd/moments.h"
#include "model/train/erd/networks.h"
#include "model/train/sampler.h"
#include "model/train/trainer.h"

namespace styled::train {

// Sums of losses, kept on the device so that the log is the only place that waits for it.
class Tally {
 public:
  void Add(const std::string& name, const torch::Tensor& value);
  // The means over `count` iterations, in the order of the first Add; starts anew.
  std::vector<std::pair<std::string, double>> Take(int count);

 private:
  std::vector<std::pair<std::string, torch::Tensor>> sums_;
};

// What a teacher teaches: the changes to and from a style, made `gain` times as large on the way to
// it.
struct Lesson {
  std::string style;
  std::string content;  // only in windows of this one; empty: in all
  double gain = 1;
};

// The networks being trained, their optimizers, and one iteration of training (style-ERD, section
// 3.2 of the paper). Knows nothing of files, logs and clocks. `config`, `manifest` and `clips` must
// outlive it. One thread.
class Learner {
 public:
  Learner(const TrainConfig& config, const clip::Manifest& manifest,
          const std::vector<TrainingClip>& clips, const FeatureStatistics& statistics,
          const erd::FeatureParameters& parameters, const torch::Device& device);

  // Starts from trained weights instead of random ones: what the styles share, and the branches of
  // those that `weights` has by name. Another style starts as a copy of the one whose branch
  // reconstructs it best. The statistics must be those of `weights`.
  Status Adopt(const LoadedWeights& weights);
  // From now on changes of style are also compared (w_teacher) with what `weights` make of the same
  // window, unspoilt: those that `lessons` say, or, where there are none, all that both have. Of
  // what one says, earlier teachers and lessons no longer count. The statistics must be the run's.
  Status LearnFrom(const LoadedWeights& weights, const std::vector<Lesson>& lessons);
  // What idle windows (config.idle) need: a manifest and clips that have it. Before LearnFrom.
  Status ExpectIdle();
  // Trains the content classifier on real windows of all styles, then freezes it.
  void TrainClassifier();
  // One iteration, critic first. `progress` 0..1 decides learning rates and the smoothness term.
  void Step(double progress);

  // Everything that the next Step depends on. Restore refuses a checkpoint of other statistics or
  // another batch; it may then be half restored.
  void Save(Checkpoint& checkpoint) const;
  Status Restore(const Checkpoint& checkpoint);

  bool Finite() const;
  int64_t iteration() const { return iteration_; }
  const Generator& average() const { return average_; }  // running mean of the weights
  const torch::Tensor& mean() const { return mean_; }
  const torch::Tensor& deviation() const { return deviation_; }
  Tally& tally() { return tally_; }

 private:
  // A batch as tensors on the device, time-major: T = window + 1 frames (velocities need one more
  // than is judged), B slots.
  struct Batch {
    torch::Tensor features, yaw_change_rad, hips_step_m;  // [T, B, 211], [T, B], [T, B, 3]
    torch::Tensor u;                                      // standardized features
    torch::Tensor seen;  // the same as the generator sees them: some from badly calibrated rigs
    torch::Tensor rotations, positions;  // views of features, [T, B, 21, 4 or 3]
    torch::Tensor content;               // [B, contents] one-hot
    torch::Tensor carried, idle;         // [B] bool
    torch::Tensor paired;  // [B] 1 where the critic knows real motion of that style and content
  };
  // What the generator makes of a batch.
  struct Generated {
    torch::Tensor rec, rec_positions;          // D(own style), [T, B, 21, 4 or 3]
    torch::Tensor rec_velocities, rec_height;  // the heads, standardized
    torch::Tensor change;                      // rec⁻¹ ∘ sty, [T, B, 21, 4]
    torch::Tensor rotations;                   // transferred, in the form that is judged
    torch::Tensor fake;                        // transferred, as the critic sees it
  };

  struct Teacher {
    std::unique_ptr<Generator> generator;  // its styles are ours
    Carried carried;
    torch::Tensor gain;  // [B, contents] what this one teaches of the slot's style, 0: nothing
    // Of its changes to a style in windows of idle_as: the sum of rotation vectors, [styles, 21,
    // 3], and their number. Undefined without idle windows.
    torch::Tensor mean_sum, mean_count;
  };

  Batch MakeBatch(const std::vector<Sampler::Window>& windows) const;
  torch::Tensor Spoil(const torch::Tensor& u) const;
  std::vector<int64_t> NearestStyles(const Generator& from) const;
  void FreezeAllButTheStyles();
  void StartFromZeros();
  torch::Tensor Judged(const torch::Tensor& positions, const torch::Tensor& velocities) const;
  torch::Tensor Real(const Batch& batch) const;
  Generated Generate(const Batch& batch);
  torch::Tensor PairedMean(const Batch& batch, const torch::Tensor& score) const;
  void StepCritic(const Batch& batch, const torch::Tensor& fake, double rate);
  torch::Tensor Reconstruction(const Batch& batch, const Generated& generated);
  torch::Tensor Perceptual(const Batch& batch, const Generated& generated) const;
  torch::Tensor MomentMatching(const Batch& batch, const Generated& generated);
  torch::Tensor Smoothness(const Generated& generated);
  torch::Tensor Teaching(const Batch& batch, const Generated& generated);
  void TeachIdle(const Batch& batch, Teacher& teacher, torch::Tensor& wanted,
                 torch::Tensor& gain) const;
  void UpdateAverage();

  const TrainConfig& config_;
  const clip::Manifest& manifest_;
  const std::vector<TrainingClip>& clips_;
  erd::FeatureParameters parameters_;
  torch::Device device_;
  torch::Tensor mean_, deviation_;
  int64_t frames_;

  Sampler sampler_;
  Moments moments_;
  Generator generator_, average_;
  Critic critic_;
  ContentClassifier classifier_;
  Adam generator_adam_, critic_adam_;

  torch::Tensor trained_;  // 1 where a parameter is trained; undefined: all
  Slots slots_;
  Carried carried_;
  std::vector<Teacher> teachers_;
  int64_t idle_as_ = -1;  // a content
  int64_t iteration_ = 0;
  Tally tally_;
};

}  // namespace styled::train
