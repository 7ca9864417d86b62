#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "daemon/runtime/clock.h"
#include "model/base/realtime.h"

namespace styled::decide {

// Decides for how many performers the style is left out because the machine is overloaded: the
// first step of the ladder in daemon/README.md. In windows of 0.1 s it measures three shares: the
// load (time needed for all frames), the styling within it, and the frames that leave later than
// one period after their arrival or not at all. All three must be high in two successive windows,
// so that a short interruption of the machine fades out no style. Styles return one by one, after
// there has been room for one more for some time. This time doubles after each return that was too
// early. Pipeline thread; reads no clock, allocates nothing. Pinned by
// tests/unit/daemon/decide/overload_test.cpp.
class Overload {
 public:
  // Frames that were processed together.
  struct Batch {
    std::int64_t busy_ns = 0;     // from reading them to the end of sending
    std::int64_t styling_ns = 0;  // the part of it in the stylist
    std::size_t sent = 0;
    std::size_t late = 0;     // those that left later than their period
    std::size_t dropped = 0;  // those not sent because they had waited longer than that
  };
  STYLED_REALTIME void Add(const Batch& batch) noexcept {
    sum_.busy_ns += batch.busy_ns;
    sum_.styling_ns += batch.styling_ns;
    sum_.sent += batch.sent;
    sum_.late += batch.late;
    sum_.dropped += batch.dropped;
  }

  // Whether a window has ended, so that Decide must be called.
  bool due(std::int64_t now_ns) const noexcept { return now_ns - window_ns_ >= kWindow_ns; }
  // `styled` and `relieved`: how many live performers run through the network and how many do not.
  // Returns how many more to relieve (> 0), or how many styles to restore (< 0).
  int Decide(std::int64_t now_ns, int styled, int relieved) noexcept {
    const auto share = [](auto part, auto all) {
      return all > 0 ? static_cast<double>(part) / static_cast<double>(all) : 0.0;
    };
    const Batch window = std::exchange(sum_, {});
    const std::int64_t passed_ns = now_ns - std::exchange(window_ns_, now_ns);
    if (window.sent > 0) frame_ns_ = share(window.busy_ns, window.sent);
    load_ =
        (static_cast<double>(window.busy_ns) + frame_ns_ * static_cast<double>(window.dropped)) /
        static_cast<double>(passed_ns);
    const double late = share(window.late + window.dropped, window.sent + window.dropped);
    const double styling = share(window.styling_ns, window.busy_ns);
    if (load_ >= kFull && late >= kLate && styling >= kStyling) {
      room_since_ns_ = now_ns;
      if (++full_windows_ < kFullWindows || styled == 0) return 0;
      full_windows_ = -kFades;
      // The last restored style was too much: wait longer before the next try.
      if (now_ns - restored_ns_ < kTooSoon_ns) wait_ns_ = std::min(2 * wait_ns_, kLongestWait_ns);
      const double enough = std::ceil(styled * (1 - kAim / load_) / styling);
      return std::clamp(static_cast<int>(enough), 1, std::max(1, styled / 2));
    }
    full_windows_ = 0;
    // One more performer costs about as much as each styled one.
    const double more = styled > 0 ? load_ / styled : 0;
    if (relieved == 0 || load_ + more > kAim || late >= kLate) {
      room_since_ns_ = now_ns;
      if (relieved == 0 && now_ns - restored_ns_ > kLongestWait_ns) wait_ns_ = kFirstWait_ns;
      return 0;
    }
    if (now_ns - room_since_ns_ < wait_ns_) return 0;
    room_since_ns_ = now_ns;
    restored_ns_ = now_ns;
    return -1;
  }
  // The time needed for all frames of the last window, as a share of the window; above 1 if frames
  // were dropped.
  double load() const noexcept { return load_; }

  static constexpr std::int64_t kWindow_ns = runtime::kSecond_ns / 10;
  static constexpr std::int64_t kFirstWait_ns = 2 * runtime::kSecond_ns;
  static constexpr std::int64_t kLongestWait_ns = 64 * runtime::kSecond_ns;

 private:
  static constexpr double kFull = 0.85;  // the rest goes to timers, statistics and clients
  static constexpr double kAim = 0.75;
  static constexpr double kLate = 0.1;
  static constexpr double kStyling = 0.3;  // less styling would not help
  static constexpr int kFullWindows = 2;
  static constexpr int kFades = 2;  // windows during which styles fade and still cost their time
  static constexpr std::int64_t kTooSoon_ns = 5 * runtime::kSecond_ns;

  std::int64_t window_ns_ = 0;  // when the window began
  Batch sum_;
  double frame_ns_ = 0;   // cost of one frame
  int full_windows_ = 0;  // in a row
  std::int64_t room_since_ns_ = 0;
  std::int64_t restored_ns_ = -2 * kLongestWait_ns;
  std::int64_t wait_ns_ = kFirstWait_ns;
  double load_ = 0;
};

}  // namespace styled::decide
