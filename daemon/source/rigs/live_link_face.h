#pragma once

#include <memory>

#include "daemon/config/config.h"
#include "daemon/source/translator.h"

namespace styled::source {

// The app Live Link Face ("livelinkface"; bytes: proto/rigs/livelinkface), a face for the performer
// of `merge_into`, or a performer of its own (FaceBody).
//
// Transport   UDP, port 11111.
// Performer   None, or `performer`, else the source's name. One phone at a time: another one takes
//             over when the first was silent for 2 s.
// Face        ARKit's 52 expressions, or VRM's presets (`expressions`), 0 .. 1.
// Head        Used for a performer of its own only; a rig has a head. Radians; yaw to the left,
//             pitch up, roll to the left shoulder. The app does not document the signs. Yaw and
//             pitch are those against which the eyes turn in a recording of a real phone
//             (correlation 0.95 and 0.48), as the eyes of a person do who looks at the phone; the
//             sign of roll is that of Unreal's plug-in for such a yaw, and not verified.
// Eyes        From the expressions of the gaze: the eyes' rotations are left and right exchanged
//             against them in recordings of the app.
// Time        The app's frame number and rate.
// Session     A new one where the frame number falls by a second, or for five frames in a row.
// Refused     source.malformed; source.incomplete for a datagram without a face, when the camera
//             sees none; pipeline.duplicate, pipeline.reordered; pipeline.second_sender.
// Pinned by tests/unit/livelinkface/translator_test.cpp.
std::unique_ptr<Translator> MakeLiveLinkFace(const config::Source& config);

}  // namespace styled::source
