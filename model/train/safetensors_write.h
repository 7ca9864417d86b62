#pragma once

#include <torch/torch.h>

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "model/base/status.h"

namespace styled::train {

// Tensors with their names, in the order in which a file holds them.
using NamedTensors = std::vector<std::pair<std::string, torch::Tensor>>;

// Writes a safetensors file, as network families' exports use it: the tensors as float32, and the
// text `metadata` (JSON) under the key "styled". Tensors of any device and layout; they are copied.
// Replaces `file` atomically. Errors name the file. Pinned by tests/unit/train/run_test.cpp, which
// loads such files with the runtime's own reader.
Status WriteSafetensors(const NamedTensors& tensors, const std::string& metadata,
                        const std::filesystem::path& file);

}  // namespace styled::train
