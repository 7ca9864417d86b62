#pragma once

#include <memory>

#include "daemon/config/config.h"
#include "daemon/source/translator.h"

namespace styled::source {

// Xsens MVN's network streamer ("mvn", "mvn-tcp"; bytes: proto/rigs/mvn).
//
// Transport   UDP or TCP, port 9763. A sample may come in several datagrams, in order: it is a
//             frame as soon as it has the segments that its headers count, whether or not one of
//             them is marked as the last.
// Performer   Each character of each sender, up to 64: its name in MVN, else `performer`, else the
//             source's name; NAME-2, ... where a name is taken.
// Body        23 segments, with gloves 63, in the stream's own axes and units: type 02 in metres,
//             +Z or +Y up (`up`), type 01 in centimetres, +Y up. The skeleton is that of type 13,
//             or of the first pose where none comes within 1.5 s.
// Props       Of the character, up to four: the segments behind the body's, in the same axes and
//             units; their names are those of type 13, or Prop1, Prop2, ...
// Pose        Type 02, or type 01 where no 02 comes.
// Time        The sender's milliseconds; SMPTE timecode from type 25 (rate 1000).
// Session     A new one where the sample counter falls back by 240 or more.
// Refused     source.malformed; source.ignored for other types; source.incomplete for a sample that
//             ends without all its segments (logged at most once a second); pipeline.duplicate and
//             pipeline.reordered for old samples; pipeline.performers_refused for a 65th character.
// Pinned by tests/unit/mvn/translator_test.cpp.
std::unique_ptr<Translator> MakeMvn(const config::Source& config);

}  // namespace styled::source
