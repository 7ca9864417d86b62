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
// the mean neutral one. It has no state. It is a baseline for the others, and CONTRIBUTING.md's
// example of how to add a family. Format and mathematics: FORMAT.md. Pinned by
// tests/unit/net/offset/stylizer_test.cpp.
namespace styled::offset {

inline constexpr const char* kFamily = "constant-offset";

// Unit rotations per joint, applied from the right: styled = neutral · offset.
using Offsets = std::array<body::Quat, body::kJointCount>;

// Loads a weights file of this family; consumes its tensors. Errors name the key or tensor.
Result<std::shared_ptr<const net::Stylizer>> Load(net::WeightsFile& file);

// Writes a weights file. offsets[s] belongs to model.styles[s]; offsets[0] is the identity.
// `model.family` is ignored.
Status Write(const std::filesystem::path& file, const net::Model& model,
             const std::vector<Offsets>& offsets);

}  // namespace styled::offset
