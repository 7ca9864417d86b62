#pragma once

#include <netinet/in.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "daemon/config/config.h"
#include "daemon/source/performer_stream.h"
#include "daemon/source/rigs/natnet_skeleton.h"
#include "daemon/source/translator.h"
#include "proto/rigs/natnet/dialogue.h"
#include "proto/rigs/natnet/frame.h"

namespace styled::source {

// OptiTrack's Motive, or whoever else speaks NatNet 2.7 to 4.2: asks the server who it is and what
// it tracks, keeps it sending, and makes a performer of every skeleton, called as there; NAME-2,
// ... where a name is taken. CONNECT is repeated once a second while nobody answers, and again when
// the server has been silent for two seconds; the model is asked for again when the server says
// that it changed or an unknown skeleton comes. Frames count only from the server's own address.
// Bodies and poses are +Y up. Talks through Outbox::Reply; its sockets are the transport's
// (daemon/source/natnet.h). Pipeline thread. Pinned by tests/unit/natnet/translator_test.cpp.
class NatNet final : public Translator {
 public:
  // Where a server sends its frames when it does not send them to the command socket.
  struct Stream {
    in_addr group{};
    std::uint16_t port = 0;
    friend bool operator==(const Stream& a, const Stream& b) {
      return a.group.s_addr == b.group.s_addr && a.port == b.port;
    }
  };

  // `server`: its command port. `group`: config.group.
  NatNet(const config::Source& config, const sockaddr_in& server, in_addr group);

  void Take(std::span<const std::byte> datagram, const Peer& peer, std::int64_t now_ns,
            Outbox& out) override;
  void Tick(std::int64_t now_ns, Outbox& out) override;
  std::int64_t NextDeadline_ns() const override { return next_pulse_ns_; }

  // What to join; nothing before the server answered, or where it streams to each client. From 3.0
  // on the server says so, before that the config does.
  const std::optional<Stream>& stream() const { return stream_; }

 private:
  struct Performer {
    explicit Performer(std::string name) : stream(std::move(name)) {}
    std::int32_t id = 0;
    PerformerStream stream;
    NatNetSkeleton skeleton;
    rig::RigPose pose;
  };
  enum class Order { kNext, kOld };

  void TakeServerInfo(std::span<const std::byte> payload, std::int64_t now_ns, Outbox& out);
  void TakeModel(std::span<const std::byte> payload, Outbox& out);
  void TakeFrame(std::span<const std::byte> payload, std::int64_t now_ns, Outbox& out);
  Order Sort(std::uint64_t& lost, Outbox& out);
  void Send(std::int64_t now_ns, std::uint64_t lost, Outbox& out);
  Performer* Find(std::int32_t skeleton) noexcept;
  bool Adopt(const natnet::SkeletonDescription& description,
             std::vector<std::unique_ptr<Performer>>& performers, Outbox& out);
  void WatchConvention(Outbox& out);

  void AskWho(Outbox& out);
  void AskForModel(std::int64_t now_ns, Outbox& out);
  void SendCommand(natnet::MessageId id, Outbox& out);
  // A line for the log, once.
  void Say(std::string text, Outbox& out);

  config::Source config_;
  Peer server_;
  in_addr group_;
  std::optional<Stream> stream_;
  std::optional<natnet::Version> version_;  // once the server answered
  std::int64_t next_pulse_ns_ = 0, heard_ns_ = 0, asked_model_ns_ = 0;
  bool wants_model_ = false;
  bool model_whole_ = true;  // false: unknown skeletons are those that the model could not give
  std::uint32_t asked_who_ = 0;
  int bad_frames_ = 0;  // in a row

  std::vector<std::unique_ptr<Performer>> performers_;
  NatNetConventionFinder convention_;
  bool flags_ = false;  // a bone was marked as tracked: the marks mean something
  bool any_frame_ = false;
  std::int32_t last_number_ = 0;
  // From frame to frame: servers may send every n-th only.
  std::uint32_t stride_ = 0, last_step_ = 0, steady_ = 0;
  Timecode timecode_;
  std::vector<std::string> said_;
  std::unique_ptr<natnet::Frame> frame_ = std::make_unique<natnet::Frame>();
  std::unique_ptr<natnet::Model> model_ = std::make_unique<natnet::Model>();
};

}  // namespace styled::source
