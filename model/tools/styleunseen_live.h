#pragma once

#include <string>
#include <vector>

#include "model/base/status.h"
#include "model/clip/manifest.h"
#include "model/train/judge/nets.h"
#include "model/train/judge/unseen.h"

namespace styled {

// The measurement of a live network that has a space of styles.
struct UnseenLive {
  const clip::Manifest& manifest;
  std::vector<judge::Poses> walks;  // by style of the manifest
  std::vector<std::size_t> styles;  // to measure
  judge::ByCode network;
  std::string library;  // folder of style files; empty: examples
  std::string source;   // a BVH file to restyle; empty: the neutral walk
  std::string judges;   // folder of cached judges; empty: none
  int judge_seeds = judge::kUsualJudges;
  std::string json;      // file for the figures; empty: none
  bool neutral = false;  // examples are read relative to the neutral walk: only the difference
};
Status MeasureLive(const UnseenLive& of);

}  // namespace styled
