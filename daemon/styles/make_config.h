#pragma once

#include <cstdint>
#include <memory>

#include "daemon/config/config.h"
#include "daemon/looks/runtime_config.h"
#include "model/base/status.h"

namespace styled::pipeline {

// Reads the weights and the avatars that `config` names, and checks presets, cues and the initial
// style against the weights. Errors name the key or the file and what was expected. `running`, or
// null: unchanged parts of it are shared, so that performers need not restart; its weights are
// shared if the file still has the CRC-32C `weights_crc`, which is updated. Blocks and allocates;
// start-up and reload only.
Result<std::shared_ptr<const RuntimeConfig>> MakeRuntimeConfig(const config::Config& config,
                                                               const RuntimeConfig* running,
                                                               std::uint32_t& weights_crc);

}  // namespace styled::pipeline
