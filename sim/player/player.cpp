#include "sim/player/player.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <queue>
#include <tuple>
#include <utility>

namespace styled::player {
namespace {

// A receiver that starts late or restarts refuses a few datagrams. Some rigs send only once per
// second until a server replies; for those, a second refusal after kRefusedFor_ns is enough.
constexpr std::uint64_t kRefusals = 3;
constexpr std::int64_t kRefusedFor_ns = 500'000'000;

}  // namespace

Player::Player(PlayerOptions options, std::vector<std::unique_ptr<Sender>> senders)
    : options_(std::move(options)), senders_(std::move(senders)) {}

// Polls the link for refused datagrams.
void Player::Listen(Link& link, std::int64_t now_ns) {
  const bool first = counts_.refused == 0;
  const std::uint64_t more = link.refused() - counts_.refused;
  counts_.refused += more;
  if (notified_ || more == 0) return;
  if (first) first_refusal_ns_ = now_ns;
  if (counts_.refused < kRefusals && now_ns - first_refusal_ns_ < kRefusedFor_ns) return;
  notified_ = true;
  if (options_.on_refused) options_.on_refused();
}

Status Player::Run(Clock& clock, Link& link, const std::atomic<bool>& stop) {
  const double period_ns = 1e9 / options_.rate_hz;
  const auto count = static_cast<double>(senders_.size());
  const std::uint64_t last_tick =
      options_.seconds > 0
          ? static_cast<std::uint64_t>(std::llround(options_.seconds * options_.rate_hz))
          : ~0ULL;
  const std::int64_t start_ns = clock.Now_ns();
  // The next tick of each sender that still plays, ordered by time, then by sender.
  struct Next {
    std::int64_t due_ns;
    std::size_t sender;
    std::uint64_t tick;
    bool operator>(const Next& other) const {
      return std::tie(due_ns, sender) > std::tie(other.due_ns, other.sender);
    }
  };
  std::priority_queue<Next, std::vector<Next>, std::greater<>> queue;
  const auto plan = [&](std::size_t k, std::uint64_t tick, std::int64_t earliest_ns) {
    if (tick >= last_tick) return;
    const double periods = static_cast<double>(tick) + static_cast<double>(k) / count;
    const std::int64_t due_ns = start_ns + std::llround(periods * period_ns) +
                                std::llround(senders_[k]->NextDelay_s() * 1e9);
    queue.push({std::max(due_ns, earliest_ns), k, tick});
  };
  for (std::size_t k = 0; k < senders_.size(); ++k) plan(k, 0, start_ns);
  while (!queue.empty() && !stop) {
    const Next next = queue.top();
    queue.pop();
    while (!stop && clock.Now_ns() < next.due_ns) clock.SleepUntil(next.due_ns);
    if (stop) break;
    if (next.sender == 0 && static_cast<double>(clock.Now_ns() - next.due_ns) > period_ns) {
      ++counts_.late_ticks;
    }
    counts_.ticks = std::max(counts_.ticks, next.tick + 1);
    const Sender::Step step = senders_[next.sender]->Tick(link);
    if (step == Sender::Step::kError) return senders_[next.sender]->error();
    Listen(link, clock.Now_ns());
    if (step != Sender::Step::kEnd) plan(next.sender, next.tick + 1, next.due_ns);
  }
  for (const auto& sender : senders_) {
    if (Status status = sender->Flush(link); !status.ok()) return status;
  }
  Listen(link, clock.Now_ns());
  counts_.wall_ns = clock.Now_ns() - start_ns;
  return Status::Ok();
}

std::string Summary(const Player& player) {
  StreamCounts sum;
  faults::Counts faults{};
  int performers = 0;
  for (const auto& sender : player.senders()) {
    const StreamCounts& counts = sender->counts();
    performers += sender->performers();
    sum.frames += counts.frames;
    sum.bodies += counts.bodies;
    sum.datagrams += counts.datagrams;
    sum.bytes += counts.bytes;
    sum.sessions += counts.sessions;
    for (std::size_t i = 0; i < faults.size(); ++i) faults[i] += sender->faults().counts()[i];
  }
  char text[256];
  std::snprintf(
      text, sizeof text,
      "performers=%d frames=%llu bodies=%llu datagrams=%llu bytes=%llu sessions=%llu "
      "seconds=%.2f late_ticks=%llu",
      performers, static_cast<unsigned long long>(sum.frames),
      static_cast<unsigned long long>(sum.bodies), static_cast<unsigned long long>(sum.datagrams),
      static_cast<unsigned long long>(sum.bytes), static_cast<unsigned long long>(sum.sessions),
      static_cast<double>(player.counts().wall_ns) * 1e-9,
      static_cast<unsigned long long>(player.counts().late_ticks));
  std::string line = text;
  if (player.counts().refused > 0) line += " refused=" + std::to_string(player.counts().refused);
  for (std::size_t i = 1; i < faults.size(); ++i) {
    if (faults[i] == 0) continue;
    line += ' ' + std::string(faults::Name(static_cast<faults::Fault>(i))) + '=' +
            std::to_string(faults[i]);
  }
  return line;
}

}  // namespace styled::player
