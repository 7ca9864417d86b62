#pragma once

#include <cstdint>
#include <string>
#include <utility>

#include "daemon/decide/admission.h"
#include "daemon/runtime/counters.h"
#include "daemon/source/source_frame.h"
#include "model/base/realtime.h"

namespace styled::pipeline {

// Base of the parts that a source merges into a performer (a face, fingers). It accepts one sender
// and performer of the source at a time, until that was silent for kHold_ns, and it reports when
// the part appears and falls silent. Pipeline thread; only the constructor allocates.
class MergedPart {
 public:
  // Longer than the usual pauses: a phone sends 60 frames a second and pauses when its camera loses
  // the face for a moment; gloves pause when their radio does.
  static constexpr std::int64_t kHold_ns = 500'000'000;
  static constexpr std::int64_t kFade_ns = 500'000'000;
  // The frame was accepted.
  static constexpr auto kAccepted = runtime::Counter::kCount;

  // Whether a frame arrived in the last kHold_ns. Times are on the daemon's monotonic clock.
  bool Live(std::int64_t now_ns) const noexcept {
    return any_ && now_ns - accepted_ns_ <= kHold_ns;
  }
  // Change since the last call: 1, the part appeared; -1, it fell silent; 0: neither.
  STYLED_REALTIME int Change(std::int64_t now_ns) noexcept;

 protected:
  MergedPart() { performer_.reserve(kLongestName); }
  // Checks the order of a frame or body. Returns kAccepted, or the counter of its refusal.
  STYLED_REALTIME runtime::Counter Admit(const source::SourceFrame& frame,
                                         std::int64_t now_ns) noexcept;
  STYLED_REALTIME void MarkAccepted(std::int64_t now_ns) noexcept {
    any_ = true;
    accepted_ns_ = now_ns;
  }
  std::int64_t accepted_ns() const { return accepted_ns_; }
  bool any() const { return any_; }

  static constexpr decide::SessionRules kRules{kHold_ns, 1'000'000'000};
  decide::Admission admission_;

 private:
  static constexpr std::size_t kLongestName = 32;  // config::IsName

  bool any_ = false, reported_ = false;
  std::int64_t accepted_ns_ = 0;
  std::string performer_;  // name of the source's performer whose frames are accepted
};

}  // namespace styled::pipeline
