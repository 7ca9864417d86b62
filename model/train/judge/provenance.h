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

// The judges' file by its SHA-256, and what they learned. Figures whose judges differ in it must
// not be compared; recipes/table.py refuses them.
nlohmann::json JudgesOf(const Panel& panel);
// The names of weights, which may be joined by "+", and the SHA-256 of each file.
nlohmann::json WeightsOf(const std::string& weights);
void PrintJudges(const nlohmann::json& judges);
void PrintWeights(const nlohmann::json& weights);

// The sources of a report, so that it can be repeated: the command, the judges, the weights, and
// per split the clips (OfClips).
nlohmann::json Provenance(const std::string& command, const Data& data, const Panel& panel,
                          const std::string& weights);
void PrintProvenance(const nlohmann::json& provenance);

// The meaning of the figures' names, in the order in which a report explains them: pairs of term
// and meaning.
nlohmann::json Glossary();
void PrintGlossary();

}  // namespace styled::judge
