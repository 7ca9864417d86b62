#pragma once

#include <torch/torch.h>

#include <array>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "model/base/status.h"
#include "model/clip/manifest.h"
#include "model/net/erd/features.h"
#include "model/train/adam.h"
#include "model/train/checkpoint.h"
#include "model/train/dataset.h"
#include "model/train/erd/batch.h"
#include "model/train/erd/config.h"
#include "model/train/erd/distillation.h"
#include "model/train/erd/moments.h"
#include "model/train/erd/networks.h"
#include "model/train/erd/weights.h"
#include "model/train/means.h"
#include "model/train/one_ahead.h"
#include "model/train/recipe.h"
#include "model/train/recorded_work.h"
#include "model/train/sampler.h"

namespace styled::train::style_erd {

// Numbers of a frame's first features that are the input of the critic, and of the classifier of
// contents.
inline constexpr int64_t kJudgedFeatures = erd::kPositionFeatures + erd::kVelocityFeatures;
inline constexpr int64_t kContentFeatures = erd::kRotationFeatures + kJudgedFeatures;

// A learner's training data. All of it must outlive the learner.
struct LearnerData {
  const clip::Manifest& manifest;
  const std::vector<TrainingClip>& clips;
  const FeatureStatistics& statistics;
  const erd::FeatureParameters& parameters;
  // Of the generator; its number of styles is the manifest's.
  const GeneratorShape& shape;
};

// The networks being trained, their optimizers, and one iteration of training (Style-ERD, section
// 3.2 of the paper). Knows nothing of files, logs and clocks. `config` must outlive it. One thread.
class Learner {
 public:
  Learner(const Config& config, uint64_t seed, const LearnerData& data,
          const torch::Device& device);

  // Starts from trained weights instead of random ones: the part shared by all styles, and the
  // branches of those that `weights` has by name. Another style starts as a copy of the one whose
  // branch reconstructs it best. The statistics must be those of `weights`.
  Status StartFrom(const LoadedWeights& weights);
  // From now on teaches the output of `weights` for the same windows (Distillation::Add).
  Status AddTeacher(const LoadedWeights& weights, const std::vector<Lesson>& lessons);
  Status AddTeacher(const net::ClipStylizer& network, const std::vector<Lesson>& lessons);
  // Trains the content classifier on real windows of all styles, then freezes it.
  void TrainClassifier();
  // One iteration, critic first. `progress` in [0, 1] decides learning rates and the smoothness.
  void Step(double progress);

  // Everything that the next Step depends on. Restore refuses a checkpoint of other statistics or
  // another batch, and leaves the learner unusable then.
  void Save(Checkpoint& checkpoint) const;
  Status Restore(const Checkpoint& checkpoint);

  bool Finite() const;
  int64_t iteration() const { return iteration_; }
  const Generator& average() const { return average_; }  // running mean of the weights
  const torch::Tensor& mean() const { return mean_; }    // [211], of the features
  const torch::Tensor& deviation() const { return deviation_; }
  bool HasIdleFrames() const { return sampler_.HasIdleFrames(); }
  Means& means() { return means_; }

 private:
  // The generator's output for a batch.
  struct Generated {
    torch::Tensor rec, rec_positions;          // D(input style), [T, B, 21, 4 or 3]
    torch::Tensor rec_velocities, rec_height;  // the heads, standardized
    torch::Tensor change;                      // rec⁻¹ ∘ sty, [T, B, 21, 4]
    torch::Tensor positions;                   // of the input so changed, if taught, [T, B, 21, 3]
    torch::Tensor rise_m;                      // of the hips by the height heads, [T, B]
    torch::Tensor rotations;                   // transferred, in the form that is judged
    torch::Tensor fake;                        // transferred, as the critic sees it
    torch::Tensor recognition;                 // the recognizer's loss; undefined without one
  };
  // The recordings of an iteration, and what the first part leaves to the second.
  struct Recorded {
    RecordedWork critic, generator;
    Generated made;
  };

  // learner_start.cpp
  std::vector<int64_t> NearestStyles(const Generator& from) const;
  void FreezeAllButTheStyles();
  void StartFromZeros();

  // learner.cpp
  Slots FixedSlots() const;
  OneAhead<Batch>::Made MakeBatch(int64_t iteration);
  void DrawContentSources(int64_t iteration, Batch& batch) const;
  const Batch& NextBatch();
  bool Penalized() const;
  void Run(RecordedWork& recorded, const std::function<void()>& work);
  Generated Generate(const Batch& batch);
  ContentInput Contents(const Batch& batch, Carried& carried, Generated& out);
  // The gradients of the critic, and of the generator from all losses that have a weight.
  void TeachCritic(const Batch& batch, const torch::Tensor& fake);
  void TeachGenerator(const Batch& batch, const Generated& generated);
  void UpdateAverage();

  // losses.cpp
  torch::Tensor Judged(const torch::Tensor& positions, const torch::Tensor& velocities) const;
  torch::Tensor Real(const Batch& batch) const;
  torch::Tensor PairedMean(const Batch& batch, const torch::Tensor& score) const;
  torch::Tensor Reconstruction(const Batch& batch, const Generated& generated);
  torch::Tensor SummedReconstruction(const Batch& batch, const Generated& generated);
  torch::Tensor Adversarial(const Batch& batch, const Generated& generated);
  torch::Tensor Perceptual(const Batch& batch, const Generated& generated) const;
  torch::Tensor MomentMatching(const Batch& batch, const Generated& generated);
  torch::Tensor Smoothness(const Generated& generated);
  torch::Tensor Teaching(const Batch& batch, const Generated& generated);
  torch::Tensor OnHemisphere(const torch::Tensor& rotations) const;

  const Config& config_;
  const clip::Manifest& manifest_;
  const std::vector<TrainingClip>& clips_;
  uint64_t seed_;
  torch::Device device_;
  torch::Tensor mean_, deviation_;
  int64_t frames_;  // T of a batch: judged frames and one before

  Sampler sampler_;
  BatchMaker batches_;
  Moments moments_;
  Generator generator_, average_;
  Critic critic_;
  ContentClassifier classifier_;
  Adam generator_adam_, critic_adam_;

  torch::Tensor trained_;  // 1 where a parameter is trained; undefined: all
  Slots slots_;            // of each batch, on the device; with pairs of the first
  Carried carried_;
  std::optional<Distillation> teachers_;  // once the slots are known
  torch::Tensor w_smooth_;                // of now, a scalar on the device
  int64_t iteration_ = 0;
  Means means_;
  const bool records_;                // whether iterations are recorded and launched as a whole
  std::array<Recorded, 2> recorded_;  // by whether the critic is penalized
  Batch batch_;                       // on the device
  OneAhead<Batch> ahead_;             // destroyed first: it uses the others
};

}  // namespace styled::train::style_erd
