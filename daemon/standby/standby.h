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
  // What decides this daemon's poses, for the other one, which says its own: a standby of another
  // setup is not ready. Call again where it changes.
  void SetSetup(v1::Setup setup);

  // For the pipeline, in place of the daemon's own.
  FollowClock& clock() { return clock_; }
  BufferedPublisher& publisher() { return publisher_; }
  InputBuffer& input() { return input_; }
  bool leads() const { return roles_.role() == v1::ROLE_LEADING; }

  // Reads the other daemon's next message; false when there is none. `entry` is what the follower
  // does again, at `own_ns` of this daemon's clock; null: nothing. Valid until the next call. What
  // is no message of the other daemon is counted, told and changes nothing.
  struct Step {
    Change change = Change::kNone;
    v1::Journal* entry = nullptr;  // until the next call; the caller may take it
    std::int64_t own_ns = 0;
  };
  bool Next(Step& step);
  // Call once a turn, after Next: what silence decides. Says that this daemon is alive.
  Change OnTime();
  std::int64_t NextDeadline_ns() const { return sent_ns_ + beat_ns_; }
  // Somebody wants this daemon to lead. Returns why it cannot, or "": it does so as soon as the
  // leader has said goodbye, or is silent.
  Status RequestLead();
  // Tells the other one that this daemon stops, so that it need not wait.
  void Leave();

  // The leader's part. `epoch`: of its frames.
  void SetEpoch(std::uint64_t epoch) { epoch_ = epoch; }
  // Whether the other daemon listens. While it does not, entries are only counted.
  bool wanted() const;
  // An empty entry to fill and to Send.
  v1::Journal& NewEntry();
  // Of an entry beyond the largest message the standby hears its name and size instead.
  void Send(std::int64_t now_ns, std::int64_t wall_ns);
  void SkipEntry() { ++number_; }
  // Reads who subscribes, at most kSubscriptionsPerTurn; returns how many were read.
  int DoSubscriptions();
  // True once after the other daemon, or anybody, asked for everything: three times at once, and
  // then once a second. The rest waits.
  bool PopAsked();

  // The follower's part. Ready: it has the state of all performers, its setup is the leader's, and
  // no more than one in a hundred of the last poses are apart from the leader's. Whole: it has the
  // state.
  bool ready() const;
  bool whole() const;
  bool looks() const { return roles_.role() == v1::ROLE_LOOKING; }
  // It has at least a part of the leader's state, in whose epoch it then goes on.
  bool has_part() const { return has_part_; }
  // False: this daemon has everything, and the state that comes is for somebody else.
  bool Begin(const v1::Journal& entry);
  // The state comes: its parts are for this daemon.
  bool fetches() const { return sync_ == Sync::kFetching; }
  // The last part of the settings was taken over; the performers' checkpoints are to come.
  void SettingsRestored(const v1::SettingsPart& last);
  void StyleRestored(const v1::StylePart& part);
  void Restored(const std::string& performer);
  // A part of the state could not be taken over, or something not be repeated: what is here is not
  // the leader's state, until it was fetched again.
  void Failed(std::string why);
  // Asks for the whole state, since what is here may differ from the leader's.
  void Refetch();
  // How a frame was styled: the whole state is fetched again where poses are apart, at most every
  // 10 s. Counts only while the standby has everything.
  void Compared(log::Comparison comparison);
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
  static constexpr int kSubscriptionsPerTurn = 64;
  static constexpr std::int64_t kAgain_ns = 10'000'000'000;
  // Of the last so many poses that were compared, five seconds of one performer, more than so many
  // are apart: it is not a frame or two around a loss.
  static constexpr std::size_t kWindow = 600, kMostApart = kWindow / 100;

  Change Note(Change change);
  // Reads the message in bytes_ into in_. Returns why it is none of the other daemon, or "".
  Status Read();
  void Refuse(std::string why);
  void NotePair(const Peer& peer, std::int64_t now_ns);
  void MeasureClock(std::int64_t now_ns);
  void CompareSetups();
  void NameTooLarge(std::size_t bytes);
  std::string WhyNot() const;
  void SayGoodbye();
  std::int64_t Now_ns() const { return clock_.base().Now_ns(); }

  const config::Standby config_;
  const std::uint64_t daemon_;
  const std::int64_t beat_ns_;  // between signs of life
  std::unique_ptr<Channel> channel_;
  FollowClock clock_;
  BufferedPublisher publisher_;
  InputBuffer input_;
  Roles roles_;

  std::uint64_t epoch_;
  std::uint64_t number_ = 0;  // of the last message that was sent
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
  bool asking_ = false;  // no Beginning has come since
  bool gap_ = false;     // entries were lost since the last Beginning
  std::uint64_t heard_daemon_ = 0, heard_number_ = 0;
  std::int64_t heard_ns_ = 0, reconnected_ns_ = 0;
  std::int64_t listened_ns_ = 0;  // when somebody subscribed last, or the other daemon was heard
  // The leader's clock minus this daemon's: the largest difference seen is that of the fastest
  // message.
  std::int64_t ahead_ns_ = 0, best_ahead_ns_ = 0;
  std::int64_t window_ns_ = 0;  // since when the best is measured
  // Since when the other daemon hears a third one; 0: it does not.
  std::int64_t stranger_ns_ = 0;
  bool heard_ = false, listens_ = false, has_part_ = false;
  bool asked_ = false;               // everything, and it was not sent yet
  std::int64_t next_state_ns_;       // when the state may be sent, of the second in a row
  std::int64_t asks_window_ns_ = 0;  // since when asks_ are counted
  int asks_ = 0;
  std::set<std::string> awaited_;
  std::string why_not_, line_, complaint_, refused_why_;
  std::bitset<kWindow> apart_of_last_;
  std::size_t compared_at_ = 0;
  std::uint64_t compared_ = 0, different_ = 0, apart_ = 0, fetched_ = 0, takeovers_ = 0;
  std::uint64_t refused_ = 0, asked_count_ = 0, asked_too_often_ = 0;
};

}  // namespace styled::standby
