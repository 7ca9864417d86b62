#include "daemon/publish/watch.h"

#include <pthread.h>
#include <spdlog/spdlog.h>
#include <zmq.h>

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

namespace styled::publish {

using runtime::Counter;

namespace {

// A canary that blocked would be woken by each message, at the expense of the pipeline. While
// messages arrive it polls instead, often enough that at most half of its queue fills up.
constexpr std::int64_t kShortest_ns = 2 * runtime::kMillisecond_ns;
constexpr std::int64_t kLongest_ns = 20 * runtime::kMillisecond_ns;

}  // namespace

Watch::Watch(std::unique_ptr<Canary> canary, int high_water_mark, const std::string& endpoint,
             runtime::Counters& counters)
    : canary_(std::move(canary)),
      high_water_mark_(high_water_mark),
      stalled_(endpoint),
      counters_(counters) {
  thread_ = std::thread([this] {
    pthread_setname_np(pthread_self(), "watch");
    Run();
  });
}

Watch::~Watch() {
  stop_.store(true, std::memory_order_relaxed);
  wake_.Signal();
  thread_.join();
}

void Watch::Run() {
  std::int64_t look_ns = clock_.Now_ns() + runtime::kSecond_ns;
  while (!stop_.load(std::memory_order_relaxed)) {
    Wait(look_ns - clock_.Now_ns());
    if (canary_) ReadCanary();
    if (clock_.Now_ns() < look_ns) continue;
    look_ns = clock_.Now_ns() + runtime::kSecond_ns;
    CheckStalled();
  }
}

void Watch::Wait(std::int64_t wait_ns) {
  std::array<zmq_pollitem_t, 2> waiting{};
  waiting[0] = {nullptr, wake_.fd(), ZMQ_POLLIN, 0};
  const bool for_canary = canary_ && period_ns_ == 0;
  if (for_canary) waiting[1] = {canary_->socket(), -1, ZMQ_POLLIN, 0};
  if (period_ns_ > 0) wait_ns = std::min(wait_ns, period_ns_);
  const auto wait_ms = static_cast<long>(wait_ns / runtime::kMillisecond_ns);
  zmq_poll(waiting.data(), for_canary ? 2 : 1, std::max(1L, wait_ms));
}

void Watch::ReadCanary() {
  const auto received = static_cast<std::int64_t>(canary_->Drain(counters_));
  const std::int64_t now_ns = clock_.Now_ns();
  const std::int64_t passed_ns = now_ns - std::exchange(read_ns_, now_ns);
  if (received == 0) {
    period_ns_ = 0;
    return;
  }
  // The interval is short at first and grows as far as the rate of messages allows.
  const std::int64_t longer_ns = std::max(2 * period_ns_, kShortest_ns);
  const std::int64_t half_full_ns = passed_ns / received * high_water_mark_;
  period_ns_ = std::clamp(std::min(longer_ns, half_full_ns), kShortest_ns, kLongest_ns);
}

void Watch::CheckStalled() {
  std::vector<std::string> fresh, recovered;
  stalled_.Look(fresh, recovered);
  counters_.Add(Counter::kPublishStalled, fresh.size());
  counters_.Set(Counter::kPublishStalledNow, stalled_.count());
  for (const std::string& address : fresh) {
    spdlog::warn(
        "publish: the subscriber {} has stopped reading: it loses messages that do not fit its "
        "queue",
        address);
  }
  for (const std::string& address : recovered) {
    spdlog::info("publish: the subscriber {} reads again, or has gone", address);
  }
}

}  // namespace styled::publish
