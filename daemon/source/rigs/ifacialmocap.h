#pragma once

#include <memory>

#include "daemon/config/config.h"
#include "daemon/source/translator.h"

namespace styled::source {

// The apps iFacialMocap and Facemotion3d ("ifacialmocap"; bytes: proto/rigs/ifacialmocap), a face
// for the performer of `merge_into`, or a performer of its own (FaceBody).
//
// Transport   UDP, port 49983. With `server`, the phone's address, the start text is sent to it
//             after 0.3 s of silence and then every 2 s; without, another program must start the
//             phone.
// Performer   None, or `performer`, else the source's name. One phone at a time: another address
//             takes over when the first was silent for 2 s.
// Face        ARKit's 52 expressions, or VRM's presets (`expressions`), 0 .. 1.
// Head        Used for a performer of its own only; a rig has a head. Degrees x, y, z are taken as
//             down, to the left, to the right shoulder: the axes of the eyes' rotations in the
//             vendor's sample. Eyes: from the expressions of the gaze.
// Time        That of arrival: the text has no time and no number.
// Refused     source.malformed; source.incomplete for a text without an expression;
//             pipeline.second_sender.
// Pinned by tests/unit/ifacialmocap/translator_test.cpp.
std::unique_ptr<Translator> MakeIFacialMocap(const config::Source& config);

}  // namespace styled::source
