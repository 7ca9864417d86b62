#pragma once

#include <memory>
#include <vector>

#include "daemon/perform/performance.h"
#include "daemon/source/transport.h"
#include "proto/styled/v1/control.pb.h"

namespace styled::pipeline {

// Performs a control request between two frames and fills its reply. Returns false for GetStatus,
// which it leaves to the caller, who knows the statistics. `transports`: by source, for rigs that
// are calibrated by their own transport. Pipeline thread; allocates.
bool PerformRequest(const v1::Request& request,
                    const std::vector<std::unique_ptr<source::Transport>>& transports,
                    Performance& performance, v1::Reply& reply);

}  // namespace styled::pipeline
