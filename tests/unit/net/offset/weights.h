#pragma once

#include <filesystem>

#include "model/net/offset/stylizer.h"

namespace styled::offset {

// Neutral, "bent" (the spine 0.3 rad forward) and "raised" (the left upper arm 0.5 rad up).
inline constexpr float kBent_rad = 0.3F, kRaised_rad = 0.5F;
net::Model TestModel();
std::vector<Offsets> TestOffsets();

// The same as a file; aborts if it cannot be written.
void WriteTestWeights(const std::filesystem::path& file);

}  // namespace styled::offset
