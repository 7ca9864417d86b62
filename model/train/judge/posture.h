#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "model/base/status.h"
#include "model/net/styles.h"
#include "model/train/dataset.h"

namespace styled::judge {

// How each style of training clips carries trunk, head and collars (net::Posture), by the clips'
// style: the mean of a joint over all frames of a content of one source in the style, and their
// mirror images, against that of the same content in neutral; the mean over the contents that both
// have. Nothing for neutral, and for a style without such a content. Pinned by
// tests/unit/judge/posture_test.cpp.
std::vector<std::optional<net::Posture>> MeasurePostures(std::span<const train::TrainingClip> clips,
                                                         std::size_t style_count);

// Writes them into a weights file of any family, as the key "posture" of the styles of these names
// (model/net/FORMAT.md). All else stays. Errors name the file.
Status WritePostures(std::span<const std::optional<net::Posture>> postures,
                     std::span<const std::string> names, const std::filesystem::path& weights);

// Both, for the training clips of a manifest; prints how far each style bends.
Status MeasureAndWritePostures(const std::filesystem::path& manifest,
                               const std::filesystem::path& folder,
                               const std::filesystem::path& weights);

}  // namespace styled::judge
