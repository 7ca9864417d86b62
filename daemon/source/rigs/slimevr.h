#pragma once

#include <memory>

#include "daemon/config/config.h"
#include "daemon/source/translator.h"

namespace styled::source {

// SlimeVR's trackers over UDP ("slimevr"; bytes: proto/rigs/slimevr/udp.h). Type "slimevr-usb" gets
// the translator of slimevr_hid.h.
//
// Transport   UDP, port 6969, a dialogue as with SlimeVR's own server: greeting, features
//             (bundles), acknowledgements, heartbeat and ping twice a second until a tracker was
//             silent for 5 s.
// Performer   One per source, which wears all trackers: `performer`, else the source's name.
//             `trackers` assigns them to joints (tracker_rig.h, which also makes body and frames).
// Devices     64. Each one that `trackers` names has a place kept for it; of the others, one that
//             was silent for 5 s gives way. A device is live until it was silent for 2 s, and it
//             has to send back a ping from its address within 2 s of its greeting, so that nobody
//             can make addresses up. While it is live, a greeting for it from another address, and
//             another device's from its own, is refused without an answer.
// Reset       A tracker's button calibrates as the control socket does; where `trackers` names any
//             device, only those may ask. At most 8 at once, then one a second.
// Refused     source.malformed; source.ignored for unknown packets, senders and sensors;
//             source.takeovers_refused and source.table_full (logged at most once a second);
//             pipeline.duplicate and pipeline.reordered by the packet number.
// Pinned by tests/unit/slimevr/translator_test.cpp.
std::unique_ptr<Translator> MakeSlimeVr(const config::Source& config);

}  // namespace styled::source
