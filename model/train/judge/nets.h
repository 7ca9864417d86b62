#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "model/base/status.h"
#include "model/net/erd/features.h"
#include "model/net/weights_file.h"
#include "model/train/dataset.h"

namespace styled::judge {

// The rate at which judges see motion; clips and published frames are converted to it.
inline constexpr double kJudgeRate_hz = 30.0;

// A version for properties outside JudgeSettings (layers, noise). Change it with them, so that
// judges of an older recipe are not read from a cache.
inline constexpr const char* kJudgeRecipe = "2";

// The features of one clip from its second frame on (the first has no velocity), and its labels.
struct Sequence {
  int style = 0;    // index into Manifest::styles
  int content = 0;  // index into Manifest::contents
  std::vector<erd::Features> frames;
};

// The features of `poses` (at kJudgeRate_hz), with a new feature state.
Sequence MakeSequence(std::span<const body::Pose> poses, int style, int content, bool mirrored,
                      const erd::FeatureParameters& parameters);

// One judge's verdicts on every window of one sequence.
struct Verdicts {
  std::vector<int> starts;           // first frame of each window
  std::vector<int> style, content;   // the judge's results
  Eigen::MatrixXd embedding;         // one row per window: the auto-encoder's last encoder layer
  Eigen::MatrixXd content_features;  // one row per window: the content judge's last layer, mean
                                     // over time
};

struct JudgeSettings {
  int window = 32;  // frames at kJudgeRate_hz
  int iterations = 1500;
  int batch = 64;
  unsigned seed = 1;  // of the first judge
  int count = 1;      // judges, of the seeds from `seed` on
};
inline constexpr int kUsualJudges = 5;  // of a figure that is published
inline constexpr int kMostJudges = 9;   // their file must not exceed net::kMaxFileBytes

// Each judge's number of windows with this answer.
std::vector<double> Hits(std::span<const Verdicts> by_judge, std::vector<int> Verdicts::*answers,
                         int right);

// Judges that differ in their seed: what one of them says by chance, the others do not. Each has
// three networks trained on real clips that the generator never saw: a style classifier and a
// content classifier (1-D convolutions over windows of standardized features, mean and maximum over
// time), and a denoising auto-encoder over rotations (Style-ERD's FMD: noise N(0, 0.03), loss eq.
// 2). Judge() is const and may be called from any number of threads; each runs libtorch in its own
// thread.
class Judges {
 public:
  // Trains on `clips` and their mirror images, or reads the result of an earlier call with the same
  // `key` from `cache` (created if missing), seed by seed. Prints its progress to stderr.
  static Result<Judges> TrainOrLoad(const std::vector<train::TrainingClip>& clips, int styles,
                                    int contents, const JudgeSettings& settings,
                                    const std::filesystem::path& cache, const std::string& key);
  // Of tensors that Tensors() gave (judges_file.h); faults are the reader's.
  static Judges Read(net::TensorReader& tensors, int styles, int contents,
                     const JudgeSettings& settings);
  ~Judges();
  Judges(Judges&&) noexcept;
  Judges& operator=(Judges&&) noexcept;

  const JudgeSettings& settings() const;
  // The parameters with which sequences must be made: rate, heading filter and hemispheres.
  const erd::FeatureParameters& parameters() const;
  // Each judge's verdict on a window at every `stride`-th frame. A sequence shorter than the window
  // has no windows.
  std::vector<Verdicts> Judge(const Sequence& sequence, int stride) const;
  // Each style judge's results for windows of `window` frames, at least 4, beginning at every
  // frame. The judge uses means over time, so windows shorter than in its training only cost
  // accuracy.
  std::vector<std::vector<int>> JudgeStyle(const Sequence& sequence, int window) const;
  // All but the auto-encoders' decoders, which only training needs. Names begin with the seed.
  std::vector<net::NamedTensor> Tensors() const;

 private:
  struct Impl;
  explicit Judges(const JudgeSettings& settings);
  JudgeSettings settings_;
  std::vector<std::unique_ptr<Impl>> judges_;
};

}  // namespace styled::judge
