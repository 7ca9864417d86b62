#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>

#include "model/base/status.h"
#include "model/net/erd/features.h"
#include "tests/parity/schedule.h"

namespace styled::parity {

using Rotations = std::array<float, erd::kRotationFeatures>;  // x,y,z,w per joint, hips in the
                                                              // heading frame

// The trainer's outputs for one frame.
struct Outputs {
  Rotations reconstruction{}, styled{};
  float heading_rad = 0;
};

// The trainer's side of a parity test, by frame number; a committed file leaves frames out to stay
// small. On disk: a safetensors file whose metadata has `clip` and `weights` (CRC-32C of those
// files), `schedule` and `frames`.
struct Reference {
  std::string schedule;
  std::string clip_crc, weights_crc;
  int frames = 0;  // the number of the clip's frames that were run
  std::map<int, Outputs> outputs;
  std::map<int, erd::Features> features;
};

// CRC-32C of a file in hexadecimal.
Result<std::string> FileCrc(const std::filesystem::path& file);

Status WriteReference(const Reference& reference, const std::filesystem::path& file);
Result<Reference> ReadReference(const std::filesystem::path& file);

}  // namespace styled::parity
