#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

#include "daemon/runtime/clock.h"
#include "daemon/runtime/histogram.h"
#include "model/base/realtime.h"
#include "proto/styled/v1/stats.pb.h"

namespace styled::pipeline {

// The period of a rig by its own clock: the mean distance of frames with consecutive numbers. One
// per performer, pipeline thread; allocates nothing.
class RigPeriod {
 public:
  // Call for each admitted frame; both values are the session's.
  STYLED_REALTIME void NoteFrame(std::uint64_t sequence, std::int64_t elapsed_ns) noexcept {
    const std::int64_t step_ns = elapsed_ns - elapsed_ns_;
    // A body has a number, too, so the frame after it is not consecutive.
    const bool next = sequence == sequence_ + 1 && step_ns > 0 && step_ns <= kLongest_ns;
    sequence_ = sequence;
    elapsed_ns_ = elapsed_ns;
    if (!next) return;
    period_ns_ = known_ ? period_ns_ + (step_ns - period_ns_) / kSmoothing : step_ns;
    known_ = true;
  }
  STYLED_REALTIME std::int64_t period_ns() const noexcept {
    return std::max(period_ns_, kShortest_ns);
  }

 private:
  static constexpr std::int64_t kUsual_ns = runtime::kSecond_ns / 120;  // until it is measured
  static constexpr std::int64_t kShortest_ns = runtime::kMillisecond_ns;
  static constexpr std::int64_t kLongest_ns = runtime::kSecond_ns;  // a longer distance is a pause
  static constexpr std::int64_t kSmoothing = 16;  // frames; evens out clocks of whole ms: 8, 8, 9
  std::uint64_t sequence_ = 0;
  std::int64_t elapsed_ns_ = 0;
  std::int64_t period_ns_ = kUsual_ns;
  bool known_ = false;
};

// How long the frames of a performer take from their arrival to the end of sending, and how many
// take longer than the rig's period. 3 kB; one per performer, pipeline thread. Only Describe
// allocates. Pinned by tests/unit/daemon/perform/performer/latency_test.cpp.
class Latency {
 public:
  RigPeriod rig;

  // Adds a frame that was sent. Returns whether it took longer than the period.
  STYLED_REALTIME bool Add(std::int64_t latency_ns) noexcept {
    second_.Add(latency_ns);
    windows_[current_].Add(latency_ns);
    const bool over = latency_ns > rig.period_ns();
    over_budget_ += over ? 1 : 0;
    return over;
  }

  // Call once a second. With `keep`, a second without a frame keeps the values of the last one, for
  // slow rigs.
  void Sample(bool keep, std::int64_t now_ns) noexcept {
    if (now_ns - turned_ns_ >= kWindow_ns) {
      turned_ns_ = now_ns;
      overall_.Add(windows_[current_]);
      current_ = (current_ + 1) % windows_.size();
      windows_[current_].Clear();
    }
    if (keep && second_.count() == 0) return;
    p50_us_ = second_.Percentile_us(0.5F);
    p99_us_ = second_.Percentile_us(0.99F);
    max_us_ = second_.Max_us();
    second_.Clear();
  }

  void Describe(v1::PerformerStats& stats) const {
    stats.set_latency_p50_us(p50_us_);
    stats.set_latency_p99_us(p99_us_);
    stats.set_latency_max_us(max_us_);
    stats.set_period_ms(static_cast<float>(rig.period_ns()) * 1e-6F);
    stats.set_over_budget(over_budget_);
    Long minute;
    for (const Window& window : windows_) minute.Add(window);
    stats.set_latency_p99_minute_us(minute.Percentile_us(0.99F));
    Long overall = overall_;
    overall.Add(windows_[current_]);
    stats.set_latency_p99_overall_us(overall.Percentile_us(0.99F));
  }

 private:
  static constexpr std::int64_t kWindow_ns = 30 * runtime::kSecond_ns;
  // Coarser than the last second's histogram, at most 12 % too high, to save memory.
  using Window = runtime::BasicHistogram<std::uint16_t, 8>;
  using Long = runtime::BasicHistogram<std::uint32_t, 8>;

  runtime::Histogram second_;
  float p50_us_ = 0, p99_us_ = 0, max_us_ = 0;  // of the last second
  std::array<Window, 3> windows_;               // the current one, and the two before it
  std::size_t current_ = 0;
  std::int64_t turned_ns_ = 0;
  Long overall_;  // of the windows before the current one
  std::uint64_t over_budget_ = 0;
};

}  // namespace styled::pipeline
