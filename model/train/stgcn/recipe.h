#pragma once

#include <memory>

#include "model/base/status.h"
#include "model/train/recipe.h"
#include "model/train/stgcn/config.h"
#include "model/train/stgcn/weights.h"
#include "model/train/trainer.h"

namespace styled::train::st_gcn {

// The training of the spatio-temporal graph network (Park et al. 2021) as the trainer drives it.
// Reads the manifest and its clips, and seeds libtorch; invalid flags are refused before anything
// is read. The recipe keeps copies of `run` and `config`. Errors name flag or file. Pinned by
// tests/unit/train/stgcn/run_test.cpp.
Result<std::unique_ptr<Recipe>> MakeRecipe(const RunConfig& run, const Config& config);

}  // namespace styled::train::st_gcn
