#pragma once

#include <memory>

#include "daemon/config/config.h"
#include "daemon/source/translator.h"

namespace styled::source {

// SlimeVR's trackers over UDP ("slimevr"; bytes: proto/rigs/slimevr/udp.h). Type "slimevr-usb" gets
// the translator of slimevr_hid.h.
//
// Transport   UDP, port 6969, a dialogue as with SlimeVR's own server: handshake, features
//             (bundles), acknowledgements, heartbeat and ping twice a second until a tracker was
//             silent for 5 s.
// Performer   One per source, which carries all trackers: `performer`, else the source's name.
//             `trackers` assigns them to joints (tracker_rig.h, which also makes body and frames).
// Devices     64. Each device that `trackers` names has a reserved place; among the others, one
//             that was silent for 5 s is replaced. A device is live until it was silent for 2 s. It
//             must return a ping from its address within 2 s of its handshake, so that forged
//             addresses do not count. While it is live, a handshake for it from another address, or
//             for another device from its address, is refused without a reply.
// Reset       A tracker's button calibrates as the control socket does. If `trackers` names any
//             device, only buttons of named devices count. At most 8 at once, then one a second.
// Refused     source.malformed; source.ignored for unknown packets, senders and sensors;
//             source.takeovers_refused and source.table_full (logged at most once a second);
//             pipeline.duplicate and pipeline.reordered by the packet number.
// Pinned by tests/unit/slimevr/translator_test.cpp.
std::unique_ptr<Translator> MakeSlimeVr(const config::Source& config);

}  // namespace styled::source
