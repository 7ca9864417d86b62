#pragma once

#include <torch/torch.h>

#include "model/train/trainer.h"

namespace styled::train {

// The device for the flag --device of a checked run (CheckRun) on this machine.
torch::Device DeviceOf(const RunConfig& run);

// Sets libtorch's threads and seeds it. A recipe calls it after its data are read and before its
// first random weight.
void SeedTorch(const RunConfig& run);

}  // namespace styled::train
