#pragma once

#include <memory>

#include "tests/support/fake_pipeline.h"
#include "tests/unit/net/erd/random_weights.h"

namespace styled::fuzz {

// The daemon of which the seeds are checkpoints, and that restores them.
inline std::shared_ptr<const pipeline::RuntimeConfig> CheckpointConfig() {
  static const auto config = [] {
    auto made = std::make_shared<pipeline::RuntimeConfig>();
    made->network = erd::RandomStylizer(5, 1);
    made->weights_name = "random.safetensors";
    made->weights_crc = 0x1234;
    made->performers.max_performers = 4;
    return made;
  }();
  return config;
}

}  // namespace styled::fuzz
