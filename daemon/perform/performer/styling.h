#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "daemon/looks/runtime_config.h"
#include "daemon/perform/performer/body_binding.h"
#include "daemon/perform/performer/facing.h"
#include "daemon/runtime/counters.h"
#include "model/base/checkpoint.h"
#include "model/base/realtime.h"
#include "model/stylist/stylist.h"
#include "model/stylist/visible.h"
#include "proto/styled/look.h"
#include "proto/styled/v1/stats.pb.h"

namespace styled::pipeline {

struct Profile;

// The stylist of a performer on one body, its input and its last output. Replaced when the body
// changes. Pipeline thread; construction, Rebuild and ApplyLook allocate.
class Styling {
 public:
  // `counters` must outlive it.
  Styling(const BoundBody& body, const RuntimeConfig& config, runtime::Counters& counters);

  // Applies the look of a profile from the next frame on, as far as the network has its styles.
  // Returns the names of those that it lacks.
  std::vector<std::string> ApplyLook(const Profile& profile, const RuntimeConfig& config);
  // Fades the style out, whatever the look, and then skips the network; or fades it in again.
  STYLED_REALTIME void Relieve(bool relieved) noexcept;
  // After new weights or options: makes a new stylist, without look and output.
  void Rebuild(const BoundBody& body, const RuntimeConfig& config);
  // Continues with a network that shares streams with the last one.
  void Adopt(const RuntimeConfig& config);
  // Resets the recurrent state; the next frame's source time may be anything.
  STYLED_REALTIME void Restart() noexcept { stylist_.Reset(); }

  // The next frames are those of the same performer, left and right exchanged (Stylist::Mirror).
  STYLED_REALTIME void Mirror() noexcept { stylist_.Mirror(); }

  // See model/base/checkpoint.h; the last output is not in it.
  STYLED_REALTIME void Carry(Checkpoint& c) noexcept { stylist_.Carry(c); }

  // Swaps in the next pose, and mirrors it if the binding is that of the mirrored skeleton.
  STYLED_REALTIME void SetInput(rig::RigPose& received) noexcept;
  // The job for that pose, for Stylist::ProcessTogether. `elapsed_ns` is the session's.
  STYLED_REALTIME stylist::Stylist::Job MakeJob(std::int64_t elapsed_ns) noexcept {
    return {&stylist_, elapsed_ns, &in_, &out_};
  }
  // Call after the job: transforms the poses into the rig's axes, and counts steps and flags,
  // including `extra_flags`.
  STYLED_REALTIME void Finish(std::uint32_t extra_flags) noexcept;
  // Brings the next frame's data into the caches. Changes nothing.
  STYLED_REALTIME void Prewarm() noexcept { rehearsal_->Prewarm(stylist_); }

  // Ends a second: Describe reports it.
  void Sample() noexcept;
  // Fills `neutral`, and the statistics of the style unless no pose of that second was styled.
  void Describe(v1::PerformerStats& stats) const;

  stylist::Stylist& stylist() { return stylist_; }
  const stylist::Stylist& stylist() const { return stylist_; }
  const rig::RigPose& in() const { return in_; }
  rig::RigPose& in() { return in_; }  // in the binding's axes, until the job runs
  const stylist::Output& out() const { return out_; }
  bool has_output() const { return has_output_; }
  const rig::Vec3& rig_root() const { return rig_root_; }  // of out().rig, in the rig's units

 private:
  // Sums over poses, by limb, and their numbers.
  struct Shown {
    stylist::PerLimb sum{};
    float turned_rad = 0;
    int poses = 0;
    stylist::Moved moved_m{};
    int measured = 0;  // number of poses in moved_m
  };
  void CountFlags(std::uint32_t flags) noexcept;

  std::shared_ptr<const rig::Binding> binding_;
  bool left_handed_;
  runtime::Counters& counters_;
  stylist::Settings settings_;  // of the look
  bool relieved_ = false;
  stylist::Stylist stylist_;
  std::shared_ptr<stylist::Rehearsal> rehearsal_;  // of the stylist, run before a frame is due
  rig::RigPose in_;
  stylist::Output out_;
  bool has_output_ = false;
  Shown shown_, shown_last_;  // in this second so far, and in the one before
  rig::Vec3 rig_root_ = rig::Vec3::Zero();
};

}  // namespace styled::pipeline
