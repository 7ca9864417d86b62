#pragma once

#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "model/base/status.h"
#include "model/clip/manifest.h"
#include "model/net/gate_bounds.h"
#include "model/train/dataset.h"
#include "model/train/judge/report.h"

namespace styled::judge {

// The training clips of a manifest, at the judges' rate: their measurements are written into
// weights.
struct TrainingSet {
  clip::Manifest manifest;
  std::vector<train::TrainingClip> clips;
  double rate_hz = 0;
};
Result<TrainingSet> ReadTrainingSet(const std::filesystem::path& manifest,
                                    const std::filesystem::path& folder);

// Calls `edit` with the metadata of a weights file of any family (model/net/FORMAT.md), and writes
// the result. Tensors stay. Replaces `weights` atomically, but not if `edit` fails or the result is
// not a weights file. Errors name the file.
Status EditMetadata(const std::filesystem::path& weights,
                    const std::function<Status(nlohmann::ordered_json& keys)>& edit);

// Calls `edit` with the index of each of `names` and the style with that name or alias in a weights
// file of any family, as EditMetadata does. All other keys stay. It is an error if the file has
// none of the styles.
Status EditStyles(const std::filesystem::path& weights, std::span<const std::string> names,
                  const std::function<void(std::size_t name, nlohmann::ordered_json& style)>& edit);

// Writes the key "gate" (model/net/FORMAT.md). All other keys stay.
Status WriteGate(const net::GateBounds& gate, const std::filesystem::path& weights);

// The strength of the evidence for a style: how much of it the generator was trained on, s, and the
// share of windows of the styled clips that the judge recognizes as the style, -1 if it was not
// measured.
struct Evidence {
  std::string style;
  double recorded_s = 0, recognized = -1;
};
// `clips`: those that the generator was trained on, at `rate_hz`; styles without any are left out.
std::vector<Evidence> EvidenceOf(const clip::Manifest& manifest,
                                 std::span<const train::TrainingClip> clips, double rate_hz,
                                 const Figures& figures);

// The source of how often a style is recognized: a manifest's name, and its judges' SHA-256.
struct JudgedBy {
  std::string manifest, judges;
};
// Writes it into the styles of a weights file, with the judges; styles that are not in `evidence`
// keep what they have. Refuses a file in which one of these was judged on the same manifest by
// other judges: such figures must not stand side by side.
Status WriteEvidence(std::span<const Evidence> evidence, const JudgedBy& by,
                     const std::filesystem::path& weights);

}  // namespace styled::judge
