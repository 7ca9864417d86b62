#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <unordered_map>
#include <vector>

#include "daemon/config/config.h"
#include "daemon/looks/mailboxes.h"
#include "daemon/perform/frame_processor.h"
#include "daemon/perform/performance.h"
#include "daemon/source/transport.h"
#include "daemon/standby/follower.h"
#include "daemon/standby/standby.h"
#include "daemon/standby/state_sender.h"
#include "daemon/standby/style_follower.h"

namespace styled::standby {

// The additional work of a pipeline with [standby] (daemon/standby/README.md). As the leader it
// sends its entries (StateSender). As the standby it performs the leader's entries (Follower) and
// buffers its own rigs' frames; after a takeover it continues with those. Pipeline thread;
// allocates. Pinned by tests/unit/standby and tests/e2e/standby.
class Replication {
 public:
  // `to`: the pipeline, which receives the sources' notes. All must outlive it.
  Replication(Standby& standby, pipeline::Performance& performance,
              pipeline::FrameProcessor& frames, const Follower::Transports& transports,
              pipeline::Mailboxes& mailboxes, source::Receiver& to);

  StateSender& sender() { return sender_; }
  // The receiver of the sources' frames in this turn: the pipeline, or at a standby the buffer.
  source::Receiver& receiver();
  // Call once a turn, before the sources. Returns the number of entries and messages.
  int DoWork();
  // Answers requests that a standby refuses, and Lead. Returns false for all others.
  bool Answers(pipeline::Exchange& exchange);
  // Call with each configuration from the files thread. Refuses a style that this daemon has made
  // for a client if it lost the lead meanwhile.
  void OnReload(pipeline::Reload& reload);
  // A style of the leader was made here, or failed.
  void OnStyleFollowed(const pipeline::Exchange& exchange);
  // The configuration was read again: the daemons compare their configurations again.
  void OnConfigRead();

 private:
  // Buffers the frames of a standby's sources for a takeover.
  class BufferingReceiver final : public source::Receiver {
   public:
    explicit BufferingReceiver(Replication& replication) : in_(replication) {}
    void OnFrames(int source, std::span<const source::SourceFrame> frames, bool more) override;
    STYLED_REALTIME void OnArrival(const source::Arrival& arrival) noexcept override {
      in_.to_.OnArrival(arrival);
    }
    void OnNote(int source, const std::string& text) override { in_.to_.OnNote(source, text); }
    void OnNotice(int source, const std::string& text) override { in_.to_.OnNotice(source, text); }

   private:
    Replication& in_;
  };

  void OnChange(Standby::Change change);
  void ContinueFrames(std::size_t resent);
  void ProcessBodies(bool of_all);
  void ProcessBuffered(const std::unordered_map<std::string, std::size_t>& from,
                       std::size_t resent);

  Standby& standby_;
  pipeline::Performance& performance_;
  pipeline::FrameProcessor& frames_;
  pipeline::Mailboxes& mailboxes_;
  source::Receiver& to_;
  BufferingReceiver buffering_{*this};
  StateSender sender_;
  StyleFollower styles_;
  Follower follower_;
};

}  // namespace styled::standby
