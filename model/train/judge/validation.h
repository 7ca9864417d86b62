#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "model/base/status.h"
#include "model/train/judge/nets.h"

namespace styled::judge {

// Judges weights during their training: styleeval's main figures, averaged over styles, for the
// weights run as live on the manifest's neutral validation clips; weights that need whole clips, in
// turn by noise and by example clips of the style.
class Validator {
 public:
  // Trains the judges, or reads them from `cache`; prints progress to stderr.
  static Result<Validator> Make(const std::filesystem::path& manifest,
                                const std::filesystem::path& folder,
                                const std::filesystem::path& cache,
                                const JudgeSettings& settings = {});
  // Writes the judges' SHA-256 into `run`, the folder of a run. A run that is resumed must have the
  // same: its curve has one figure after the other, and its best weights the best of them.
  Status Claim(const std::filesystem::path& run, bool resumed) const;
  ~Validator();
  Validator(Validator&&) noexcept;

  // Figures by name: score, sra (over real clips'), cra (over the inputs'), expression, cosine, fmd
  // (over neutral to target; 0 if there are too few windows), jitter. A higher score is better: sra
  // + cra + cosine - fmd - |1 - expression| - max(0, jitter - 1).
  Result<std::vector<std::pair<std::string, double>>> Measure(
      const std::filesystem::path& weights) const;

 private:
  struct Impl;
  explicit Validator(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace styled::judge
