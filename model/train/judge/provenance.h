#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "model/base/status.h"
#include "model/train/judge/data.h"
#include "model/train/judge/nets.h"

namespace styled::judge {

// The command as a report repeats it: the program's name without its folder, and the arguments.
std::string CommandLine(int argc, char** argv);

// Writes figures to a file. The error names it.
Status WriteJson(const nlohmann::json& json, const std::filesystem::path& file);

// The sources of a report, so that it can be repeated: the command, the judges' settings, the
// hash of the weights or of each file that they are joined from, and per split the number of clips
// and frames and a hash of all poses (FNV-1a, 64 bit, hexadecimal).
nlohmann::json Provenance(const std::string& command, const Data& data,
                          const JudgeSettings& settings, const std::string& weights);
void PrintProvenance(const nlohmann::json& provenance);

// The meaning of the figures' names, in the order in which a report explains them: pairs of term
// and meaning.
nlohmann::json Glossary();
void PrintGlossary();

}  // namespace styled::judge
