#pragma once

#include <netinet/in.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "daemon/config/config.h"
#include "daemon/source/logged_lines.h"
#include "daemon/source/performer_stream.h"
#include "daemon/source/props.h"
#include "daemon/source/rigs/natnet_skeleton.h"
#include "daemon/source/translator.h"
#include "proto/rigs/natnet/dialogue.h"
#include "proto/rigs/natnet/frame.h"

namespace styled::source {

// OptiTrack's Motive and other servers of NatNet 2.7 to 4.2 ("natnet"; bytes: proto/rigs/natnet).
//
// Transport   UDP, a dialogue with `server` (port 1510) through Outbox::Reply; the sockets are the
//             transport's (daemon/source/natnet.h). CONNECT once a second until the server answers,
//             and again when the server was silent for 2 s; the model is requested again when the
//             server says that it changed or an unknown skeleton comes.
// Performer   Each of the server's skeletons, up to 16: its name there; NAME-2, ... where a name is
//             taken.
// Body        The skeleton's bones in metres, made +Y up, dialect "motive". Whether bones are
//             global or local and which axis is up is found in the frames (natnet_skeleton.h),
//             unless `coordinates` and `up` are set.
// Props       Rigid bodies that are tracked and belong to no skeleton, by their names in the model,
//             for every performer.
// Time        The frame's timestamp in seconds; SMPTE timecode where the server has one. A gap in
//             the frame numbers beyond the server's usual step counts as lost frames.
// Session     A new one where frame numbers fall back by 16 or more, or the convention changes.
// Refused     source.ignored for packets from elsewhere than the server, or before it answered;
//             source.malformed; source.bad_version; source.incomplete until the convention is
//             known; pipeline.duplicate, pipeline.reordered, pipeline.before_body and
//             pipeline.bodies_refused; pipeline.props_left_out beyond 16 props.
// Pinned by tests/unit/natnet/translator_test.cpp.
class NatNet final : public Translator {
 public:
  // Where a server sends its frames if not to the command socket.
  struct Stream {
    in_addr group{};
    std::uint16_t port = 0;
    friend bool operator==(const Stream& a, const Stream& b) {
      return a.group.s_addr == b.group.s_addr && a.port == b.port;
    }
  };

  // `server`: its command port. `group`: config.group.
  NatNet(const config::Source& config, const sockaddr_in& server, in_addr group);

  void Handle(std::span<const std::byte> datagram, const Peer& peer, std::int64_t now_ns,
              Outbox& out) override;
  void Tick(std::int64_t now_ns, Outbox& out) override;
  std::int64_t NextDeadline_ns() const override { return next_pulse_ns_; }

  // The group to join. Empty before the server replied, or if it streams to each client. From 3.0
  // on the server states it, before that the configuration does.
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

  void HandleServerInfo(std::span<const std::byte> payload, std::int64_t now_ns, Outbox& out);
  void HandleModel(std::span<const std::byte> payload, Outbox& out);
  void HandleFrame(std::span<const std::byte> payload, std::int64_t now_ns, Outbox& out);
  Order Sort(std::uint64_t& lost, Outbox& out);
  void Send(std::int64_t now_ns, std::uint64_t lost, Outbox& out);
  Performer* Find(std::int32_t skeleton) noexcept;
  STYLED_REALTIME void HandleProps(Outbox& out) noexcept;
  bool Adopt(const natnet::SkeletonDescription& description,
             std::vector<std::unique_ptr<Performer>>& performers, Outbox& out);
  void WatchConvention(Outbox& out);

  void RequestServerInfo(Outbox& out);
  void RequestModel(std::int64_t now_ns, Outbox& out);
  void SendCommand(natnet::MessageId id, Outbox& out);
  // Logs a line, but the same text only once while the server is there.
  void Say(std::string text, Outbox& out);

  config::Source config_;
  Peer server_;
  in_addr group_;
  std::optional<Stream> stream_;
  std::optional<natnet::Version> version_;  // empty until the server replied
  std::int64_t next_pulse_ns_ = 0, heard_ns_ = 0, asked_model_ns_ = 0;
  bool wants_model_ = false;
  bool model_whole_ = true;  // false: unknown skeletons are those that the model lacks
  std::uint32_t asked_who_ = 0;
  int bad_frames_ = 0;  // in a row

  std::vector<std::unique_ptr<Performer>> performers_;
  // The rigid bodies of the server's model that belong to no skeleton, and those of the last frame.
  std::vector<std::pair<std::int32_t, std::string>> prop_names_;
  PropList props_;
  NatNetConventionFinder convention_;
  bool flags_ = false;  // a bone was marked as tracked, so the marks are meaningful
  bool any_frame_ = false;
  std::int32_t last_number_ = 0;
  // Steps between frame numbers: a server may send only every n-th frame.
  std::uint32_t stride_ = 0, last_step_ = 0, steady_ = 0;
  Timecode timecode_;
  LoggedLines logged_;
  std::unique_ptr<natnet::Frame> frame_ = std::make_unique<natnet::Frame>();
  std::unique_ptr<natnet::Model> model_ = std::make_unique<natnet::Model>();
};

// The translator without its sockets, for a recording: its server is config.server as written, or
// none.
std::unique_ptr<Translator> MakeNatNet(const config::Source& config);

}  // namespace styled::source
