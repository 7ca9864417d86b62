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
  double rate_hz = 120;  // 1 .. 1000; all performers
  double seconds = 0;    // stop after this much source time; 0 = at the end of the motion
  // Called once, from Run(), after the receiver's machine has reported several times that no
  // program listens on the port; sending continues.
  std::function<void()> on_refused = {};
};

struct PlayerCounts {
  std::uint64_t ticks = 0;       // one per period, for all performers together
  std::uint64_t late_ticks = 0;  // started more than a period too late
  std::int64_t wall_ns = 0;
  std::uint64_t refused = 0;  // datagrams without a listener, as far as the link knows
};

// Sends the frames of all senders into a link, paced by an absolute clock. Tick i of sender k of n
// is due at start + (i + k / n) periods plus the sender's delay, but never before its tick i - 1.
// Overdue ticks are sent at once; none is skipped. Runs on the caller's thread. Pinned by
// tests/unit/sim/player_test.cpp.
class Player {
 public:
  Player(PlayerOptions options, std::vector<std::unique_ptr<Sender>> senders);

  // Returns when all motions have ended, after `seconds`, when `stop` is set, or on an error.
  Status Run(Clock& clock, Link& link, const std::atomic<bool>& stop);

  const std::vector<std::unique_ptr<Sender>>& senders() const { return senders_; }
  const PlayerCounts& counts() const { return counts_; }

 private:
  PlayerOptions options_;
  std::vector<std::unique_ptr<Sender>> senders_;
  PlayerCounts counts_;
  bool notified_ = false;  // on_refused has been called
  std::int64_t first_refusal_ns_ = 0;

  void Listen(Link& link, std::int64_t now_ns);
};

// "performers=1 frames=2400 bodies=20 datagrams=2420 bytes=... sessions=1 seconds=20.00
// late_ticks=0", then "refused=12" if datagrams found no listener, then the faults that occurred,
// "loss=12 ...". Machine-readable, for tests.
std::string Summary(const Player& player);

}  // namespace styled::player
