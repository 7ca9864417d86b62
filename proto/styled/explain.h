#pragma once

#include <span>
#include <string>
#include <string_view>

#include "proto/styled/v1/fate.pb.h"

namespace styled {

// Why frames are refused or skipped, by the counter that counts them.
struct RefusalReason {
  std::string_view counter;
  std::string_view why;   // a clause that follows "because"
  std::string_view cure;  // imperative, without a full stop; `%` is replaced by the performer
};
// Returns null if the counter does not count refused frames.
const RefusalReason* FindRefusalReason(std::string_view counter);
// The cure with the performer's id.
std::string CureText(const RefusalReason& reason, std::string_view performer);

// The fate of a frame, its reason and its remedy, in one to three sentences: "frame 1234:
// published without style for 3.1 ms. ...". The same text in stylectl, the page and stylerec. Empty
// fields are left out. Allocates; any thread. Pinned by tests/unit/daemon/perform/explain_test.cpp.
std::string ExplainText(const v1::FrameFate& fate);

// The same without number and times, so that equal causes of successive frames can be counted. ""
// if the frame needs no explanation.
std::string CauseText(const v1::FrameFate& fate);

// Many frames, oldest first, one line each. Successive frames with the same cause share a line with
// their number and range.
std::string ExplainLines(std::span<const v1::FrameFate> fates);

}  // namespace styled
