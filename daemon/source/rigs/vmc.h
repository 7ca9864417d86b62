#pragma once

#include <memory>

#include "daemon/config/config.h"
#include "daemon/source/translator.h"

namespace styled::source {

// The VMC protocol ("vmc"; bytes: proto/rigs/vmc), OSC from VSeeFace, Warudo and others.
//
// Transport   UDP, port 39540. A frame may be a bundle or single messages; at most four frames are
//             made of one datagram.
// Performer   One per port: `performer`, else the source's name. Up to 8 senders are distinguished
//             by address and port, each admitted once it sent a bone; the pipeline admits one of
//             them at a time.
// Body        The humanoid bones that the sender sends, fingers and eyes among them, in metres,
//             +Y up, dialect "vmc". Offsets are the bones' own positions, or the canonical
//             humanoid's where those are all zero. It changes with the bones, and with an avatar of
//             other measures (10 mm, steady for ten frames).
// Pose        From Unity's left-handed axes, mirrored through x = 0; root and hips are composed.
// Time        The sender's T in seconds; where there is none, the time of arrival continues it.
// Root        No frame leaves before /VMC/Ext/Root/Pos came from the sender: the hips would be at a
//             wrong place. A sender without a root for 1 s is at the origin, which is noted once.
// Partial     Of a sender that lacks bones of a body for 1 s (hands and head alone, no legs), no
//             frame leaves: its performer is listed as refused, with the reason, which is logged
//             once. With `joints` the pipeline judges the bones. A sender of expressions alone is
//             the same after 2 s, if no other sender has bones.
// Face        Expressions (256 blend shapes with UTF-8 names) and up to 8 messages under /VMC/Thru.
// Merged      With `merge_into`, a face needs no bones, and fingers need no bones but a hand's. The
//             rotation of the hand itself does not matter: senders of hands alone give it in the
//             model's space, not against the parent. No bone leaves such a body.
// Devices     A sender of devices (Hmd, Con, Tra) and no bones, an assistant, is a performer, too:
//             vmc_devices.h, device_rig.h. `trackers` gives each serial its part. One such sender
//             per port.
// Session     A new one where the assembler sees the sender restart (proto/rigs/vmc/assembler.h).
// Refused     source.malformed; source.ignored; source.incomplete, also for frames that wait for
//             a root or bones; pipeline.duplicate and pipeline.reordered;
//             pipeline.second_sender for a ninth sender while eight are live.
// Pinned by tests/unit/vmc/translator_test.cpp.
std::unique_ptr<Translator> MakeVmc(const config::Source& config);

}  // namespace styled::source
