#pragma once

#include <array>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "model/train/judge/nets.h"

namespace styled::judge {

// As kJudgeRecipe, for these judges.
inline constexpr const char* kPartRecipe = "1";

// The part of the body that one judge sees: joint positions in the heading frame, minus those of an
// origin joint. `movement`: also minus each position's mean over the window, so that no constant
// offset can pass for a style; otherwise the pose counts.
struct PartView {
  std::string_view key;    // in JSON
  std::string_view title;  // in tables
  std::span<const int> joints;
  int origin = 0;
  bool height = false;  // and the hips' height
  bool movement = false;
};

// The whole body's movement; legs from the hips, arms from the chest, trunk and head from the hips,
// each by pose and by movement.
inline constexpr std::size_t kPartViewCount = 7;
const std::array<PartView, kPartViewCount>& PartViews();

// Style classifiers of one view each, trained as Judges are, on the same clips, for each seed.
// Judge() is const and may be called from any number of threads.
class PartJudges {
 public:
  // The style that each view's judge recognizes in a window; by view, then by window.
  using Answers = std::array<std::vector<int>, kPartViewCount>;

  // Trains on `clips` and their mirror images, or reads the result of an earlier call with the same
  // `key` from `cache` (created if missing). Prints its progress to stderr. Errors name the file.
  static Result<PartJudges> TrainOrLoad(const std::vector<train::TrainingClip>& clips, int styles,
                                        int contents, const JudgeSettings& settings,
                                        const std::filesystem::path& cache, const std::string& key);
  // Of tensors that Tensors() gave (judges_file.h); faults are the reader's.
  static PartJudges Read(net::TensorReader& tensors, int styles, const JudgeSettings& settings);
  ~PartJudges();
  PartJudges(PartJudges&&) noexcept;
  PartJudges& operator=(PartJudges&&) noexcept;

  // Each judge's verdict on a window at every `stride`-th frame, as Judges::Judge does.
  std::vector<Answers> Judge(std::span<const body::Pose> poses, int stride) const;
  // Names begin with the seed and "parts".
  std::vector<net::NamedTensor> Tensors() const;

 private:
  struct Impl;
  explicit PartJudges(const JudgeSettings& settings);
  JudgeSettings settings_;
  std::vector<std::unique_ptr<Impl>> judges_;
};

}  // namespace styled::judge
