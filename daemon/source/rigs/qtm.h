#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "daemon/config/config.h"
#include "daemon/source/logged_lines.h"
#include "daemon/source/performer_stream.h"
#include "daemon/source/rigs/qtm_skeleton.h"
#include "daemon/source/tcp_client.h"
#include "proto/rigs/qtm/frame.h"
#include "proto/rigs/qtm/parameters.h"

namespace styled::source {

// Qualisys Track Manager, QTM RT 1.19 to 1.25 ("qtm"; bytes: proto/rigs/qtm).
//
// Transport   TCP, a dialogue with `server` (port 22223; daemon/source/tcp_client.h). After the
//             greeting the newest version that the server accepts, then General, 3D and Skeleton of
//             its parameters, then all frames of Skeleton and Timecode; of Skeleton alone, if the
//             server objects. Each request has 5 s; an error is logged with the server's text,
//             and once per connection that no frame came within 5 s, which is not an error: QTM may
//             be between measurements. No request changes QTM.
// Performer   Each skeleton that QTM knows, up to 16: its name there; NAME-2, ... where a name is
//             taken. A skeleton that QTM does not see sends no frames.
// Body        The skeleton's segments in millimetres, made +Y up by QTM's AxisUpwards (`up` of the
//             source overrides it); the rest pose is QTM's T-pose.
// Time        The cameras' timestamp; SMPTE timecode, or IRIG's time of day. A gap in the frame
//             numbers counts as lost frames.
// Session     A new one when a measurement or a file begins (events 1, 3, 8), or where timestamps
//             fall back. General, 3D and Skeleton are read again then, and when a frame has unknown
//             skeletons: at most once a second, and increasingly seldom, down to once a minute,
//             while nothing changes.
// Refused     source.malformed; source.ignored for packets that were not asked for;
//             pipeline.duplicate, pipeline.before_body and pipeline.bodies_refused.
// Pinned by tests/unit/qtm/translator_test.cpp.
class Qtm final : public ServerTranslator {
 public:
  explicit Qtm(const config::Source& config);

  void Handle(std::span<const std::byte> record, const Peer& peer, std::int64_t now_ns,
              Outbox& out) override;
  void Tick(std::int64_t now_ns, Outbox& out) override;
  std::int64_t NextDeadline_ns() const override {
    return std::min({answer_ns_, again_ns_, reread_ns_, silence_ns_});
  }

  CutReader::Cutter cutter() const override { return qtm::CutPacket; }
  std::size_t max_record() const override { return qtm::kMaxXmlSize; }
  std::string WhyBroken(std::span<const std::byte> received) const override {
    return qtm::WhyBroken(received);
  }
  void Connected(std::int64_t now_ns) override;
  bool ready() const override { return stage_ == Stage::kStreaming; }
  std::string NextFault() override { return std::exchange(fault_, {}); }

 private:
  // The awaited answer. The stages after kVersion send one request each.
  enum class Stage { kGreeting, kVersion, kGeneral, kSpace, kSkeletons, kStreaming };
  struct Performer {
    explicit Performer(std::string name) : stream(std::move(name)) {}
    PerformerStream stream;
    QtmSkeleton skeleton;
    rig::RigPose pose;
  };

  void HandleText(std::string_view text, std::int64_t now_ns, Outbox& out);
  void HandleError(std::string_view text, std::int64_t now_ns, Outbox& out);
  void RefuseReread(const std::string& words, std::int64_t now_ns, Outbox& out);
  void RefuseStream(const std::string& words, std::int64_t now_ns, Outbox& out);
  void HandleXml(std::string_view xml, std::int64_t now_ns, Outbox& out);
  void HandleEvent(qtm::Event event, std::int64_t now_ns, Outbox& out);
  void HandleFrame(std::span<const std::byte> payload, std::int64_t now_ns, Outbox& out);
  void HandleVersion(std::string_view answer, std::int64_t now_ns, Outbox& out);
  // These return whether anything changed; HandleSkeletons also if `changed` was true. They log the
  // present state then.
  bool HandleVolume(const qtm::Parameters& parameters);
  bool HandleSkeletons(const std::vector<qtm::SkeletonDescription>& skeletons, bool changed,
                       Outbox& out);
  bool Adopt(const qtm::SkeletonDescription& description,
             std::vector<std::unique_ptr<Performer>>& performers, Outbox& out);

  void Enter(Stage stage, std::int64_t now_ns, Outbox& out);
  void Ask(std::string_view command, std::int64_t now_ns, Outbox& out);
  void Send(std::string_view command, Outbox& out) noexcept;
  void RequestSkeletons(std::int64_t now_ns, Outbox& out);
  void StartStream(std::int64_t now_ns, Outbox& out);
  std::string_view StreamCommand() const noexcept;
  void ConfirmStream(std::int64_t now_ns) noexcept;
  void ReportNoFrame(Outbox& out);
  bool IsAsking() const noexcept { return answer_ns_ != kNever; }
  // Requests the skeletons again as soon as the pause since the last time is over.
  STYLED_REALTIME void ScheduleSkeletons(std::int64_t now_ns) noexcept;
  // Call after the skeletons were read again, or could not be.
  void EndReread(bool changed, std::int64_t now_ns) noexcept;
  void BeginSession(std::int64_t now_ns) noexcept;
  bool ReadTimecode() noexcept;
  // Logs a line, but the same text only once while the server is there.
  void Say(const std::string& text, Outbox& out);
  std::string Server() const { return "server " + config_.server; }

  config::Source config_;
  Peer server_;
  Stage stage_ = Stage::kGreeting;
  int minor_ = qtm::kNewestMinor;  // of the requested version
  bool timecode_wanted_ = true;
  bool only_skeletons_ = false;  // skeletons are requested again; the server objected to more since
                                 // the session began
  std::string asked_, fault_;    // the last request; the reason why the connection is to be closed
  std::int64_t answer_ns_ = kNever;   // the deadline of its answer; kNever: it was answered
  std::int64_t again_ns_ = kNever;    // when the stage's request is repeated
  std::int64_t reread_ns_ = kNever;   // when the skeletons are requested again
  std::int64_t silence_ns_ = kNever;  // when the absence of frames is logged
  // The time of the last request for skeletons, and the pause until the next.
  std::int64_t asked_skeletons_ns_ = 0, reread_pause_ns_ = 0;

  std::optional<double> frequency_hz_;
  qtm::Axis up_ = qtm::Axis::kZ;
  // In the order of the XML; null: a refused skeleton.
  std::vector<std::unique_ptr<Performer>> performers_;
  // Of the last StreamFrames: when it was sent, and whether a frame has arrived since. An error
  // before the first frame is its answer.
  std::int64_t stream_ns_ = 0;
  bool stream_confirmed_ = false;
  bool no_measurement_ = false,
       silence_said_ = false;  // QTM reported it; the absence of frames was logged
  bool any_frame_ = false;
  std::int64_t last_us_ = 0;
  std::uint32_t last_number_ = 0;
  Timecode timecode_;
  LoggedLines logged_;
  std::unique_ptr<qtm::Frame> frame_ = std::make_unique<qtm::Frame>();
};

}  // namespace styled::source
