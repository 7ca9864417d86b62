#pragma once

#include <cstdint>
#include <string>
#include <utility>

#include "daemon/decide/admission.h"
#include "daemon/runtime/counters.h"
#include "daemon/source/source_frame.h"
#include "model/base/realtime.h"

namespace styled::pipeline {

// What the parts of a source that is merged into a performer (a face, fingers) have in common: one
// sender and performer of the source at a time, the first until it was silent for kHold_ns; and
// when the part came and fell silent. Pipeline thread; nothing allocates but the constructor.
class MergedPart {
 public:
  // A phone sends 60 frames a second and pauses when its camera loses the face for a moment; gloves
  // pause where their radio does.
  static constexpr std::int64_t kHold_ns = 500'000'000;
  static constexpr std::int64_t kFade_ns = 500'000'000;
  // A frame that was taken over.
  static constexpr auto kAccepted = runtime::Counter::kCount;

  // Whether a frame came in the last kHold_ns. Times are on the daemon's monotonic clock.
  bool Live(std::int64_t now_ns) const noexcept {
    return any_ && now_ns - accepted_ns_ <= kHold_ns;
  }
  // Whether it came, 1, or fell silent, -1, since the last call; 0: neither.
  STYLED_REALTIME int Change(std::int64_t now_ns) noexcept;

 protected:
  MergedPart() { performer_.reserve(kLongestName); }
  // Whether a frame or body is the next one: kAccepted, or what it is refused as.
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

  bool any_ = false, told_ = false;
  std::int64_t accepted_ns_ = 0;
  std::string performer_;  // of the source, whose frames are taken
};

}  // namespace styled::pipeline
