#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "model/train/judge/nets.h"

namespace styled::judge {

// As kJudgeRecipe, for these classifiers.
inline constexpr const char* kActionRecipe = "1";

// Classifiers of the content as Park et al. 2021 (section 7) measure it: spatio-temporal graph
// convolutions over the skeleton (ST-GCN, Yan et al. 2018), one per seed, trained on the judges'
// clips and their mirror images. Smaller than Yan's: five blocks of 16 to 32 channels. Their input
// is each joint's position and velocity in the heading frame, at kJudgeRate_hz, in windows of
// JudgeSettings::window frames. Judge() is const and may be called from any number of threads; each
// runs libtorch in its own thread.
class ActionClassifiers {
 public:
  // One classifier's verdicts on every window of one sequence.
  struct Verdicts {
    std::vector<int> content;
    Eigen::MatrixXd features;  // one row per window: the last pooling over joints and frames
  };

  // Trains on `clips`, or reads the result of an earlier call with the same `key` from `cache`,
  // seed by seed. Prints its progress to stderr. Errors name the file.
  static Result<ActionClassifiers> TrainOrLoad(const std::vector<train::TrainingClip>& clips,
                                               int styles, int contents,
                                               const JudgeSettings& settings,
                                               const std::filesystem::path& cache,
                                               const std::string& key);
  ~ActionClassifiers();
  ActionClassifiers(ActionClassifiers&&) noexcept;
  ActionClassifiers& operator=(ActionClassifiers&&) noexcept;

  const JudgeSettings& settings() const { return settings_; }
  // The parameters with which sequences must be made.
  const erd::FeatureParameters& parameters() const;
  // Each classifier's verdict on a window at every `stride`-th frame.
  std::vector<Verdicts> Judge(const Sequence& sequence, int stride) const;
  // SHA-256 of all parameters: figures of other classifiers must not be compared.
  std::string hash() const;

 private:
  struct Impl;
  explicit ActionClassifiers(const JudgeSettings& settings);
  JudgeSettings settings_;
  std::vector<std::unique_ptr<Impl>> classifiers_;
};

}  // namespace styled::judge
