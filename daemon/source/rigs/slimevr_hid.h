#pragma once

#include <memory>

#include "daemon/config/config.h"
#include "daemon/source/translator.h"

namespace styled::source {

// SlimeVR's trackers through their USB receiver, or on a cable ("slimevr-usb"; bytes:
// proto/rigs/slimevr/hid.h).
//
// Transport   USB HID: a report is a datagram, a receiver since it was plugged in a peer, of which
//             16 are kept.
// Performer   One per source, which wears all trackers: `performer`, else the source's name. A
//             tracker does not say where it is worn: `trackers` looks up its address
//             (tracker_rig.h, which also makes body and frames).
// Refused     usb.bad_reports for a report that is no multiple of records, or has none of a known
//             type; source.ignored for unknown records, and those of a tracker that its receiver
//             has not registered or nobody wears.
// Pinned by tests/unit/usb/slimevr_hid_test.cpp.
std::unique_ptr<Translator> MakeSlimeVrHid(const config::Source& config);

}  // namespace styled::source
