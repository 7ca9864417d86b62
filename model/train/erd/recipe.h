#pragma once

#include <filesystem>
#include <memory>

#include "model/base/status.h"
#include "model/net/weights_file.h"
#include "model/train/erd/config.h"
#include "model/train/recipe.h"
#include "model/train/trainer.h"

namespace styled::train::style_erd {

inline constexpr const char* kFamily = net::kStyleErd;

// The training of Style-ERD (Tao et al. 2022) as the trainer drives it. Reads the manifest, its
// clips and the weights that the flags name, and seeds libtorch; invalid flags are refused before
// anything is read. The recipe keeps copies of `run` and `config`. Errors name flag or file. Pinned
// by tests/unit/train/run_test.cpp.
Result<std::unique_ptr<Recipe>> MakeRecipe(const RunConfig& run, const Config& config);

// Writes the weights file (model/net/erd/FORMAT.md) of a checkpoint of this family.
Status ExportWeights(const Checkpoint& checkpoint, const std::filesystem::path& file);

}  // namespace styled::train::style_erd
