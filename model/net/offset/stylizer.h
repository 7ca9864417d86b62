#pragma once

#include <array>
#include <filesystem>
#include <memory>
#include <vector>

#include "model/base/status.h"
#include "model/body/pose.h"
#include "model/net/stylizer.h"
#include "model/net/weights_file.h"

// The simplest family: a style is one constant rotation per joint, the mean styled pose relative to
// the mean neutral one. It has no state. A baseline for the others, and the example of
// CONTRIBUTING.md for how a family is added. Format and mathematics: FORMAT.md. Pinned by
// tests/unit/net/offset/stylizer_test.cpp.
namespace styled::offset {

inline constexpr const char* kFamily = "constant-offset";

// Per joint, applied from the right: styled = neutral · offset. Of length 1.
using Offsets = std::array<body::Quat, body::kJointCount>;

// The stylizer of a weights file of this family; takes its tensors. Errors name key or tensor.
Result<std::shared_ptr<const net::Stylizer>> Load(net::WeightsFile& file);

// Writes a weights file: offsets[s] is that of model.styles[s], offsets[0] the identity. Of `model`
// all but the family is written.
Status Write(const std::filesystem::path& file, const net::Model& model,
             const std::vector<Offsets>& offsets);

}  // namespace styled::offset
