#pragma once

#include <memory>

#include "daemon/runtime/clock.h"
#include "daemon/source/transport.h"

namespace styled::source {

// Wraps a transport and delays its frames, so that frames that arrive in bursts leave evenly. A
// frame leaves `delay_s` after the moment at which it would have arrived if its transit had been as
// short as the shortest of the last seconds (runtime::Schedule), in the order of source time. A
// frame that arrives later than that leaves at once. Bodies keep their places among the frames. At
// most 1,024 frames and bodies are held; beyond that the oldest leave early. The pipeline receives
// a frame when it leaves, and counts its latency from then on. Pipeline thread only. Allocates at
// construction, for new performers, and for frames larger than any before.
std::unique_ptr<Transport> MakeDelayed(std::unique_ptr<Transport> inner, float delay_s,
                                       runtime::Clock& clock);

}  // namespace styled::source
