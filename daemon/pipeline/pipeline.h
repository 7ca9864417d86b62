#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "daemon/perform/frame_processor.h"
#include "daemon/perform/performance.h"
#include "daemon/pipeline/dependencies.h"
#include "daemon/pipeline/stats.h"
#include "daemon/pipeline/timers.h"
#include "daemon/pipeline/worker.h"
#include "daemon/source/source_frame.h"
#include "daemon/source/transport.h"
#include "daemon/standby/replication.h"

namespace styled::pipeline {

// The loop of the thread that processes frames from the datagram's arrival to zmq_send, without a
// queue in between. It polls the sources, decides and performs their data (FrameProcessor,
// requests), logs it (log::Writer) and does the work that is due by time (Timers). When DoWork()
// finds nothing to do, its caller waits for the transports, the publisher and
// mailboxes.wake_pipeline, at most until NextDeadline_ns(). From a performer's second frame on,
// nothing between receive and zmq_send allocates, locks, logs or throws (tests/realtime).
//
// A cycle is bounded for any input. It reads at most kBatch datagrams of each UDP source and 8
// times 16 KiB of a TCP source, and a datagram contains at most as many frames as it may have
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
  // Restores the settings of the last run. Call before the first DoWork.
  void Restore(std::vector<Profile> profiles) { performance_.roster.Restore(std::move(profiles)); }
  // Sets the sources that are merged into performers. Call before the first DoWork.
  void SetLayers(const std::vector<config::Source>& sources);
  // Sets the types of the sources, for status. Call before the first DoWork.
  void SetSourceTypes(std::vector<std::string> types) { stats_.SetSourceTypes(std::move(types)); }
  // Call after the last cycle. Returns the settings if a change of them found the mailbox full,
  // else null.
  std::unique_ptr<std::vector<Profile>> PopUnsaved();

  // Performs a recorded silence. With Dependencies::decisions only.
  void OnSilence(const v1::Silence& silence);

  int DoWork() override;
  std::int64_t NextDeadline_ns() const override;
  bool Expects(std::int64_t now_ns) const override { return timers_.Expects(now_ns); }
  const std::vector<std::unique_ptr<source::Transport>>& transports() const { return transports_; }

  void OnFrames(int source, std::span<const source::SourceFrame> frames,
                bool more_waiting) override;
  STYLED_REALTIME void OnArrival(const source::Arrival& arrival) noexcept override {
    performance_.log.OnArrival(arrival);
  }
  void OnNote(int source, const std::string& text) override;
  void OnNotice(int source, const std::string& text) override;

 private:
  int DoSources();
  int DoCommands();
  int DoReloads();
  int DoTakes(std::int64_t now_ns);
  int DoSubscriptions();
  bool Drained(bool worked);
  void Perform(std::unique_ptr<Exchange> exchange);
  void Return(std::unique_ptr<Exchange> exchange);
  void Adopt(std::shared_ptr<const RuntimeConfig> config, bool reloaded);

  const Dependencies dependencies_;
  std::vector<std::unique_ptr<source::Transport>> transports_;
  Performance performance_;
  FrameProcessor frames_;
  std::optional<standby::Replication> replication_;  // with [standby] only
  Stats stats_;
  Timers timers_;
  publish::SubscriptionEvent subscription_;
  int busy_cycles_ = 0;  // since silence was last checked
};

}  // namespace styled::pipeline
