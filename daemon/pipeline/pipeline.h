#pragma once

#include <algorithm>
#include <array>
#include <deque>
#include <memory>
#include <span>
#include <string>
#include <unordered_map>
#include <vector>

#include "daemon/pipeline/commands.h"
#include "daemon/pipeline/dependencies.h"
#include "daemon/pipeline/event_log.h"
#include "daemon/pipeline/layers.h"
#include "daemon/pipeline/overload.h"
#include "daemon/pipeline/roster.h"
#include "daemon/pipeline/stages.h"
#include "daemon/pipeline/stats.h"
#include "daemon/pipeline/takes.h"
#include "daemon/pipeline/worker.h"
#include "daemon/publish/bundle.h"
#include "daemon/publish/subscriptions.h"
#include "daemon/runtime/realtime.h"
#include "daemon/runtime/wall_offset.h"
#include "daemon/source/frame_memory.h"
#include "daemon/source/source_frame.h"
#include "daemon/source/transport.h"
#include "daemon/standby/entry.h"
#include "daemon/standby/standby.h"
#include "proto/styled/v1/journal.pb.h"

namespace styled::pipeline {

// The "checkpoint" of performers who are not here: the number with which their frames may begin.
inline constexpr const char* kJournalSequences = "*";

// The single thread that processes frames from the datagram's arrival to zmq_send, without a queue
// in between. When DoWork() finds nothing to do, its caller waits for the transports, the publisher
// and mailboxes.wake_pipeline, at most until NextDeadline_ns(). From a performer's second frame on
// nothing between receive and zmq_send allocates, locks, logs or throws (tests/realtime).
//
// A cycle is bounded whatever arrives. It handles at most kBatch datagrams of each UDP source and 8
// reads of 16 KiB of a TCP source, and a datagram makes at most as many frames as it may have
// performers (4 of a VMC sender, 8 of Rokoko, 16 of NatNet). A frame runs at most
// stylist::kMaxStepsPerFrame steps of the network, and consecutive frames kMeanStepsPerFrame each.
// The worst cycle of a source with native datagrams is therefore 32 * 64 steps (10 ms at 5 us each)
// once, and 32 * 8 after that.
class Pipeline final : public Worker, public source::Receiver {
 public:
  // `source_names[i]` is the name of source number i of the transports. `epoch` is random and
  // identifies this start of the daemon.
  Pipeline(const Dependencies& dependencies, std::vector<std::string> source_names,
           std::vector<std::unique_ptr<source::Transport>> transports,
           std::shared_ptr<const RuntimeConfig> config, std::uint64_t epoch, int max_subscriptions);
  // The settings of the last run. Call before the first DoWork.
  void Restore(std::vector<Profile> profiles) { roster_.Restore(std::move(profiles)); }
  // The configured sources, of which some are merged into performers. Call before the first DoWork.
  void SetLayers(const std::vector<config::Source>& sources);
  // The configured types, for status. Call before the first DoWork.
  void SetSourceTypes(std::vector<std::string> types) { stats_.SetSourceTypes(std::move(types)); }
  // Call after the last cycle. Returns the settings if a change of them found the mailbox full,
  // else null.
  std::unique_ptr<std::vector<Profile>> PopUnsaved();

  int DoWork() override;
  std::int64_t NextDeadline_ns() const override;
  bool Expects(std::int64_t now_ns) const override;
  const std::vector<std::unique_ptr<source::Transport>>& transports() const { return transports_; }

  void OnFrames(int source, std::span<const source::SourceFrame> frames,
                bool more_waiting) override;
  STYLED_REALTIME void OnArrival(const source::Arrival& arrival) noexcept override {
    if (to_.recorder != nullptr) to_.recorder->OnArrival(arrival);
  }
  void OnNote(int source, const std::string& text) override;
  void OnNotice(int source, const std::string& text) override;

 private:
  // One frame or body of a batch.
  struct Item {
    const source::SourceFrame* frame = nullptr;
    Performer* performer = nullptr;  // null: unknown yet, or a body
    std::int64_t sent_ns = 0;        // when its last topic was sent; 0: not sent
  };

  // A body whose binding waits for a later turn, or a frame behind it.
  struct PutOff {
    int source = 0;
    source::SourceFrame frame;
    source::FrameMemory memory{4096};
  };

  // Keeps what the sources send for a standby that takes over.
  class Holder final : public source::Receiver {
   public:
    explicit Holder(Pipeline& to) : to_(to) {}
    void OnFrames(int source, std::span<const source::SourceFrame> frames, bool more) override;
    STYLED_REALTIME void OnArrival(const source::Arrival& arrival) noexcept override {
      to_.OnArrival(arrival);
    }
    void OnNote(int source, const std::string& text) override { to_.OnNote(source, text); }
    void OnNotice(int source, const std::string& text) override { to_.OnNotice(source, text); }

   private:
    Pipeline& to_;
  };

  // journaling.cpp and following.cpp: all of it with [standby] only.
  bool leads() const { return to_.standby == nullptr || to_.standby->leads(); }
  bool journals() const { return to_.standby != nullptr && to_.standby->wanted(); }
  int DoStandby();
  void OnChange(standby::Standby::Change change);
  void GoOn(std::size_t again);
  void FeedBodies(bool of_all);
  void Feed(const std::unordered_map<std::string, std::size_t>& from, std::size_t again);
  void TellSetup();
  int SendState();
  void SendBeginning();
  void SendPart();
  void FillSettings(v1::SettingsPart& part);
  void FillStyle(const std::string& name, v1::StylePart& part);
  struct Part;
  void FillFading(const Part& from, v1::StylePart& part);
  bool IsNamed(int style) const;
  void FillCheckpoint(const std::string& id, v1::Checkpoint& checkpoint);
  void JournalFrames(int source, std::span<const source::SourceFrame> frames);
  void JournalSilence(std::int64_t now_ns);
  void JournalRequest(const v1::Request& request, const v1::Reply& reply);
  int RepeatWaiting(int most);
  void RepeatFirstWaiting();
  void EndWait();
  void Repeat(const v1::Journal& entry, std::int64_t own_ns);
  void RepeatBeginning(const v1::Journal& entry);
  void RepeatSettings(const v1::SettingsPart& part);
  void RepeatStyle(const v1::StylePart& part);
  void RepeatCheckpoint(const v1::Checkpoint& checkpoint);
  void RepeatBatch(const v1::Batch& batch, std::int64_t own_ns);
  void RepeatSilence(const v1::Silence& silence, std::int64_t own_ns);
  void RepeatRequest(const v1::Request& request);
  void Arrange(const v1::Beginning& beginning);
  void RepeatFading(const v1::StylePart& part);
  void ArrangeIfOther();
  bool ImportsMissing(const std::string& style);
  void Import(const std::string& style);
  void FollowStyles(v1::Request request);
  void AwaitStyle(const v1::Request& request);
  void PassOnStyles();
  void StylesFollowed(const Exchange& exchange);
  bool RefusesOrders(Exchange& exchange);
  void DisownStyle(Reload& reload);
  bool DoesLead(Exchange& exchange);

  int DoCommands();
  int DoReloads();
  void TakeOver(std::shared_ptr<const RuntimeConfig> config, bool reloaded);
  void Return(std::unique_ptr<Exchange> exchange);
  int DoTakes(std::int64_t now_ns);
  int DoSubscriptions();
  int DoTimers(std::int64_t now_ns, bool drained);
  std::int64_t Prepare_ns(const Performer& performer) const;
  void Prepare(Performer& performer, std::int64_t now_ns);

  STYLED_REALTIME void NoteNewest(int index) noexcept;
  void AcceptLayer(Layer& layer, int source, std::span<const source::SourceFrame> frames,
                   runtime::HotSection& hot);
  void AcceptLayerBody(FingerLayer& fingers, int source, const source::SourceFrame& body);
  bool PutsOff(int source, const source::SourceFrame& body);
  bool WaitsForBody(int source, std::string_view performer) const noexcept;
  bool PutOffFrame(int source, const source::SourceFrame& frame);
  int DoPutOff();
  void AcceptBody(int source, const source::SourceFrame& body);
  void AcceptFrame(int source, Item& item, int index, bool full, runtime::HotSection& hot);
  void StyleAccepted(runtime::HotSection& hot);
  bool SendBundles() noexcept;
  // When the frame arrived, on the clock's Now_ns(), at the latest with its batch.
  STYLED_REALTIME std::int64_t ArrivalOf(const source::SourceFrame& frame) const noexcept {
    return frame.arrival_ns == 0 ? receive_ns_ : std::min(frame.arrival_ns, receive_ns_);
  }
  void MeasureLatencies(int source, std::span<const source::SourceFrame> frames,
                        bool bundled) noexcept;
  STYLED_REALTIME void ShareProps(Performer& performer) noexcept;
  STYLED_REALTIME void AwaitNext(Performer& performer, std::int64_t before_ns) noexcept;
  void PassCues(Performer& performer, const Timecode& timecode, runtime::HotSection& hot);
  // Whether the frame's session, sequence and body are valid for the performer; counts the refusal
  // if not.
  STYLED_REALTIME bool Admit(Performer& performer, const Item& item) noexcept;
  STYLED_REALTIME void StartSession(Performer& performer) noexcept;
  STYLED_REALTIME void Recount(Performer& performer) noexcept;
  void AdoptBody(Performer& performer, const source::SourceFrame& body, bool fresh);
  STYLED_REALTIME bool PassOver(Performer& performer, int index, bool full,
                                std::int64_t lateness_ns) const noexcept;
  int LogLayers(std::int64_t now_ns);
  void BalanceLoad(std::int64_t now_ns);
  void TellCalibrated();
  void LookAtWallClock();
  void Stale(Performer& performer, std::int64_t now_ns);
  void Answer(const v1::Request& request, v1::Reply& reply);

  Dependencies to_;
  std::vector<std::unique_ptr<source::Transport>> transports_;
  publish::Subscriptions subscriptions_;
  std::array<publish::Bundle, publish::Subscriptions::kBundleCount> bundles_{
      publish::Bundle(subscriptions_.bundle(publish::Subscriptions::kRigBundle)),
      publish::Bundle(subscriptions_.bundle(publish::Subscriptions::kCanonicalBundle)),
      publish::Bundle(subscriptions_.bundle(publish::Subscriptions::kSourceBundle))};
  Layers layers_;
  Roster roster_;
  Commands commands_;
  Takes takes_;
  SessionRules rules_;
  std::int64_t receive_ns_ = 0, wall_ns_ = 0;  // of the current batch, or the last
  std::array<Item, source::kBatch> items_;
  // Frames of the batch that will be styled together, each of another performer.
  std::array<Performer*, stylist::Stylist::kTogether> accepted_{};
  std::size_t accepted_count_ = 0;
  std::array<int, stylist::Stylist::kTogether> accepted_items_{};  // their places in the batch
  Holder holder_{*this};
  std::array<standby::Outcome, source::kBatch> outcomes_;  // of the batch's frames
  // Of the batch that a standby does again: what the leader made of each frame. Else empty.
  std::span<const standby::Outcome> decided_;
  bool feeds_ = false;  // what was held is handled: no frame of it is passed over
  v1::Silence silence_;
  std::deque<std::unique_ptr<PutOff>> put_off_;  // oldest first
  std::int64_t binding_ns_ = 0;                  // spent on bodies in this turn
  std::vector<v1::Setting> source_settings_;     // of the [[source]] tables, for the other daemon
  // What the leader did to styles and the files thread repeats: what waits for room in the mailbox;
  // how much is in it; styles of the leader's among both; whether one failed since all was done.
  std::deque<v1::Request> style_requests_;
  std::optional<Places> arrange_;  // the leader's places of styles, behind those
  // The places of the state that is being fetched, and how many of their `fading` are to come.
  std::optional<Places> theirs_;
  std::size_t fading_to_come_ = 0;
  int followed_ = 0;
  std::vector<std::string> imports_;
  bool follow_failed_ = false;
  // Whether the leader's state, of which they are, is fetched again once they are done.
  bool fetches_after_styles_ = false;
  // A style that changed while the standby is whole: entries behind it wait until the files thread
  // has done the same, so that motions change at the leader's frame.
  struct Waiting {
    v1::Journal entry;
    std::int64_t own_ns = 0;   // when the leader did it, on this daemon's clock
    std::int64_t read_ns = 0;  // when it was read here
  };
  bool awaits_style_ = false;
  std::int64_t awaits_since_ns_ = 0;
  std::deque<Waiting> waiting_;
  bool tells_all_ = false;  // the standby gets everything anew
  // What the standby still gets of the state, a part a turn.
  struct Part {
    enum class Kind : std::uint8_t { kSettings, kStyle, kFading, kCheckpoint };
    Kind kind = Kind::kSettings;
    std::string name{};     // a style's, or a performer's id
    std::size_t place = 0;  // of kFading
  };
  std::deque<Part> unsent_;
  std::deque<std::string> unsent_settings_;                         // ids, of the parts kSettings
  std::array<standby::RoundedPose, source::kBatch> rounded_poses_;  // of the batch's frames
  Stages stages_;
  Stats stats_;
  EventLog log_;
  publish::SubscriptionEvent subscription_;
  int busy_cycles_ = 0;  // since silence was last checked
  runtime::WallWatch wall_watch_;
  Overload overload_;
  Overload::Batch batch_;  // the current one
};

}  // namespace styled::pipeline
