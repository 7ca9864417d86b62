#pragma once

#include <memory>

#include "daemon/config/config.h"
#include "daemon/source/translator.h"

namespace styled::source {

// The app Live Link Face ("livelinkface"; bytes: proto/rigs/livelinkface), a face for the performer
// of `merge_into`.
//
// Transport   UDP, port 11111.
// Performer   None. One phone at a time: another one takes over when the first was silent for 2 s.
// Face        ARKit's 52 expressions, or VRM's presets (`expressions`), 0 .. 1. The rotations of
//             head and eyes are not used: the body has a head, and the eyes' are left and right
//             exchanged against the expressions in recordings of the app.
// Time        The app's frame number and rate.
// Session     A new one where the frame number falls by a second, or for five frames in a row.
// Refused     source.malformed; source.incomplete for a datagram without a face, when the camera
//             sees none; pipeline.duplicate, pipeline.reordered; pipeline.second_sender.
// Pinned by tests/unit/livelinkface/translator_test.cpp.
std::unique_ptr<Translator> MakeLiveLinkFace(const config::Source& config);

}  // namespace styled::source
