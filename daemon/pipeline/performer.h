#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "daemon/pipeline/anticipation.h"
#include "daemon/pipeline/body_binding.h"
#include "daemon/pipeline/facing.h"
#include "daemon/pipeline/mailboxes.h"
#include "daemon/pipeline/pose_history.h"
#include "daemon/pipeline/profile.h"
#include "daemon/pipeline/session.h"
#include "daemon/publish/frame_message.h"
#include "daemon/publish/publisher.h"
#include "daemon/publish/subscriptions.h"
#include "daemon/runtime/counters.h"
#include "daemon/runtime/histogram.h"
#include "daemon/runtime/schedule.h"
#include "daemon/source/source_frame.h"
#include "model/stylist/stylist.h"
#include "proto/styled/v1/control.pb.h"
#include "proto/styled/v1/stats.pb.h"

namespace styled::pipeline {

// What is published of a performer; each serialized only while somebody subscribes.
enum TopicIndex : std::uint8_t {
  kRigTopic,
  kCanonicalTopic,
  kSourceTopic,
  kBodyTopic,
  kTopicCount
};

// The live state of one performer, from its first body until it is forgotten. Pipeline thread only.
class Performer {
 public:
  // `profile` and the references outlive it. `source` and `name` make up the profile's id.
  Performer(Profile& profile, int source, std::string name, std::uint64_t epoch,
            publish::Subscriptions& subscriptions, runtime::Counters& counters);
  ~Performer();
  Performer(const Performer&) = delete;
  Performer& operator=(const Performer&) = delete;

  // Binds a new body and makes the stylist for it. Allocates. An error leaves the last body; where
  // there is none and its joints at least are known, the performer waits() for a calibration.
  Status AcceptBody(const source::SourceFrame& body, const RuntimeConfig& config);
  bool has_body() const { return history_ != nullptr; }
  bool waits() const { return has_body() && bound_ == nullptr; }
  // What control.proto says of Calibrate, for rigs that have a skeleton. Allocates.
  v1::Code Calibrate(const v1::Calibrate& request, const RuntimeConfig& config, std::int64_t now_ns,
                     v1::Reply& reply);
  std::uint32_t body_crc() const { return body_crc_; }

  // The settings of the profile, from the next frame on. Weights or options changed: new stylist.
  // Allocate; return the styles of the profile that the network lacks.
  std::vector<std::string> ApplyLook(const RuntimeConfig& config);
  void Rebuild(const RuntimeConfig& config);

  // The recurrent state starts anew; the next frame's source time may be anything.
  STYLED_REALTIME void Restart() noexcept;

  // One frame in three steps, so that several performers are styled together: Accept copies it,
  // Stylist::ProcessTogether runs the jobs of Style(), Finish serializes it for the topics that are
  // wanted. A frame of another joint count than the body's is refused; while the performer waits()
  // its pose is remembered. `elapsed_ns` as the session's.
  enum class Accepted : std::uint8_t { kOk, kWrongSize, kUncalibrated };
  struct FrameContext {
    std::int64_t elapsed_ns = 0;
    std::int64_t receive_ns = 0, publish_ns = 0, wall_ns = 0;
    std::uint64_t source_sequence = 0;
    std::uint32_t extra_flags = 0;
  };
  STYLED_REALTIME Accepted Accept(const source::SourceFrame& frame,
                                  const FrameContext& context) noexcept;
  STYLED_REALTIME stylist::Stylist::Job Style() noexcept;
  STYLED_REALTIME void Finish(std::int64_t publish_ns) noexcept;
  // Brings what the next frame needs into the caches. Changes nothing.
  STYLED_REALTIME void Prewarm() noexcept;
  // The last pose again, flagged stale. False when there is none.
  STYLED_REALTIME bool Repeat(FrameContext context) noexcept;
  // Sends what Style or Repeat serialized, and measures from context.receive_ns to now.
  void Send(publish::Publisher& publisher, std::int64_t now_ns);
  void SendBodies(publish::Publisher& publisher);

  // Of the last second; called once a second.
  void Sample();
  void Describe(v1::PerformerStats& stats) const;

  Session session;
  runtime::Schedule schedule;
  Anticipation anticipation;
  const int source;
  const std::string name;
  bool session_has_body = false;  // this session sent its body
  bool sends_frames = false;      // of its body; calibrated or not
  bool live = false;              // frames leave: not stale
  std::int64_t next_body_ns = 0, last_send_ns = 0;
  std::int64_t last_frame_ns = 0;  // arrival of the last frame that was styled
  // Silence after which the performer is stale: `stale_ns`, or three periods of a slower rig.
  STYLED_REALTIME std::int64_t Patience_ns(std::int64_t stale_ns) const noexcept;
  // A frame that arrived at `now_ns` is on its way out: the performer is live.
  STYLED_REALTIME void MarkLive(std::int64_t now_ns) noexcept;
  // When its live state was made.
  std::int64_t added_ns = 0;
  // Whether one more change of the body may be made now: kBodyChanges at once and one in
  // kBodyChange_ns, since each makes all anew that depends on it.
  bool MayChangeBody(std::int64_t now_ns) noexcept;
  // A datagram of this performer changed nothing, and is counted as `why`.
  STYLED_REALTIME void MarkRefused(runtime::Counter why) noexcept {
    ++refused_;
    refused_as_ = why;
  }
  // What looks wrong with the rig; "" for nothing. True from FacingChanged() once after each
  // change.
  std::string Warning() const;
  bool FacingChanged() noexcept;
  std::uint64_t received = 0;            // frames accepted
  int newest_in_batch = -1;              // scratch of the pipeline
  std::optional<std::int64_t> timecode;  // TimecodeLabel of the last frame that had one
  std::array<publish::Topic, kTopicCount> topics;
  // Whether a new subscriber waits for the bodies.
  bool Asked() const;
  Profile& profile;

 private:
  struct Bound;
  struct RetargetStream;
  Status Bind(const RuntimeConfig& config);
  const rig::JointNames& Names(const RuntimeConfig& config) const;
  void Serialize(std::uint32_t flags, const FrameContext& context) noexcept;
  void CountFlags(std::uint32_t flags) noexcept;

  std::uint64_t epoch_;
  publish::Subscriptions& subscriptions_;
  runtime::Counters& counters_;
  v1::Body given_;                        // as the rig sent it
  std::unique_ptr<PoseHistory> history_;  // of its skeleton
  rig::RigPose received_;
  std::unique_ptr<Bound> bound_;
  std::uint32_t body_crc_ = 0;
  FrameContext context_;                             // of the frame accepted
  std::array<std::span<const std::byte>, 3> ready_;  // serialized, per topic; empty: not wanted
  std::int64_t receive_ns_ = 0;
  bool measured_ = false;
  std::uint64_t published_ = 0, published_at_sample_ = 0;
  std::int64_t since_ns_ = 0;                   // the last frame that the rate counts
  bool fresh_ = true;                           // that one was the first after a silence
  std::array<std::int64_t, 2> intervals_ns_{};  // between the last frames
  static constexpr int kBodyChanges = 8;        // what a rig that finds its bones one by one takes
  static constexpr std::int64_t kBodyChange_ns = 500'000'000;
  int body_changes_left_ = kBodyChanges;
  std::int64_t body_changed_ns_ = 0;
  std::uint64_t refused_ = 0, refused_at_sample_ = 0;
  runtime::Counter refused_as_ = runtime::Counter::kCount;
  bool refusing_ = false;  // of the last second
  Facing facing_;
  std::int64_t faced_ns_ = 0;  // source time of its last frame
  bool backwards_ = false, backwards_logged_ = false;
  runtime::Histogram latency_;
  float rate_hz_ = 0, p50_us_ = 0, p99_us_ = 0, max_us_ = 0;
};

}  // namespace styled::pipeline
