#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "daemon/pipeline/facing.h"
#include "daemon/pipeline/performer/admission.h"
#include "daemon/pipeline/performer/binding.h"
#include "daemon/pipeline/performer/outputs.h"
#include "daemon/pipeline/performer/styling.h"
#include "daemon/pipeline/profile.h"
#include "daemon/pipeline/runtime_config.h"
#include "daemon/source/source_frame.h"
#include "model/stylist/stylist.h"
#include "proto/styled/v1/control.pb.h"
#include "proto/styled/v1/stats.pb.h"

namespace styled::pipeline {

// The live state of one performer, from its first body until it is forgotten: which datagrams count
// (Admission), the body and its calibration (PerformerBinding), the stylist (Styling) and what
// leaves (Outputs). Pipeline thread only.
class Performer {
 public:
  // `profile` and the references outlive it. `source` and `name` make up the profile's id.
  Performer(Profile& profile, int source, std::string name, std::uint64_t epoch,
            std::int64_t now_ns, publish::Subscriptions& subscriptions,
            runtime::Counters& counters);

  // Binds a new body and makes the stylist for it. Allocates. An error leaves the last body; where
  // there is none and its joints at least are known, the performer waits for a calibration.
  Status AcceptBody(const source::SourceFrame& body, const RuntimeConfig& config);
  // PerformerBinding::Calibrate, and a stylist for what it bound. Allocates.
  v1::Code Calibrate(const v1::Calibrate& request, const RuntimeConfig& config, std::int64_t now_ns,
                     v1::Reply& reply);
  const PerformerBinding& binding() const { return binding_; }

  // The settings of the profile, from the next frame on. Weights or options changed: new stylist.
  // Allocate; return the styles of the profile that the network lacks.
  std::vector<std::string> ApplyLook(const RuntimeConfig& config);
  void Rebuild(const RuntimeConfig& config);

  // The recurrent state starts anew; the next frame's source time may be anything.
  STYLED_REALTIME void Restart() noexcept;

  // One frame in three steps, so that several performers are styled together: Accept copies it,
  // Stylist::ProcessTogether runs the jobs of Style(), Finish serializes it for the topics that are
  // wanted. A frame of another joint count than the body's is refused; while the performer waits
  // for a calibration its pose is remembered. `elapsed_ns` as the session's.
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
  // Sends what Finish or Repeat serialized, and measures a frame from its receive_ns to now.
  void Send(publish::Publisher& publisher, std::int64_t now_ns);

  // What looks wrong with the rig; "" for nothing. True from FacingChanged() once after each
  // change.
  std::string Warning() const;
  bool FacingChanged() noexcept;

  // Of the last second; called once a second.
  void Sample();
  void Describe(v1::PerformerStats& stats) const;

  Profile& profile;
  const int source;
  const std::string name;
  const std::int64_t added_ns;  // when this live state was made
  Admission admission;
  Outputs outputs;
  std::int64_t next_body_ns = 0;         // when the bodies are due again
  int newest_in_batch = -1;              // scratch of the pipeline
  std::optional<std::int64_t> timecode;  // TimecodeLabel of the last frame that had one

 private:
  // Everything that depends on the body that binding_ has bound.
  void UseBinding(const RuntimeConfig& config);
  const rig::JointNames& Names(const RuntimeConfig& config) const;
  STYLED_REALTIME void WatchFacing() noexcept;
  STYLED_REALTIME void Serialize(std::uint32_t flags, const FrameContext& context) noexcept;

  runtime::Counters& counters_;
  PerformerBinding binding_;
  std::optional<Styling> styling_;               // while a body is bound
  FrameContext context_;                         // of the frame accepted
  publish::FrameHeader header_;                  // its source's part
  std::vector<std::byte> face_;                  // what is passed on beside the pose
  std::optional<std::int64_t> measure_from_ns_;  // of what is serialized; nothing: a repetition
  Facing facing_;
  std::int64_t faced_ns_ = 0;  // source time of its last frame
  bool backwards_ = false, backwards_logged_ = false;
};

}  // namespace styled::pipeline
