#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "model/base/status.h"
#include "model/train/judge/data.h"
#include "model/train/judge/gaits.h"
#include "model/train/judge/judges_file.h"

namespace styled {

// The inputs of stylegaits. Errors name file or option.

// A manifest's clips of all its splits.
struct WholeClips {
  clip::Manifest manifest;
  std::vector<train::TrainingClip> clips;
};
Result<WholeClips> LoadWhole(const std::string& manifest, const std::string& data);

// A manifest's neutral walks and runs of splits no network is trained on, "validation" and "judge".
Result<std::vector<judge::GaitSource>> LoadSources(const std::string& manifest,
                                                   const std::string& data);
// Appends to the judges' clips such a manifest's walks and runs of the split "train" in all its
// styles, and these styles to theirs. Its neutral is one more of them, so that each actor's neutral
// counts as much. The judges then know how its performers move without a style, and what else an
// output may resemble.
Status AddPerformers(const std::string& manifest, const std::string& data, WholeClips& judges);
// BVH files of neutral walks and runs, the files of one folder by one person, whose first
// clip binds the rig. The gait is that of
// the speed (judge::GaitOf).
Result<std::vector<judge::GaitSource>> LoadStrangers(
    const std::vector<std::filesystem::path>& files);

struct GaitJudges {
  judge::Panel panel;
  std::size_t style_count = 0;

  // By style; of a window at every `stride`-th frame.
  std::vector<judge::Recognition> Recognize(const judge::Poses& poses, int stride) const;
};
// Trained on `clips`, or read from `cache` if they were trained on the same before.
Result<GaitJudges> TrainGaitJudges(const std::vector<train::TrainingClip>& clips,
                                   const clip::Manifest& manifest,
                                   const judge::JudgeSettings& settings, const std::string& cache);

}  // namespace styled
