#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "model/base/status.h"
#include "model/clip/manifest.h"
#include "model/train/judge/nets.h"
#include "model/train/judge/parts.h"

namespace styled::judge {

// All judges of one set of clips, as one file (safetensors, float32). Figures of two files must not
// stand side by side: every table names its file by `hash`. On machines of one kind (the same CPU,
// OpenBLAS and libtorch) the same clips and settings give the same file, byte for byte; another
// kind of CPU sums in another order and gives other judges. Pinned by
// tests/unit/judge/judges_file_test.cpp.
struct Panel {
  Judges judges;
  PartJudges parts;
  nlohmann::json header;  // what they were made of, and for
  std::string hash;       // SHA-256 of the file, hexadecimal
};

// The number of clips and frames, and a hash of all poses (FNV-1a, 64 bit, hexadecimal), rounded to
// 0.1 mm.
nlohmann::json OfClips(const std::vector<train::TrainingClip>& clips);

// Judges of the manifest's styles and contents, trained on `clips`, or read from `cache` where
// those of this `key` are. Errors name the file.
Result<Panel> TrainPanel(const std::vector<train::TrainingClip>& clips,
                         const clip::Manifest& manifest, const JudgeSettings& settings,
                         const std::filesystem::path& cache, const std::string& key);

// Judges of a file. Refuses a file of another humanoid, recipe, list of styles or of contents, or
// whose judges learned from another number of clips or frames than `clips`.
Result<Panel> ReadPanel(const std::filesystem::path& file,
                        const std::vector<train::TrainingClip>& clips,
                        const clip::Manifest& manifest);

Status WritePanel(const Panel& panel, const std::filesystem::path& file);

}  // namespace styled::judge
