#pragma once

#include <memory>

#include "daemon/config/config.h"
#include "daemon/source/translator.h"

namespace styled::source {

// SlimeVR's trackers through their USB receiver, or on a cable ("slimevr-usb"; bytes:
// proto/rigs/slimevr/hid.h).
//
// Transport   USB HID: each report is a datagram. Each opening of a receiver is a peer; 16 are
//             kept.
// Performer   One per source, which carries all trackers: `performer`, else the source's name. A
//             tracker does not state its joint: `trackers` assigns it by address (tracker_rig.h,
//             which also makes body and frames).
// Refused     usb.bad_reports for a report whose size is not a multiple of a record's, or without a
//             record of a known type; source.ignored for unknown records, and for trackers that
//             their receiver has not registered or that are assigned to no joint.
// Pinned by tests/unit/usb/slimevr_hid_test.cpp.
std::unique_ptr<Translator> MakeSlimeVrHid(const config::Source& config);

}  // namespace styled::source
