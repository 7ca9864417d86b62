#pragma once

#include <memory>

#include "daemon/config/config.h"
#include "daemon/source/translator.h"

namespace styled::source {

// The apps iFacialMocap and Facemotion3d ("ifacialmocap"; bytes: proto/rigs/ifacialmocap), a face
// for the performer of `merge_into`.
//
// Transport   UDP, port 49983. With `server`, the phone's address, the start text is sent to it
//             after 0.3 s of silence and then every 2 s; without, another program must start the
//             phone.
// Performer   None. One phone at a time: another address takes over when the first was silent for
//             2 s.
// Face        ARKit's 52 expressions, or VRM's presets (`expressions`), 0 .. 1. Rotations of head
//             and eyes are not used.
// Time        That of arrival: the text has no time and no number.
// Refused     source.malformed; source.incomplete for a text without an expression;
//             pipeline.second_sender.
// Pinned by tests/unit/ifacialmocap/translator_test.cpp.
std::unique_ptr<Translator> MakeIFacialMocap(const config::Source& config);

}  // namespace styled::source
