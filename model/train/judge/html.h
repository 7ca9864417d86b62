#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "model/base/status.h"
#include "model/train/judge/data.h"
#include "model/train/judge/stream.h"
#include "model/train/judge/strips.h"

namespace styled::judge {

// One clip and its outputs, for viewing; poses at kJudgeRate_hz. `offset` (the constant baseline)
// and `styled` may be empty; otherwise they are as long as `input`.
struct Scene {
  std::string content, style;
  Poses input, offset, styled;
};

// For every content the longest input (its first 6 s), with each style and the baseline; `styled`
// may be empty.
std::vector<Scene> ScenesOf(const Data& data, const std::vector<Transferred>& baseline,
                            const std::vector<Transferred>& styled);

struct Report {
  std::string weights, manifest;  // names for the reader
  nlohmann::json figures;         // the content of styleeval --json
  std::vector<Scene> scenes;
  std::vector<Picture> pictures = {};
};

// The report as one self-contained HTML document: tables, plots, animated stick figures.
std::string RenderReport(const Report& report);

// Errors name the file.
Status WriteReport(const Report& report, const std::filesystem::path& file);

}  // namespace styled::judge
