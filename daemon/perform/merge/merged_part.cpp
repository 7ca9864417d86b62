#include "daemon/perform/merge/merged_part.h"

namespace styled::pipeline {

using runtime::Counter;

int MergedPart::Change(std::int64_t now_ns) noexcept {
  const bool shown = any_ && now_ns - accepted_ns_ <= kHold_ns + kFade_ns;
  return std::exchange(told_, shown) == shown ? 0 : shown ? 1 : -1;
}

Counter MergedPart::Admit(const source::SourceFrame& frame, std::int64_t now_ns) noexcept {
  if (frame.performer != performer_) {
    if (now_ns - admission_.session.last_arrival_ns() < kHold_ns && !performer_.empty()) {
      return Counter::kPipelineSecondSender;
    }
    admission_ = decide::Admission();
    performer_.assign(frame.performer.substr(0, kLongestName));
  }
  switch (admission_.session.Admit(frame.machine, frame.session, frame.sequence, now_ns, kRules)) {
    case decide::Session::Arrival::kDuplicate:
      return Counter::kPipelineDuplicate;
    case decide::Session::Arrival::kReordered:
      return Counter::kPipelineReordered;
    case decide::Session::Arrival::kSecondSender:
      return Counter::kPipelineSecondSender;
    case decide::Session::Arrival::kFarAhead:
      return Counter::kPipelineFarAhead;
    case decide::Session::Arrival::kNewSession:
      admission_.StartSession();
      break;
    case decide::Session::Arrival::kRecounted:  // the same sender: its body stays valid
    case decide::Session::Arrival::kNext:
      break;
  }
  return kAccepted;
}

}  // namespace styled::pipeline
