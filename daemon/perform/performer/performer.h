#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "daemon/decide/admission.h"
#include "daemon/decide/frame_in_transit.h"
#include "daemon/log/frame_history.h"
#include "daemon/looks/profile.h"
#include "daemon/looks/runtime_config.h"
#include "daemon/perform/performer/binding.h"
#include "daemon/perform/performer/carried_props.h"
#include "daemon/perform/performer/facing.h"
#include "daemon/perform/performer/fingers.h"
#include "daemon/perform/performer/idle_layer.h"
#include "daemon/perform/performer/latency.h"
#include "daemon/perform/performer/outputs.h"
#include "daemon/perform/performer/smoothing.h"
#include "daemon/perform/performer/styling.h"
#include "daemon/source/source_frame.h"
#include "model/base/checkpoint.h"
#include "model/rig/mirror.h"
#include "model/stylist/stylist.h"
#include "proto/styled/v1/control.pb.h"
#include "proto/styled/v1/stats.pb.h"

namespace styled::pipeline {

// The live state of one performer, from its first body until it is forgotten: its datagrams
// (decide::Admission), its body and calibration (PerformerBinding), its stylist (Styling) and its
// published output (Outputs). Pipeline thread only.
class Performer {
 public:
  // `profile` and all references must outlive it. `source` and `name` make up the profile's id.
  Performer(Profile& profile, int source, std::string name, std::uint64_t epoch,
            std::int64_t now_ns, publish::Subscriptions& subscriptions,
            runtime::Counters& counters);

  // The fingers that sources merge into the performer; they must outlive it. Call before the first
  // body.
  void SetFingers(std::vector<FingerLayer*> layers);
  // Binds a new body and makes the stylist for it. Allocates. After an error the last body stays;
  // if there is none and at least its joints are recognized, the performer waits for a calibration.
  Status AcceptBody(const source::SourceFrame& body, const RuntimeConfig& config);
  // Calls PerformerBinding::Calibrate and makes a stylist for the new binding. Allocates.
  Result<v1::CalibrateReply> Calibrate(const v1::Calibrate& request, const RuntimeConfig& config,
                                       std::int64_t now_ns);
  // Executes Calibrate with `neutral` (control.proto).
  Status CalibrateNeutral(const v1::Calibrate& request);
  // Copies the stylist's knowledge of the performer's neutral into the profile, before either ends.
  void KeepNeutral();
  // The neutral to save; the profile's if there is no stylist.
  std::optional<KeptNeutral> TellNeutral() const;
  // Returns true once after a calibration of the neutral has ended; calibrated() gives the result.
  bool PopNeutralCalibrated() noexcept;
  // Whether the current motion refers to the style (Stylist::Names).
  bool Names(int style) const { return styling_ && styling_->stylist().Names(style); }
  bool calibrated() const { return styling_ && styling_->stylist().neutral().calibrated(); }
  const PerformerBinding& binding() const { return binding_; }
  // Whether the last frame has props that belong to all performers of the source.
  bool shares_props() const { return props_ && props_->of_the_scene() && !props_->empty(); }

  // ApplyLook applies the profile's settings from the next frame on, and returns the styles of the
  // profile that the network lacks. Rebuild makes a new stylist after weights or options changed.
  // Both allocate. Adopt continues with a network that differs only in its styles.
  std::vector<std::string> ApplyLook(const RuntimeConfig& config);
  void Rebuild(const RuntimeConfig& config);
  void Adopt(const RuntimeConfig& config);

  // Omits the style from the next frame on because the machine is overloaded, or restores it. The
  // profile's look is unchanged.
  STYLED_REALTIME void Relieve(bool relieved) noexcept;
  bool relieved() const { return relieved_; }
  STYLED_REALTIME void CountRelieved() noexcept { ++relieved_frames_; }

  // Resets the recurrent state; the next frame's source time may be anything.
  STYLED_REALTIME void Restart() noexcept;

  // Saves or restores everything on which the next frames depend, except body and profile, which
  // must be the same for both performers (model/base/checkpoint.h; checkpoint.proto lists what is
  // left out). The performer must be bound. `now_ns`: on the daemon's monotonic clock.
  STYLED_REALTIME void Carry(Checkpoint& c, std::int64_t now_ns) noexcept;

  // Processes one frame in steps, so that several performers are styled together: Accept copies it,
  // Stylist::ProcessTogether runs the jobs of Style(), Attach finds the props in the performer's
  // hands, Finish serializes it for the subscribed topics. Accept returns kNoReason, or the counter
  // of its refusal: the joint count differs from the body's, or the performer waits for a
  // calibration, for which it only stores the pose.
  STYLED_REALTIME runtime::Counter Accept(const decide::FrameInTransit& frame) noexcept;
  // As Accept while the rig is silent: its last pose with the motion of an idle body, at the
  // session's time of `transit`. Returns false if there is none. The frame is flagged stale.
  STYLED_REALTIME bool AcceptSilent(const decide::FrameInTransit& transit) noexcept;
  STYLED_REALTIME stylist::Stylist::Job Style() noexcept;
  STYLED_REALTIME void Attach() noexcept { props_->Attach(styling_->out()); }
  // Leaves out the props of the scene that another performer of the same source holds.
  STYLED_REALTIME void LeavePropsTo(const Performer& other) noexcept;
  STYLED_REALTIME void Finish(std::int64_t publish_ns) noexcept;
  // The frame being processed, or the last one; `given` and `face` are not kept.
  const decide::FrameInTransit& frame() const noexcept { return frame_; }
  // Brings the next frame's data into the caches. Changes nothing.
  STYLED_REALTIME void Prewarm() noexcept;
  // Serializes the last pose again, flagged stale, with the times of `now`. Returns false if there
  // is no pose.
  STYLED_REALTIME bool Repeat(const decide::FrameInTransit& now) noexcept;
  // Sends the frames that Finish or Repeat serialized, and adds them to the bundles.
  void Send(publish::Publisher& publisher, std::span<publish::Bundle> bundles, std::int64_t now_ns);

  // CRC-32C of the last styled pose on the canonical body; 0 before the first.
  STYLED_REALTIME std::uint32_t StyledCrc() const noexcept;
  // That pose; null before the first.
  const body::Pose* styled() const noexcept {
    return styling_ && styling_->has_output() ? &styling_->out().canonical : nullptr;
  }

  // The performer's last pose as captured, and its time in the session; null before the first.
  const body::Pose* input() const noexcept {
    return styling_ && styling_->has_output() ? &styling_->out().canonical_input : nullptr;
  }
  std::int64_t elapsed_ns() const noexcept { return frame_.elapsed_ns; }
  // Whether the body moves by itself while its rig is silent.
  bool idles() const noexcept { return idle_ && profile.look.idle() > 0 && idle_->has_pose(); }

  // As Fingers::HandsWithoutPlace, of the bound body.
  std::string HandsWithoutPlace() const { return fingers_.HandsWithoutPlace(); }

  // Warning() describes what looks wrong with the rig; "" for nothing. FacingChanged() returns true
  // once after each change of the facing warning.
  std::string Warning() const;
  bool FacingChanged() noexcept;

  // Call once a second.
  void Sample(std::int64_t now_ns);
  void Describe(v1::PerformerStats& stats) const;

  Profile& profile;
  const int source;
  const std::string name;
  const std::int64_t added_ns;  // when the performer appeared
  decide::Admission admission;
  Outputs outputs;
  Latency latency;
  log::FrameHistory history;                   // fates of the last frames
  std::int64_t next_body_ns = 0;               // when the bodies are due again
  std::int64_t next_idle_ns = 0;               // while idles(): when the next frame is due
  int newest_in_batch = -1;                    // used by the pipeline within a batch
  std::optional<std::int64_t> timecode;        // TimecodeLabel of the last frame with a timecode
  std::shared_ptr<const std::string> refusal;  // of the last body (SourceFrame); null: none
  std::int64_t refused_ns = 0;                 // when that body came

 private:
  // Rebuilds everything that depends on the body in binding_.
  void UseBinding(const RuntimeConfig& config);
  const rig::JointNames& Names(const RuntimeConfig& config) const;
  STYLED_REALTIME void WatchFacing() noexcept;
  STYLED_REALTIME void RestFace(std::span<const std::byte> merged) noexcept;
  void UseMirror() noexcept;
  STYLED_REALTIME void MirrorInput(std::span<const std::byte> face) noexcept;
  STYLED_REALTIME void Serialize() noexcept;

  runtime::Counters& counters_;
  PerformerBinding binding_;
  std::optional<Styling> styling_;     // empty until a body is bound
  std::optional<CarriedProps> props_;  // as styling_
  decide::FrameInTransit frame_;       // the accepted one
  PoseSmoothing smoothing_;
  std::vector<FingerLayer*> finger_layers_;
  Fingers fingers_;
  std::optional<IdleLayer> idle_;  // as styling_
  // By how much the stylist's time is ahead of the session's: after a silence the rig's clock may
  // continue before the last frame that was sent meanwhile, and the stylist's must not go back.
  std::int64_t ahead_ns_ = 0;
  bool sent_idle_ = false;               // the last frame was one of AcceptSilent
  rig::MirrorMap mirror_;                // of the bound body
  bool mirrored_ = false;                // as the look was at the last ApplyLook
  std::vector<std::byte> face_;          // data published beside the pose
  std::vector<std::byte> resting_face_;  // of a frame of AcceptSilent
  bool relieved_ = false;
  std::uint64_t relieved_frames_ = 0;  // sent while relieved
  bool repeats_ = false;               // the serialized frame is a repetition
  Facing facing_;
  std::int64_t faced_ns_ = 0;  // source time of the last frame in facing_
  bool backwards_ = false, backwards_logged_ = false;
  bool calibrates_neutral_ = false;
  std::vector<std::string> unknown_styles_;  // as ApplyLook returned them last
};

}  // namespace styled::pipeline
