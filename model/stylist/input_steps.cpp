// Step 1 of the stylist: a frame's time, its pose on the canonical humanoid, the path over the
// floor, and the pose that the network sees.
#include <algorithm>

#include "model/stylist/stylist_impl.h"
#include "model/stylist/tuning.h"

namespace styled::stylist {

void Stylist::Impl::Bind(std::int64_t time_ns, const rig::RigPose& in, Output& out) noexcept {
  dt_s = started ? static_cast<double>(time_ns - last_ns) * 1e-9 : 0.0;
  last_ns = time_ns;
  out.flags = 0;
  input_guard.HoldBadJoints(in, out.source, out.held);
  CheckTiming(time_ns, out);
  binding->Bind(input_guard.clean(), out.canonical_input);
  mixer.Advance(dt_s);
  if (rests && Bypassed()) predictor.Skip();
  UpdateTravel(out);
  RemoveNeutral(out.canonical_input);
}

// Handles jumps, gaps and changes of rate; sets kConcealed.
void Stylist::Impl::CheckTiming(std::int64_t time_ns, Output& out) noexcept {
  const InputGuard::Jump jump = input_guard.JudgeJump(dt_s, binding->scale(), options, out.source);
  if (jump == InputGuard::Jump::kHeld) {
    out.held.set(0);
  } else if (jump == InputGuard::Jump::kAccepted) {
    Restart();
    stride.Reset();
    feet.Reset();
    rig_feet.Reset();
    fresh_session = true;
  }
  // A hole longer than gap_reset_s is never bridged, even if every hole is as long: otherwise a
  // sender whose clock steps by minutes would make one frame run every tick in between.
  const double usual_s = predictor.frame_period_s();
  if (started && dt_s > options.gap_reset_s) {
    // The frames of a slow rig are all that far apart: only a hole longer than the last one means
    // lost frames.
    if (last_gap_s == 0 || dt_s > tuning::kGapFactor * last_gap_s) out.flags |= kConcealed;
    last_gap_s = dt_s;
    RestartAfterGap();
  } else if (started) {
    last_gap_s = 0;
    if (usual_s > 0 && dt_s > tuning::kGapFactor * usual_s) out.flags |= kConcealed;
  }
  if (!predictor.Begin(time_ns)) {
    RestartAfterGap();
    (void)predictor.Begin(time_ns);
  }
}

// Restarts the recurrent states and the filter; cross-fades from the style delta applied so far.
void Stylist::Impl::Restart() noexcept {
  predictor.Restart();
  filter.Restart(started);
}

void Stylist::Impl::RestartAfterGap() noexcept {
  predictor.Restart();
  filter.RestartAfterGap(started, dt_s, options);
}

// The path over the floor is scaled in the share in which the style is shown, and only if legs are
// styled.
void Stylist::Impl::UpdateTravel(Output& out) noexcept {
  const float shown =
      domain.weight() * std::min(Shown(body::Part::kLeftLeg), Shown(body::Part::kRightLeg));
  const net::Styles& styles = predictor.network()->model().styles;
  stride.Follow(out.canonical_input.hips_position_m, dt_s, options.gap_reset_s,
                filter.delay_s() / 2, [&](float speed_mps) {
                  return shown * ChangeOfGait(styles, mixer, options.own_cadence, speed_mps);
                });
  out.travel = stride.travel();
  out.cadence = stride.cadence();
}

// Motion in another style contains nothing of the neutral of a performer.
void Stylist::Impl::RemoveNeutral(const body::Pose& input) noexcept {
  const neutral::Reference* const reference = Reference();
  const bool learns = reference != nullptr && measured && mixer.input_style() == 0;
  const neutral::Reference* const followed = reference != nullptr ? reference : Gaits();
  if (followed != nullptr) neutral.Follow(input, static_cast<float>(dt_s), learns, *followed);
  if (reference == nullptr) {
    seen = input;
    return;
  }
  neutral.RemoveCarriage(input, seen);
}

}  // namespace styled::stylist
