#pragma once

#include <memory>

#include "model/base/status.h"
#include "model/train/recipe.h"
#include "model/train/stgcn_causal/config.h"
#include "model/train/stgcn_causal/weights.h"
#include "model/train/trainer.h"

namespace styled::train::st_gcn_causal {

// The training of the causal spatio-temporal graph network, from trained weights of family st-gcn,
// as the trainer drives it. Reads weights, manifest and clips, and seeds libtorch; invalid flags
// are refused before anything is read. Features are standardized as in those weights, and the
// manifest has their styles, in any order. The recipe keeps copies of `run` and `config`. Errors
// name flag or file. Pinned by tests/unit/train/stgcn_causal/run_test.cpp.
Result<std::unique_ptr<Recipe>> MakeRecipe(const RunConfig& run, const Config& config);

}  // namespace styled::train::st_gcn_causal
