#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "model/base/status.h"
#include "model/clip/manifest.h"
#include "model/train/dataset.h"

namespace styled::judge {

// The mean speed at which each style of a manifest walks and runs, m/s: the mean over its clips of
// the contents "walk" and "run". 0 where it has none.
struct StyleSpeeds {
  std::string style;
  double walk_mps = 0, run_mps = 0;
};
std::vector<StyleSpeeds> MeasureSpeeds(const clip::Manifest& manifest,
                                       std::span<const train::TrainingClip> clips, double rate_hz);

// Writes the speeds into the styles of a weights file of any family, as walk_mps and run_mps
// (model/net/FORMAT.md), for the stylist's Root::kStride. Tensors and all other keys stay. Styles
// that `speeds` lacks keep what they have; styles that the weights lack are ignored. Replaces
// `weights` atomically. Errors name the file.
Status WriteSpeeds(std::span<const StyleSpeeds> speeds, const std::filesystem::path& weights);

// Both, for the training clips of a manifest; prints the speeds.
Status MeasureAndWriteSpeeds(const std::filesystem::path& manifest,
                             const std::filesystem::path& folder,
                             const std::filesystem::path& weights);

}  // namespace styled::judge
