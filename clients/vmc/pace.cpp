#include "clients/vmc/pace.h"

#include <algorithm>
#include <cmath>

namespace styled::stylevmc {
namespace {

constexpr double kBurst = 4, kHurry = 1.25;
constexpr std::int64_t kLargestJump_ns = 1'000'000'000, kLeast_ns = 1'000'000;

// `after` - `before`; negative if the clock went back.
std::int64_t Difference(std::uint64_t after, std::uint64_t before) {
  return static_cast<std::int64_t>(after - before);
}

}  // namespace

RateCap::RateCap(double rate_hz) : period_ns_(std::llround(1e9 / rate_hz)), allowance_(kBurst) {}

// The schedule is kept, so that the mean rate is exact; a frame may be a quarter of a period early.
bool RateCap::IsDue(std::uint64_t source_time_ns) {
  const std::int64_t step_ns = Difference(source_time_ns, last_ns_);
  const bool jumped = !started_ || step_ns <= 0 || step_ns > kLargestJump_ns;
  started_ = true;
  last_ns_ = source_time_ns;
  due_ns_ = jumped ? 0 : due_ns_ - step_ns;  // relative to this frame
  if (due_ns_ > period_ns_ / 4) return false;
  due_ns_ = std::max(due_ns_ + period_ns_, std::int64_t{0});
  return true;
}

bool RateCap::Admit(std::uint64_t source_time_ns, std::int64_t now_ns) {
  // Token bucket by arrival time: refilled at kHurry times the rate, holds at most kBurst frames.
  const double passed_ns = refilled_ns_ == 0 ? 0.0 : static_cast<double>(now_ns - refilled_ns_);
  refilled_ns_ = now_ns;
  allowance_ = std::min(kBurst, allowance_ + kHurry * passed_ns / static_cast<double>(period_ns_));
  if (!IsDue(source_time_ns) || allowance_ < 1) return false;
  allowance_ -= 1;
  return true;
}

float Timeline::Seconds(std::uint64_t source_time_ns, std::int64_t now_ns) {
  if (started_) {
    const std::int64_t passed_ns = now_ns - last_now_ns_;
    std::int64_t step_ns = Difference(source_time_ns, last_source_ns_);
    // The source's clock went back, stood still or jumped: advance by the local time instead.
    if (step_ns <= 0 || step_ns > passed_ns + kLargestJump_ns) {
      step_ns = std::max(passed_ns, kLeast_ns);
    }
    elapsed_ns_ += step_ns;
  }
  started_ = true;
  last_source_ns_ = source_time_ns;
  last_now_ns_ = now_ns;
  return static_cast<float>(static_cast<double>(elapsed_ns_) * 1e-9);
}

}  // namespace styled::stylevmc
