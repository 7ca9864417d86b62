#pragma once

#include <filesystem>
#include <string_view>

#include "model/base/status.h"
#include "model/train/recipe.h"

namespace styled::train::st_gcn_causal {

inline constexpr const char* kFamily = "st-gcn-causal";
// The prefix of a checkpoint's tensors that a weights file takes from the teacher.
inline constexpr std::string_view kTeachers = "teacher.";

// Writes the file of model/net/stgcn_causal/FORMAT.md, atomically. Everything that is needed is in
// the checkpoint; errors name the missing part.
Status ExportWeights(const Checkpoint& checkpoint, const std::filesystem::path& file);

}  // namespace styled::train::st_gcn_causal
