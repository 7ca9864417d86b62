#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "model/base/status.h"
#include "sim/player/clock.h"
#include "sim/player/link.h"
#include "sim/player/sender.h"

namespace styled::player {

struct PlayerOptions {
  double rate_hz = 120;  // 1 .. 1000, all performers
  double seconds = 0;    // stop after so much source time; 0 = when the motion ends
  // Called once, from Run(), when the receiver's machine has said several times that nobody listens
  // there; sending goes on.
  std::function<void()> on_refused = {};
};

struct PlayerCounts {
  std::uint64_t ticks = 0;       // of the rate, all performers together one
  std::uint64_t late_ticks = 0;  // begun more than a whole period behind time
  std::int64_t wall_ns = 0;
  std::uint64_t refused = 0;  // datagrams for which nobody listened, as far as the link knows
};

// Plays senders into a link, paced by an absolute clock: tick i of sender k of n is due at
// start + (i + k / n) periods and the delay that the sender wants, but not before its tick i - 1,
// whatever happened before; what is overdue is sent at once, nothing is skipped. Runs on the
// caller's thread. Pinned by tests/unit/sim/player_test.cpp.
class Player {
 public:
  Player(PlayerOptions options, std::vector<std::unique_ptr<Sender>> senders);

  // Returns when every motion has ended, after `seconds`, when `stop` is set, or on an error.
  Status Run(Clock& clock, Link& link, const std::atomic<bool>& stop);

  const std::vector<std::unique_ptr<Sender>>& senders() const { return senders_; }
  const PlayerCounts& counts() const { return counts_; }

 private:
  PlayerOptions options_;
  std::vector<std::unique_ptr<Sender>> senders_;
  PlayerCounts counts_;
  bool told_ = false;  // on_refused was called
  std::int64_t first_refusal_ns_ = 0;

  void Listen(Link& link, std::int64_t now_ns);
};

// "performers=1 frames=2400 bodies=20 datagrams=2420 bytes=... sessions=1 seconds=20.00
// late_ticks=0", "refused=12" where nobody listened, then the faults that occurred, "loss=12 ...":
// words and numbers for tests.
std::string Summary(const Player& player);

}  // namespace styled::player
