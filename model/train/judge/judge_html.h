#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "model/base/status.h"
#include "model/train/judge/judge_stream.h"

namespace styled::judge {

// One clip and what was made of it, to be looked at; poses at kJudgeRate_hz. `offset` (the constant
// baseline) and `styled` may be empty; else they are as long as `input`.
struct Scene {
  std::string content, style;
  Poses input, offset, styled;
};

struct Report {
  std::string weights, manifest;  // as a reader knows them
  nlohmann::json figures;         // what styleeval --json writes
  std::vector<Scene> scenes;
};

// The page as one HTML document that needs nothing else: tables, plots, animated stick figures.
std::string RenderReport(const Report& report);

// Errors name the file.
Status WriteReport(const Report& report, const std::filesystem::path& file);

}  // namespace styled::judge
