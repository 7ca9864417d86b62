// Steps 5 and 6 of the stylist, the check of what they made, and what of the frame is reported.
#include <algorithm>
#include <span>

#include "model/base/smooth.h"
#include "model/stylist/grounding.h"
#include "model/stylist/guard.h"
#include "model/stylist/stylist_impl.h"
#include "model/stylist/tuning.h"

namespace styled::stylist {
namespace {

// Publishes the performer's own motion, bit for bit, in the place that strides have reached.
void PassThrough(const rig::Binding& binding, Output& out) noexcept {
  out.canonical = out.canonical_input;
  std::copy(out.source.translations.begin(), out.source.translations.end(),
            out.rig.translations.begin());
  std::copy(out.source.rotations.begin(), out.source.rotations.end(), out.rig.rotations.begin());
  out.flags |= kBypass;
  if (out.travel.moved_m.isZero(0.0F)) return;
  out.canonical.hips_position_m += out.travel.moved_m;
  Shift(binding, out.travel.moved_m, out.rig);
}

}  // namespace

void Stylist::Impl::Unbind(Output& out) noexcept {
  if (options.bypass && Bypassed()) {
    PassThrough(*binding, out);
    shift_m.Reset();
    rig_shift.Reset();
    return;
  }
  binding->Unbind(out.canonical, input_guard.clean(), out.rig);
  if (!options.ground) return;
  const auto dt = static_cast<float>(dt_s);
  out.canonical.hips_position_m.y() +=
      shift_m.Follow(GroundShift_m(out.canonical_input, out.canonical), dt, options.ground_tau_s);
  const float up = GroundShift(*binding, input_guard.clean(), out.rig);
  ShiftUp(*binding, rig_shift.Follow(up, dt, options.ground_tau_s), out.rig);
}

// With a weight of 0, the feet stages only track the performer's contacts. Feet are held only if a
// style moves them: one of the torso or of a leg. Not scaled by the gate: a limb that fades to its
// own motion takes its offset along, and to let go of the foot as well made kicks jerk.
void Stylist::Impl::HoldFeet(Output& out) noexcept {
  const auto dt = static_cast<float>(dt_s);
  float style = 0;
  for (const net::StyleWeight& active : mixer.in_force()) style += active.weight;
  if (mixer.input_style() > 0) style = std::max(style, mixer.presence());
  style = feet_style.Follow(style, dt, filter.delay_s() / 2);
  style *= std::max({mixer.share(body::Part::kTorso), mixer.share(body::Part::kLeftLeg),
                     mixer.share(body::Part::kRightLeg)});
  const bool held = options.feet && (out.flags & kBypass) == 0;
  const float weight = held ? SmoothStep(domain.weight() * style / tuning::kFeetFull) : 0.0F;
  rig_feet.Process(dt, weight, {input_guard.clean().translations, input_guard.clean().rotations},
                   {out.rig.translations, out.rig.rotations}, out.travel);
  out.contacts = rig_feet.contacts().bits();
  offsets_in[body::kHips] = out.canonical_input.hips_position_m;
  offsets_out[body::kHips] = out.canonical.hips_position_m;
  feet.Process(dt, weight, {offsets_in, out.canonical_input.rotations},
               {offsets_out, out.canonical.rotations}, out.travel);
  out.canonical.hips_position_m = offsets_out[body::kHips];
}

// If the styled frame is not sound, the performer's own is published instead.
void Stylist::Impl::GuardOutput(Output& out) noexcept {
  if (!failed()) {
    if (!IsSound(out.canonical, out.canonical_input, out.travel.moved_m)) {
      failure = Failure::kCanonical;
    } else if (!IsSound(*binding, out.rig, out.source, out.travel.moved_m)) {
      failure = Failure::kRig;
    }
    if (failed()) {  // their state may be the cause
      feet.Reset();
      rig_feet.Reset();
    }
  }
  out.failure = failure;
  if (failed()) FallBackToInput(out);
}

// Clears the whole state of the styling, because NaN in it would stay for good; the style is then
// faded in.
void Stylist::Impl::FallBackToInput(Output& out) noexcept {
  predictor.RestartStates();
  filter.Clear();
  domain.Reset();
  gate.Reset();
  posture.Reset();
  shift_m.Reset();
  rig_shift.Reset();
  feet_style.Reset();
  PassThrough(*binding, out);
  out.flags |= kFailed;
  HoldFeet(out);
}

void Stylist::Impl::Finish(Output& out) noexcept {
  out.reconstruction_rad = predictor.reconstruction_rad();
  out.turned_rad = failed() ? 0
                          : (filter.applied().leftCols<body::kJointCount>().colwise().norm().sum() +
                             posture.turned_rad()) /
                                static_cast<float>(body::kJointCount);
  out.limb_errors_m = predictor.limb_errors_m();
  out.limb_weights = gate.weights();
  out.steps = predictor.steps();
  if (out.held.any()) out.flags |= kHeld;
  if (mixer.fading()) out.flags |= kFading;
  if (domain.outside()) out.flags |= kOutOfDomain;
  if (fresh_session) out.flags |= kNewSession;
  const auto in_force = failed() ? std::span<const net::StyleWeight>() : mixer.in_force();
  std::copy(in_force.begin(), in_force.end(), out.in_force.begin());
  out.in_force_count = static_cast<int>(in_force.size());

  predictor.End(seen);
  started = true;
  fresh_session = false;
}

}  // namespace styled::stylist
