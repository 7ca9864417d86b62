#pragma once

#include <memory>

#include "daemon/config/config.h"
#include "daemon/source/translator.h"

namespace styled::source {

// SlimeVR's trackers by their receiver on USB, or on a cable: a report (proto/rigs/slimevr/hid.h)
// is a datagram, a receiver a peer. All trackers of a source are on one performer, called
// `config.performer`, else as the source; what their receivers call them (their address) is looked
// up in `config.trackers`, since they do not say where they are worn. Records of a tracker that its
// receiver has not registered yet are ignored. A report that is no multiple of records, or has none
// of a known type, is counted as usb.bad_reports.
// Pinned by tests/unit/usb/slimevr_hid_test.cpp.
std::unique_ptr<Translator> MakeSlimeVrHid(const config::Source& config);

}  // namespace styled::source
