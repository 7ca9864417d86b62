#pragma once

#include <memory>

#include "daemon/config/config.h"
#include "daemon/source/translator.h"

namespace styled::source {

// SlimeVR's trackers over UDP (proto/rigs/slimevr/udp.h), answered as its server answers them:
// greeting, features (bundles), acknowledgements, heartbeat and ping twice a second until one was
// silent for 5 s. All trackers of a source are on one performer, called `config.performer`, else
// as the source; `config.trackers` says which is worn where (TrackerRig). The reset actions that a
// tracker's button can ask for calibrate as the control socket does.
// Pinned by tests/unit/slimevr/translator_test.cpp.
std::unique_ptr<Translator> MakeSlimeVr(const config::Source& config);

}  // namespace styled::source
