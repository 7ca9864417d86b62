#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "model/base/status.h"
#include "model/net/erd/features.h"
#include "model/train/dataset.h"

namespace styled::judge {

// The rate at which judges look at motion; clips and published frames are brought to it.
inline constexpr double kJudgeRate_hz = 30.0;

// Stands for what settings do not say (layers, noise): change it with them, so that judges trained
// otherwise are not read from a cache.
inline constexpr const char* kJudgeRecipe = "2";

// The features of one clip from its second frame on (the first has no velocity), and its labels.
struct Sequence {
  int style = 0;    // index into Manifest::styles
  int content = 0;  // index into Manifest::contents
  std::vector<erd::Features> frames;
};

// The features of `poses` (at kJudgeRate_hz) as a session of their own.
Sequence MakeSequence(std::span<const body::Pose> poses, int style, int content, bool mirrored,
                      const erd::FeatureParameters& parameters);

// What the judges say of every window of one sequence.
struct Verdicts {
  std::vector<int> starts;          // first frame of each window
  std::vector<int> style, content;  // the judges' answers
  Eigen::MatrixXd embedding;        // one row per window: the auto-encoder's last encoder layer
};

struct JudgeSettings {
  int window = 32;  // frames at kJudgeRate_hz
  int iterations = 1500;
  int batch = 64;
  unsigned seed = 1;
};

// Three networks trained on real clips that the generator never saw: a style and a content
// classifier (1-D convolutions over windows of standardized features, mean and maximum over time)
// and a denoising auto-encoder over rotations (style-ERD's FMD: noise N(0, 0.03), loss eq. 2).
// Judge() is const; any number of threads may call it, each runs torch on its own.
class Judges {
 public:
  // Trains on `clips` and their mirror images, or reads what an earlier call with the same `key`
  // left in `cache` (created if missing). Prints its progress to stderr.
  static Result<Judges> TrainOrLoad(const std::vector<train::TrainingClip>& clips, int styles,
                                    int contents, const JudgeSettings& settings,
                                    const std::filesystem::path& cache, const std::string& key);
  ~Judges();
  Judges(Judges&&) noexcept;
  Judges& operator=(Judges&&) noexcept;

  const JudgeSettings& settings() const;
  // What sequences must be made with: the rate, the heading filter and the hemispheres.
  const erd::FeatureParameters& parameters() const;
  // Judges windows at every `stride` frames. A sequence shorter than the window has none.
  Verdicts Judge(const Sequence& sequence, int stride) const;
  // The style judge's answers for windows of `window` frames, at least 4, at every frame. It looks
  // at means over time, so shorter windows than it learned from cost it accuracy, nothing else.
  std::vector<int> JudgeStyle(const Sequence& sequence, int window) const;

 private:
  struct Impl;
  explicit Judges(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace styled::judge
