#pragma once

#include <memory>

#include "daemon/config/config.h"
#include "daemon/source/translator.h"

namespace styled::source {

// SlimeVR's trackers over UDP (proto/rigs/slimevr/udp.h), answered as its server answers them:
// greeting, features (bundles), acknowledgements, heartbeat and ping twice a second until one was
// silent for 5 s.
//
// There is room for 64 devices. Each one that `config.trackers` names has a place kept for it; of
// the others, one that was silent for 5 s gives way. A device is live until it was silent for 2 s,
// and where it is: it has to send a ping back from there within 2 s, or somebody made that address
// up. While it is live, a greeting for it from another address, and another device's from its own,
// is refused. Who is refused gets no answer; it is counted (source.takeovers_refused,
// source.table_full) and said at most once a second.
//
// All trackers of a source are on one performer, called `config.performer`, else as the source;
// `config.trackers` says which is worn where (TrackerRig). The reset actions that a tracker's
// button can ask for calibrate as the control socket does; where `config.trackers` names any
// device, only those may ask. Pinned by tests/unit/slimevr/translator_test.cpp.
std::unique_ptr<Translator> MakeSlimeVr(const config::Source& config);

}  // namespace styled::source
