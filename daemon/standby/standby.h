#pragma once

#include <cstdint>
#include <memory>
#include <set>
#include <string>
#include <unordered_map>

#include "daemon/config/config.h"
#include "daemon/publish/publisher.h"
#include "daemon/runtime/clock.h"
#include "daemon/standby/channel.h"
#include "daemon/standby/held_publisher.h"
#include "daemon/standby/hold_back.h"
#include "daemon/standby/roles.h"
#include "proto/styled/v1/control.pb.h"
#include "proto/styled/v1/journal.pb.h"
#include "proto/styled/v1/stats.pb.h"

namespace styled::standby {

// A clock that stands at the moment of what the standby does again.
class FollowClock final : public runtime::Clock {
 public:
  explicit FollowClock(const runtime::Clock& base) : base_(base) {}
  std::int64_t Now_ns() const noexcept override { return stands_ ? now_ns_ : base_.Now_ns(); }
  std::int64_t Wall_ns() const noexcept override { return stands_ ? wall_ns_ : base_.Wall_ns(); }
  void Stand(std::int64_t now_ns, std::int64_t wall_ns) {
    stands_ = true;
    now_ns_ = now_ns;
    wall_ns_ = wall_ns;
  }
  void Run() { stands_ = false; }
  const runtime::Clock& base() const { return base_; }

 private:
  const runtime::Clock& base_;
  bool stands_ = false;
  std::int64_t now_ns_ = 0, wall_ns_ = 0;
};

// The reply of a standby to a request that would change something.
void RefuseOrder(const std::string& peer, const v1::Request& request, v1::Reply& reply);

// One of two daemons that stand in for each other ([standby]): who leads, what it tells the other
// one, and what the other one says. What the pipeline does with that is in pipeline/following.cpp.
// Pipeline thread; allocates.
class Standby {
 public:
  using Change = Roles::Change;

  // `daemon`: random, identifies this start. `publisher` and `clock` must outlive it.
  Standby(std::unique_ptr<Channel> channel, const config::Standby& config, std::uint64_t daemon,
          publish::Publisher& publisher, const runtime::Clock& clock);

  // For the pipeline, in place of the daemon's own.
  FollowClock& clock() { return clock_; }
  HeldPublisher& publisher() { return publisher_; }
  HoldBack& held() { return held_; }
  bool leads() const { return roles_.role() == v1::ROLE_LEADING; }

  // Reads the other daemon's next message; false when there is none. `entry` is what the follower
  // does again, at `own_ns` of this daemon's clock; null: nothing. Valid until the next call.
  struct Step {
    Change change = Change::kNone;
    const v1::Journal* entry = nullptr;
    std::int64_t own_ns = 0;
  };
  bool Next(Step& step);
  // Call once a turn, after Next: what silence decides. Says that this daemon is alive.
  Change OnTime();
  std::int64_t NextDeadline_ns() const { return said_ns_ + beat_ns_; }
  // Somebody wants this daemon to lead. Returns why it cannot, or "": it does so as soon as the
  // leader has said goodbye, or is silent.
  std::string Wish();
  // Tells the other one that this daemon stops, so that it need not wait.
  void Leave();

  // The leader's part. `epoch`: of its frames.
  void SetEpoch(std::uint64_t epoch) { epoch_ = epoch; }
  // Whether the other daemon listens. While it does not, entries are only counted.
  bool wanted() const;
  // An empty entry to fill and to Send.
  v1::Journal& NewEntry();
  void Send(std::int64_t now_ns, std::int64_t wall_ns);
  void SkipEntry() { ++number_; }
  // True once after the other daemon asked for everything.
  bool TakeAsked();

  // The follower's part.
  bool ready() const { return sync_ == Sync::kReady; }
  bool looks() const { return roles_.role() == v1::ROLE_LOOKING; }
  // It has at least a part of the leader's state, in whose epoch it then goes on.
  bool has_part() const { return has_part_; }
  void Begin(const v1::Beginning& beginning, const v1::Journal& entry);
  void Restored(const std::string& performer);
  // A part of the state could not be taken over, or something not be repeated: what is here is not
  // the leader's state, until it was fetched again.
  void Failed(std::string why);
  // Asks for the whole state, since what is here may differ from the leader's.
  void Refetch();
  // A frame was styled as the leader styled it, or not: it has the whole state sent again then, at
  // most every 10 s.
  void Compared(bool same);
  // The last frames that the leader handled, by performer id.
  std::unordered_map<std::string, LastHandled> last;
  // Ids of performers whose settings the leader keeps.
  std::set<std::string> configured;

  void Describe(v1::StandbyState& state) const;
  // A line for the log, once; "": none.
  std::string PopLine() { return std::exchange(line_, {}); }
  // The same of what is wrong; the caller limits how often.
  std::string PopComplaint() { return std::exchange(complaint_, {}); }
  const std::string& peer_address() const { return config_.peer; }

 private:
  enum class Sync : std::uint8_t { kNone, kAsked, kFetching, kReady };
  static constexpr std::int64_t kAgain_ns = 10'000'000'000;

  Change Note(Change change);
  void SayGoodbye();
  std::int64_t Now_ns() const { return clock_.base().Now_ns(); }

  const config::Standby config_;
  const std::uint64_t daemon_;
  const std::int64_t beat_ns_;  // between signs of life
  std::unique_ptr<Channel> channel_;
  FollowClock clock_;
  HeldPublisher publisher_;
  HoldBack held_;
  Roles roles_;

  std::uint64_t epoch_;
  std::uint64_t number_ = 0;  // of the last message that was sent
  std::int64_t said_ns_ = 0;
  v1::Journal out_, in_;
  std::string bytes_;

  Sync sync_ = Sync::kNone;
  std::int64_t asked_ns_ = 0;
  std::uint64_t heard_daemon_ = 0, heard_number_ = 0;
  std::int64_t heard_ns_ = 0;
  // The leader's clock minus this daemon's: the largest difference seen is that of the fastest
  // message.
  std::int64_t ahead_ns_ = 0, best_ahead_ns_ = 0;
  std::int64_t window_ns_ = 0;  // since when the best is measured
  bool timed_ = false, asked_ = false, has_part_ = false;
  std::set<std::string> awaited_;
  std::string why_not_, line_, complaint_;
  std::uint64_t compared_ = 0, different_ = 0, fetched_ = 0, takeovers_ = 0;
};

}  // namespace styled::standby
