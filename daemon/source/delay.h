#pragma once

#include <memory>

#include "daemon/runtime/clock.h"
#include "daemon/source/transport.h"

namespace styled::source {

// A transport whose frames wait a little, so that what comes in bursts leaves evenly: each frame
// is handed on `delay_s` after the moment at which it would have come had its way been as short as
// the shortest of the last seconds (runtime::Schedule), in the order of its source time; what
// comes later than that at once. Bodies go where they came among the frames. Holds up
// to 1,024 frames and bodies, then the oldest leave early. The pipeline sees a frame, and its
// latency begins, when it is handed on. Pipeline thread only; allocates when made, and for frames
// larger than any before.
std::unique_ptr<Transport> MakeDelayed(std::unique_ptr<Transport> inner, float delay_s,
                                       runtime::Clock& clock);

}  // namespace styled::source
