#include "model/stylist/interleaver.h"

#include <algorithm>
#include <cmath>

namespace styled::stylist {
namespace {

int StatesFor(double frame_period_s, double network_rate_hz) {
  const long states = std::lround(1.0 / (frame_period_s * network_rate_hz));
  return static_cast<int>(std::clamp(states, 1L, static_cast<long>(tuning::kMaxInterleaved)));
}

}  // namespace

void Interleaver::Restart() noexcept {
  const int allowance = allowance_;  // a restart must not allow more work
  *this = Interleaver();
  allowance_ = allowance;
}

void Interleaver::Carry(Checkpoint& c) noexcept {
  c(history_s_);
  c.Within(history_count_, 0, tuning::kRateHistory);
  c.Within(history_next_, 0, tuning::kRateHistory - 1);
  c.Within(disagreements_, 0, tuning::kRateHistory);
  c(frame_period_s_);
  c.Within(interleaved_, 0, tuning::kMaxInterleaved);
  c(tick_period_s_);
  c.Time(origin_ns_);
  c.Time(last_ns_);
  c.Time(now_ns_);
  c.Time(next_tick_);
  c(started_);
  c.Within(allowance_, 0, kMaxStepsPerFrame);
  c.Within(ran_, 0, kMaxStepsPerFrame);
  const bool ordered = std::all_of(history_s_.begin(), history_s_.end(),
                                   [](double dt_s) { return std::isfinite(dt_s); });
  if (!ordered || next_tick_ < 0 || !(tick_period_s_ >= 0)) c.Refuse();
}

void Interleaver::Measure(double dt_s) noexcept {
  history_s_[static_cast<std::size_t>(history_next_)] = dt_s;
  history_next_ = (history_next_ + 1) % tuning::kRateHistory;
  history_count_ = std::min(history_count_ + 1, tuning::kRateHistory);
  std::array<double, tuning::kRateHistory> sorted = history_s_;
  const auto end = sorted.begin() + history_count_;
  const auto middle = sorted.begin() + (history_count_ - 1) / 2;
  std::nth_element(sorted.begin(), middle, end);
  frame_period_s_ = *middle;
}

bool Interleaver::Begin(std::int64_t time_ns, float network_rate_hz) noexcept {
  last_ns_ = now_ns_;
  now_ns_ = time_ns;
  ran_ = 0;
  if (!started_) {
    started_ = true;
    origin_ns_ = last_ns_ = time_ns;
    next_tick_ = 0;
    tick_period_s_ = 1.0 / network_rate_hz;
    return true;
  }
  Measure(static_cast<double>(time_ns - last_ns_) * 1e-9);
  const int states = StatesFor(frame_period_s_, network_rate_hz);
  if (interleaved_ == 0) {
    if (history_count_ < tuning::kRateDecide) return Afford();
    Interleave(states, network_rate_hz);
  }
  disagreements_ = states == interleaved_ ? 0 : disagreements_ + 1;
  return disagreements_ < tuning::kRateHistory && Afford();
}

// Charges the ticks that are due in the current frame to the allowance; false if they exceed it.
// Counted in floating point, because the number may not fit an integer.
bool Interleaver::Afford() noexcept {
  allowance_ = std::min(allowance_ + kMeanStepsPerFrame, kMaxStepsPerFrame);
  const double now = static_cast<double>(now_ns_ - origin_ns_) * 1e-9 / tick_period_s_;
  const double due = std::floor(now + tuning::kSnap) - static_cast<double>(next_tick_) + 1;
  if (due > allowance_) return false;
  if (due > 0) allowance_ -= static_cast<int>(due);
  return true;
}

// Switches from one state to `states`: the first keeps its ticks, the others begin at their next
// ones.
void Interleaver::Interleave(int states, double network_rate_hz) noexcept {
  interleaved_ = states;
  tick_period_s_ = 1.0 / (network_rate_hz * states);
  const double now = static_cast<double>(now_ns_ - origin_ns_) * 1e-9 / tick_period_s_;
  const auto due = static_cast<std::int64_t>(std::ceil(now - tuning::kSnap));
  // Tick t of one state becomes tick t * states of the finer grid. Continue after the last tick
  // that ran, but skip ticks of new states that are already in the past.
  next_tick_ = std::max((next_tick_ - 1) * states + 1, std::min(due, next_tick_ * states));
}

bool Interleaver::Next(Tick& tick) noexcept {
  const double due_s = static_cast<double>(next_tick_) * tick_period_s_;
  const double now_s = static_cast<double>(now_ns_ - origin_ns_) * 1e-9;
  const double after_s = due_s - now_s;  // > 0: the tick lies in the future
  if (after_s > tuning::kSnap * tick_period_s_ || ran_ == kMaxStepsPerFrame) return false;
  const double frame_s = static_cast<double>(now_ns_ - last_ns_) * 1e-9;
  float share = 1.0F;
  if (-after_s > tuning::kSnap * tick_period_s_ && frame_s > 0) {
    // The tick is before this frame by -after_s: interpolate between the last frame and this one.
    share = static_cast<float>(std::clamp(1.0 + after_s / frame_s, 0.0, 1.0));
  }
  tick = {static_cast<int>(next_tick_ % std::max(1, interleaved_)), share};
  ++next_tick_;
  ++ran_;
  return true;
}

}  // namespace styled::stylist
