#pragma once

#include <memory>

#include "daemon/config/config.h"
#include "daemon/source/translator.h"

namespace styled::source {

// Rokoko Studio's custom streaming ("rokoko"; bytes: proto/rigs/rokoko).
//
// Transport   UDP, port 14043; JSON v2 or v3, plain or LZ4, all actors in one datagram.
// Performer   Each actor of each sender, up to 64: its name in Studio, else `performer`, else the
//             source's name; NAME-2, ... where a name is taken.
// Body        The joints of the first frame that has a hip, in metres, made right-handed (mirrored
//             through x = 0), +Y up, dialect "rokoko". Made again when joints are added (gloves) or
//             the actor's hip height changes. A joint that a later frame lacks is not tracked.
// Face        Of an actor with a face: ARKit's 52 expressions, or VRM's presets (`expressions`).
// Props       Of the scene, for every actor: name and pose, mirrored as the joints.
// Time        The frame's timestamp in seconds.
// Session     A new one where an actor's time falls back by 1 s, or stays back for five frames.
// Refused     source.malformed; source.incomplete for an actor without a hip before it has a body;
//             pipeline.duplicate and pipeline.reordered for old frames;
//             pipeline.performers_refused for actors beyond a frame's 8 or the source's 64;
//             pipeline.props_left_out for props without a pose, and those beyond 16.
// Pinned by tests/unit/rokoko/translator_test.cpp.
std::unique_ptr<Translator> MakeRokoko(const config::Source& config);

}  // namespace styled::source
