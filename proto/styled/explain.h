#pragma once

#include <span>
#include <string>
#include <string_view>

#include "proto/styled/v1/fate.pb.h"

namespace styled {

// Why frames are refused or passed over, by the counter that counts them.
struct RefusalReason {
  std::string_view counter;
  std::string_view why;   // goes on behind "because"
  std::string_view cure;  // in the imperative, without a full stop; `%` stands for the performer
};
// Null: the counter is none of a frame that is refused.
const RefusalReason* FindRefusalReason(std::string_view counter);
// The cure with the performer's id.
std::string CureText(const RefusalReason& reason, std::string_view performer);

// What became of a frame, why, and what to do about it, in a sentence or a few: "frame 1234:
// published without style for 3.1 ms. ...". The same text in stylectl, the page and stylerec. Empty
// fields are left out. Allocates; any thread. Pinned by tests/unit/styled/explain_test.cpp.
std::string ExplainText(const v1::FrameFate& fate);

// The same without number and times: what is the same of many frames in a row, so that they can be
// counted. "" where nothing needs a word.
std::string CauseText(const v1::FrameFate& fate);

// Many frames, oldest first, a line each; those in a row of which the same is to be said are one
// line with their number and their range.
std::string ExplainLines(std::span<const v1::FrameFate> fates);

}  // namespace styled
