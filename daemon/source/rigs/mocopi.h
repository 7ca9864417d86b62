#pragma once

#include <memory>

#include "daemon/config/config.h"
#include "daemon/source/translator.h"

namespace styled::source {

// Sony mocopi's application ("mocopi"; bytes: proto/rigs/mocopi).
//
// Transport   UDP, port 12351; a frame in each datagram, a skeleton every 3.5 s.
// Performer   One per port: `performer`, else the source's name. Up to 8 senders are distinguished
// by
//             address and port; the pipeline admits one of them at a time.
// Body        27 bones in metres, right-handed, +Y up, dialect "mocopi": the usual skeleton until
//             the sender describes its own.
// Time        The sender's, in seconds since its stream began. A gap in the frame numbers counts as
//             lost frames.
// Session     A new one where numbers fall back by 60, time by 1 s, or five frames in a row are
//             older than the newest.
// Refused     source.malformed; pipeline.duplicate and pipeline.reordered for old frames;
//             pipeline.second_sender for a ninth sender while eight are live (10 s).
// Pinned by tests/unit/mocopi/translator_test.cpp.
std::unique_ptr<Translator> MakeMocopi(const config::Source& config);

}  // namespace styled::source
