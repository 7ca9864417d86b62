#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "model/base/status.h"
#include "model/clip/manifest.h"
#include "model/train/dataset.h"

namespace styled::judge {

// How fast each style of a manifest walks and runs: speed, m/s, and cadence, steps of either foot
// per minute (MeasureGait), each the mean over its clips of the contents "walk" and "run". 0 where
// it has none, or none long enough to measure. Pinned by tests/unit/judge/speeds_test.cpp.
struct StyleSpeeds {
  std::string style;
  double walk_mps = 0, run_mps = 0;
  double walk_spm = 0, run_spm = 0;
};
std::vector<StyleSpeeds> MeasureSpeeds(const clip::Manifest& manifest,
                                       std::span<const train::TrainingClip> clips, double rate_hz);

// Writes them into the styles of a weights file of any family, as walk_mps, run_mps, walk_spm and
// run_spm (model/net/FORMAT.md), for the stylist's Root::kStride and `stylize --cadence`. Tensors
// and all other keys stay. Styles that `speeds` lacks keep their figures, and so do styles with
// figures that are 0; styles that the weights lack are ignored. Replaces `weights` atomically.
// Errors name the file; a figure that the format does not allow is an error.
Status WriteSpeeds(std::span<const StyleSpeeds> speeds, const std::filesystem::path& weights);

// Both, for the training clips of a manifest; prints the speeds and cadences.
Status MeasureAndWriteSpeeds(const std::filesystem::path& manifest,
                             const std::filesystem::path& folder,
                             const std::filesystem::path& weights);

}  // namespace styled::judge
