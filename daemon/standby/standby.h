#pragma once

#include <bitset>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <set>
#include <string>
#include <unordered_map>
#include <vector>

#include "daemon/config/config.h"
#include "daemon/log/entry.h"
#include "daemon/publish/publisher.h"
#include "daemon/runtime/clock.h"
#include "daemon/standby/buffered_publisher.h"
#include "daemon/standby/channel.h"
#include "daemon/standby/input_buffer.h"
#include "daemon/standby/roles.h"
#include "proto/styled/v1/control.pb.h"
#include "proto/styled/v1/journal.pb.h"
#include "proto/styled/v1/stats.pb.h"

namespace styled::standby {

// A clock that can be stopped at the time of the entry that the standby performs.
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

// The answer of a standby to a request that would change something; `peer`: the leader's address.
Status OrderRefused(const std::string& peer);

// One daemon of a pair, each of which can take over from the other ([standby]): its role, its
// journal for the peer, and the peer's journal. Replication applies both to the pipeline. Pipeline
// thread; allocates.
class Standby {
 public:
  using Change = Roles::Change;

  // `daemon`: random, identifies this start. `publisher` and `clock` must outlive it.
  Standby(std::unique_ptr<Channel> channel, const config::Standby& config, std::uint64_t daemon,
          publish::Publisher& publisher, const runtime::Clock& clock);
  // The settings that affect this daemon's poses. They are sent to the peer, which compares them
  // with its own: a standby whose settings differ is not ready. Call again after a change.
  void SetSetup(v1::Setup setup);

  // For the pipeline, instead of the daemon's own.
  FollowClock& clock() { return clock_; }
  BufferedPublisher& publisher() { return publisher_; }
  InputBuffer& input() { return input_; }
  bool leads() const { return roles_.role() == v1::ROLE_LEADING; }

  // Reads the peer's next message; false when there is none. `entry`: the entry that the follower
  // must perform at `own_ns` on this daemon's clock; null: none. Valid until the next call. A
  // message that is not from the peer's journal is counted, logged and otherwise ignored.
  struct Step {
    Change change = Change::kNone;
    v1::Journal* entry = nullptr;  // until the next call; the caller may take it
    std::int64_t own_ns = 0;
  };
  bool Next(Step& step);
  // Call once a turn, after Next: applies the effects of silence, and sends heartbeats.
  Change OnTime();
  std::int64_t NextDeadline_ns() const { return sent_ns_ + beat_ns_; }
  // Requests leadership (`stylectl lead`): this daemon leads as soon as the leader has said goodbye
  // or is silent. The error has a code.
  Status RequestLead();
  // Announces that this daemon stops, so that the peer takes over without waiting.
  void Leave();

  // For the leader. `epoch`: of its frames.
  void SetEpoch(std::uint64_t epoch) { epoch_ = epoch; }
  // Whether the peer is connected. While it is not, entries are counted and not sent.
  bool wanted() const;
  // An empty entry to fill and to Send.
  v1::Journal& NewEntry();
  // Sends the entry. If it is too large for a message, sends its name and size instead.
  void Send(std::int64_t now_ns, std::int64_t wall_ns);
  void SkipEntry() { ++number_; }
  // Reads changed subscriptions, at most kSubscriptionsPerTurn; returns how many.
  int DoSubscriptions();
  // Returns true once after the peer, or another program, has requested the whole state. Requests
  // beyond the limit (three in succession, then one a second) wait.
  bool PopAsked();

  // For the follower. Ready: it has the state of all performers, its settings equal the leader's,
  // and at most 1 % of the last poses differ from the leader's (log::Comparison::kApart). Whole: it
  // has the state.
  bool ready() const;
  bool whole() const;
  bool looks() const { return roles_.role() == v1::ROLE_LOOKING; }
  // Whether it has at least a part of the leader's state. It then takes over in the leader's epoch.
  bool has_part() const { return has_part_; }
  // Returns false if this daemon has the whole state already, and another program requested it.
  bool Begin(const v1::Journal& entry);
  // Whether the state is being fetched, so that its parts are for this daemon.
  bool fetches() const { return sync_ == Sync::kFetching; }
  // The last part of the settings was restored; the performers' checkpoints follow.
  void SettingsRestored(const v1::SettingsPart& last);
  void StyleRestored(const v1::StylePart& part);
  void Restored(const std::string& performer);
  // A part of the state could not be restored, or an entry could not be performed: this daemon's
  // state is invalid until it is fetched again.
  void Failed(std::string why);
  // Requests the whole state, because this daemon's state may differ from the leader's.
  void Refetch();
  // Result of the comparison of a frame. If poses are apart, the whole state is fetched again, at
  // most every 10 s. Counts only while the standby has the whole state.
  void Compared(log::Comparison comparison);
  // The last frames that the leader processed, by performer id.
  std::unordered_map<std::string, LastHandled> last;
  // Ids of performers whose settings the leader saves.
  std::set<std::string> configured;

  void Describe(v1::StandbyState& state) const;
  // A change of roles, for the log. Leading without the peer, or without its state, is a warning; a
  // start is information.
  struct Line {
    std::string text;  // "": none
    bool warning = false;
  };
  Line PopLine() { return std::exchange(line_, {}); }
  // The next warning, once; the caller limits how often it is logged.
  std::string PopComplaint() { return std::exchange(complaint_, {}); }
  const std::string& peer_address() const { return config_.peer; }

 private:
  enum class Sync : std::uint8_t { kNone, kAsked, kFetching, kReady };
  static constexpr int kSubscriptionsPerTurn = 64;
  static constexpr std::int64_t kAgain_ns = 10'000'000'000;
  // Number of compared poses, five seconds of one performer, and how many of them may be apart. One
  // or two around a loss are within the limit.
  static constexpr std::size_t kWindow = 600, kMostApart = kWindow / 100;

  Change Note(Change change);
  // Parses bytes_ into in_. An error if it is not a message of the peer.
  Status Read();
  void Refuse(std::string why);
  void NotePair(const Peer& peer, std::int64_t now_ns);
  void MeasureClock(std::int64_t now_ns);
  void CompareSetups();
  std::string DiffersText() const;
  void NameTooLarge(std::size_t bytes);
  std::string WhyNot() const;
  void SendGoodbye();
  std::int64_t Now_ns() const { return clock_.base().Now_ns(); }

  const config::Standby config_;
  const std::uint64_t daemon_;
  const std::int64_t beat_ns_;  // interval of heartbeats
  std::unique_ptr<Channel> channel_;
  FollowClock clock_;
  BufferedPublisher publisher_;
  InputBuffer input_;
  Roles roles_;

  std::uint64_t epoch_;
  std::uint64_t number_ = 0;  // of the last message sent
  std::int64_t sent_ns_ = 0;
  v1::Journal out_, in_;
  std::string bytes_;
  v1::Setup setup_, peer_setup_;
  std::int64_t setup_sent_ns_;
  bool peer_setup_known_ = false;
  std::vector<std::string> differs_;
  std::string too_large_;

  Sync sync_ = Sync::kNone;
  std::int64_t asked_ns_ = 0;
  bool asking_ = false;  // no Beginning has arrived since
  bool gap_ = false;     // entries were lost since the last Beginning
  std::uint64_t heard_daemon_ = 0, heard_number_ = 0;
  std::int64_t heard_ns_ = 0, reconnected_ns_ = 0;
  std::int64_t listened_ns_ = 0;  // time of the last subscription or message
  // The leader's clock minus this daemon's. The largest difference seen belongs to the fastest
  // message.
  std::int64_t ahead_ns_ = 0, best_ahead_ns_ = 0;
  std::int64_t window_ns_ = 0;  // begin of the measurement of best_ahead_ns_
  // Time since which the peer receives a third daemon; 0: it does not.
  std::int64_t stranger_ns_ = 0;
  bool heard_ = false, listens_ = false, has_part_ = false;
  bool asked_ = false;               // the whole state is requested and not sent yet
  std::int64_t next_state_ns_;       // earliest time at which the state is sent again
  std::int64_t asks_window_ns_ = 0;  // begin of the count asks_
  int asks_ = 0;
  std::set<std::string> awaited_;
  Line line_;
  std::string why_not_, complaint_, refused_why_;
  std::bitset<kWindow> apart_of_last_;
  std::size_t compared_at_ = 0;
  std::uint64_t compared_ = 0, different_ = 0, apart_ = 0, fetched_ = 0, takeovers_ = 0;
  std::uint64_t refused_ = 0, asked_count_ = 0, asked_too_often_ = 0;
};

}  // namespace styled::standby
