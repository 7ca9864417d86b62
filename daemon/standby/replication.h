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

// What a pipeline with [standby] does beyond one without (daemon/standby/README.md): as leader it
// sends what it handles (StateSender), as standby it performs what the leader sends (Follower) and
// keeps its own rigs' frames, and where the leader's entries end it goes on with those. Pipeline
// thread; allocates. Pinned by tests/unit/standby and tests/e2e/standby.
class Replication {
 public:
  // `to`: the pipeline, to which notes of the sources go. All must outlive it.
  Replication(Standby& standby, pipeline::Performance& performance,
              pipeline::FrameProcessor& frames, const Follower::Transports& transports,
              pipeline::Mailboxes& mailboxes, source::Receiver& to);

  StateSender& sender() { return sender_; }
  // Who gets the sources' frames in this turn: the pipeline, or, at the standby, the buffer.
  source::Receiver& receiver();
  // Call once a turn, before the sources. Returns how much was done.
  int DoWork();
  // Answers a request that a standby refuses, or that asks this daemon to lead; false for others.
  bool Answers(pipeline::Exchange& exchange);
  // A configuration comes from the files thread: refuses the style that this daemon made for a
  // client while it lost the lead.
  void OnReload(pipeline::Reload& reload);
  // A style of the leader's was made here, or could not be.
  void OnStyleFollowed(const pipeline::Exchange& exchange);
  // The configuration was read again: the pair compares it anew.
  void OnConfigRead();

 private:
  // Keeps what the sources send for a standby that takes over.
  class BufferingReceiver final : public source::Receiver {
   public:
    explicit BufferingReceiver(Replication& replication) : in_(replication) {}
    void OnFrames(int source, std::span<const source::SourceFrame> frames, bool more) override;
    STYLED_REALTIME void OnArrival(const source::Arrival& arrival) noexcept override {
      in_.to_.OnArrival(arrival);
    }
    void OnNote(int source, const std::string& text) override { in_.to_.OnNote(source, text); }
    void OnNews(int source, const std::string& text) override { in_.to_.OnNews(source, text); }

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
