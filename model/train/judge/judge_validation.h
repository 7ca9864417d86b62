#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "model/base/status.h"
#include "model/train/judge/judge_nets.h"

namespace styled::judge {

// What a run is worth while it learns: styleeval's main figures, means over styles, of weights as
// they run live on the manifest's neutral validation clips.
class Validator {
 public:
  // Trains the judges, or reads them from `cache`; prints its progress to stderr.
  static Result<Validator> Make(const std::filesystem::path& manifest,
                                const std::filesystem::path& folder,
                                const std::filesystem::path& cache,
                                const JudgeSettings& settings = {});
  ~Validator();
  Validator(Validator&&) noexcept;

  // By name: score, sra (over real), cra (over the inputs'), expression, cosine, fmd (over neutral
  // to target; 0 where there are too few windows), jitter. Higher scores are better:
  // sra + cra + cosine - fmd - |1 - expression| - what jitter is above 1.
  Result<std::vector<std::pair<std::string, double>>> Measure(
      const std::filesystem::path& weights) const;

 private:
  struct Impl;
  explicit Validator(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace styled::judge
