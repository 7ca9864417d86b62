#include "model/stylist/stylist.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "model/base/critically_damped.h"
#include "model/base/smooth.h"
#include "model/feet/feet.h"
#include "model/neutral/neutral.h"
#include "model/stylist/batch.h"
#include "model/stylist/change_filter.h"
#include "model/stylist/domain.h"
#include "model/stylist/grounding.h"
#include "model/stylist/guard.h"
#include "model/stylist/input_guard.h"
#include "model/stylist/knees.h"
#include "model/stylist/mixer.h"
#include "model/stylist/posture.h"
#include "model/stylist/predictor.h"
#include "model/stylist/stride.h"
#include "model/stylist/tuning.h"

namespace styled::stylist {
namespace {

using body::kJointCount;
using body::Pose;
using body::Vec3;

// Publishes the performer's own motion, bit for bit, at the offset that strides have reached.
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

void PrefetchObject(std::span<const std::byte> bytes) noexcept {
  constexpr std::size_t kLine = 64;
  for (std::size_t at = 0; at < bytes.size(); at += kLine) __builtin_prefetch(&bytes[at]);
}

}  // namespace

struct Stylist::Impl {
  Impl(std::shared_ptr<const net::Stylizer> network, std::shared_ptr<const rig::Binding> the_rig,
       const Options& the_options)
      : binding(std::move(the_rig)),
        options(the_options),
        input_guard(binding->skeleton()),
        predictor(std::move(network)),
        feet(feet::HumanoidBinding(), feet::HumanoidBinding(), options.feet_options),
        rig_feet(*binding, *binding, options.feet_options) {
    for (std::size_t joint = 0; joint < kJointCount; ++joint) {
      offsets_in[joint] = offsets_out[joint] = body::Offset(static_cast<int>(joint));
    }
  }

  // The six steps except the second, which is StepTogether.
  void Bind(std::int64_t time_ns, const rig::RigPose& in, Output& out) noexcept;
  void RemoveNeutral(const Pose& input) noexcept;
  void ChangeStyle(const Pose& input) noexcept;
  float Shown(body::Part part) const noexcept;
  void Apply(Output& out) const noexcept;
  void Unbind(Output& out) noexcept;
  void HoldFeet(Output& out) noexcept;

  bool HasSoundSteps() noexcept;
  void GuardOutput(Output& out) noexcept;
  void Finish(Output& out) noexcept;

  void Restart() noexcept;
  void RestartAfterGap() noexcept;
  void CheckTiming(std::int64_t time_ns, Output& out) noexcept;
  void UpdateTravel(Output& out) noexcept;
  void FallBackToInput(Output& out) noexcept;
  bool Bypassed() const noexcept;
  // Null if the performer's neutral is not removed.
  const neutral::Reference* Reference() const noexcept {
    const auto& reference = predictor.network()->model().reference;
    return options.neutral && reference ? &*reference : nullptr;
  }
  BatchEntry EntryOf() noexcept { return {&predictor, &seen, &mixer, &filter.near()}; }

  std::shared_ptr<const rig::Binding> binding;
  Options options;
  Settings settings;

  InputGuard input_guard;
  neutral::Neutral neutral;
  Pose seen;  // the input as the network sees it: with the reference's carriage
  Mixer mixer;
  Predictor predictor;
  ChangeFilter filter;
  Domain domain;
  LimbGate gate;
  PostureKeeper posture;
  Stride stride;
  // Vertical shifts: of the canonical humanoid, and of the source skeleton in its units.
  CriticallyDamped shift_m, rig_shift;
  feet::Feet feet, rig_feet;
  CriticallyDamped feet_style;  // the style's weight, delayed like the style itself
  std::array<Vec3, kJointCount> offsets_in, offsets_out;  // the humanoid's offsets as translations

  std::int64_t last_ns = 0;
  double dt_s = 0;        // time between the frame before and this one
  double last_gap_s = 0;  // dt_s of the frame before if it exceeded gap_reset_s, else 0
  bool started = false, fresh_session = true;
  bool rests = false;   // see Stylist::Rest
  bool failed = false;  // a prediction or an output was not sound, and no step has been since
};

Stylist::Stylist(std::shared_ptr<const net::Stylizer> network,
                 std::shared_ptr<const rig::Binding> binding, const Options& options)
    : impl_(std::make_unique<Impl>(std::move(network), std::move(binding), options)) {}
Stylist::~Stylist() = default;
Stylist::Stylist(Stylist&&) noexcept = default;
Stylist& Stylist::operator=(Stylist&&) noexcept = default;

void Stylist::Set(const Settings& settings) noexcept {
  impl_->settings = settings;
  impl_->mixer.Aim(settings);
  if (settings.transition_s <= 0) impl_->filter.EndSwitch();  // a cut also ends an earlier switch
}

void Stylist::Adopt(std::shared_ptr<const net::Stylizer> network) noexcept {
  impl_->predictor.Adopt(std::move(network));
}

void Stylist::Rest(bool rests) noexcept { impl_->rests = rests; }

const Settings& Stylist::settings() const { return impl_->settings; }
bool Stylist::Names(int style) const noexcept { return impl_->mixer.Names(style); }

bool Stylist::has_neutral() const { return impl_->Reference() != nullptr; }

const neutral::Neutral& Stylist::neutral() const { return impl_->neutral; }

neutral::Known Stylist::Tell() const noexcept {
  const neutral::Reference* const reference = impl_->Reference();
  return reference == nullptr ? neutral::Known() : impl_->neutral.Tell(*reference);
}

void Stylist::Know(const neutral::Known& known) noexcept {
  const neutral::Reference* const reference = impl_->Reference();
  if (reference != nullptr) impl_->neutral.Know(known, *reference);
}

void Stylist::CalibrateNeutral(float seconds) noexcept { impl_->neutral.Calibrate(seconds); }

void Stylist::ForgetNeutral() noexcept { impl_->neutral.Forget(); }

void Stylist::Reset() noexcept {
  impl_->Restart();
  impl_->input_guard.Reset();
  impl_->predictor.ForgetInput();
  impl_->stride.Reset();
  impl_->feet.Reset();
  impl_->rig_feet.Reset();
  impl_->started = false;  // the next frame's time may be anything
  impl_->fresh_session = true;
}

void Stylist::Carry(Checkpoint& c) noexcept {
  Impl& s = *impl_;
  const auto styles = static_cast<int>(s.predictor.network()->model().styles.size());
  s.settings.Carry(c, styles);
  s.mixer.Carry(c, styles);
  c(s.input_guard, s.neutral, s.predictor, s.filter, s.domain, s.gate, s.posture, s.stride,
    s.shift_m, s.rig_shift, s.feet, s.rig_feet, s.feet_style);
  c.Time(s.last_ns);
  c(s.dt_s, s.last_gap_s, s.started, s.fresh_session, s.failed);
}

// Processes several performers' frames at once, so that step 2 runs for all of them together.
template <std::size_t kMost>
void Stylist::ProcessSome(std::span<const Job> jobs) noexcept {
  std::array<BatchEntry, kMost> entries;
  for (std::size_t i = 0; i < jobs.size(); ++i) {
    Impl& s = *jobs[i].stylist->impl_;
    // 1 Bind: the source pose, with invalid joints held, as a pose of the canonical humanoid.
    s.Bind(jobs[i].time_ns, *jobs[i].in, *jobs[i].out);
    entries[i] = s.EntryOf();
  }
  // 2 Network: each due recurrent state predicts the pose reconstructed and styled.
  StepTogether<kMost>(std::span(entries).first(jobs.size()));
  for (const Job& job : jobs) {
    Impl& s = *job.stylist->impl_;
    if (s.HasSoundSteps()) {
      // 3 Style change: the rotations from the reconstructed to the styled pose, filtered over
      // time.
      s.ChangeStyle(job.out->canonical_input);
      // 4 Apply: the style change on the performer's own motion.
      s.Apply(*job.out);
      // 5 Unbind: onto the source skeleton, with the lowest foot as high as the performer's.
      s.Unbind(*job.out);
      // 6 Feet: on both skeletons, feet that the performer plants stay planted.
      s.HoldFeet(*job.out);
    }
    s.GuardOutput(*job.out);
    s.Finish(*job.out);
  }
}

void Stylist::Process(std::int64_t time_ns, const rig::RigPose& in, Output& out) noexcept {
  const Job job{this, time_ns, &in, &out};
  ProcessSome<1>({&job, 1});
}

void Stylist::ProcessTogether(std::span<const Job> jobs) noexcept {
  if (jobs.size() == 1) return ProcessSome<1>(jobs);
  while (!jobs.empty()) {
    const std::size_t count = std::min(jobs.size(), kTogether);
    ProcessSome<kTogether>(jobs.first(count));
    jobs = jobs.subspan(count);
  }
}

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

// A performer's motion in another style tells nothing about their neutral.
void Stylist::Impl::RemoveNeutral(const Pose& input) noexcept {
  const neutral::Reference* const reference = Reference();
  if (reference == nullptr) {
    seen = input;
    return;
  }
  neutral.Follow(input, static_cast<float>(dt_s), mixer.input_style() == 0, *reference);
  neutral.RemoveCarriage(input, seen);
}

// The path over the floor is scaled as far as the style is shown, and only if legs show it.
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
  // sender whose clock steps by minutes would have every tick between run in one frame.
  const double usual_s = predictor.frame_period_s();
  if (started && dt_s > options.gap_reset_s) {
    // A slow rig's frames are all that far apart: only a hole longer than the last one conceals
    // frames.
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

// False if the network's prediction was not sound, in this frame or in the last frame that had a
// step.
bool Stylist::Impl::HasSoundSteps() noexcept {
  failed = predictor.unsound() || (failed && !predictor.any());
  return !failed;
}

// The share of its style that a part of the body shows.
float Stylist::Impl::Shown(body::Part part) const noexcept {
  return mixer.share(part) * gate.weight(LimbOf(part));
}

// Order: low-pass, absolute output, parts and limbs, in-domain weight. The last three have fades of
// their own, so they come after the low-pass.
void Stylist::Impl::ChangeStyle(const Pose& input) noexcept {
  const float error_rad = predictor.reconstruction_rad();
  domain.Follow(error_rad, input.rotations[body::kHips], static_cast<float>(dt_s), !started,
                options);
  StyleDelta delta;
  predictor.MeanDelta(delta);
  filter.Follow(delta, dt_s, error_rad, mixer, options);
  delta = filter.value();
  if (mixer.absolute() > 0 && predictor.any()) predictor.BlendAbsolute(seen, mixer, delta);
  if (options.limb_gate) {
    gate.Follow(predictor.limb_errors_m(), static_cast<float>(dt_s), !started,
                predictor.network()->model().gate);
  }
  if (!mixer.whole() || gate.reduces()) {
    for (int joint = 0; joint < kJointCount; ++joint) {
      delta.col(joint) *= Shown(body::PartOf(joint));
    }
    delta.col(kRise) *=  // the legs carry it
        std::min(Shown(body::Part::kLeftLeg), Shown(body::Part::kRightLeg));
  }
  if (domain.reduces()) delta *= domain.weight();
  filter.Apply(delta, dt_s, options);
  posture.Follow(predictor.network()->model().styles, mixer, filter.applied(), input,
                 options.posture, static_cast<float>(dt_s));
}

void Stylist::Impl::Apply(Output& out) const noexcept {
  const Pose& input = out.canonical_input;
  Pose& styled = out.canonical;
  styled.hips_position_m = input.hips_position_m + out.travel.moved_m + filter.applied().col(kRise);
  for (std::size_t joint = 0; joint < kJointCount; ++joint) {
    const Vec3 turn = filter.applied().col(static_cast<Eigen::Index>(joint));
    styled.rotations[joint] = (input.rotations[joint] * body::Exp(turn)).normalized();
  }
  if (options.knees) KeepKnees(input, 1 - mixer.absolute(), styled);
  posture.Apply(styled);
}

// Nothing is styled, and the last style has faded completely.
bool Stylist::Impl::Bypassed() const noexcept {
  return mixer.empty() && stride.factor() == 1 && filter.applied().isZero(0.0F) && posture.none() &&
         feet_style.value() < tuning::kNoStyle && std::abs(shift_m.value()) < tuning::kSettled_m &&
         std::abs(rig_shift.value()) * binding->scale() < tuning::kSettled_m;
}

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
// style moves them: one of the torso or of a leg. The weight is not scaled by the gate: a limb that
// fades to its own motion takes its offset along, and releasing the foot as well made kicks jerk.
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
  if (!failed) {
    failed = !IsSound(out.canonical, out.canonical_input, out.travel.moved_m) ||
             !IsSound(*binding, out.rig, out.source, out.travel.moved_m);
    if (failed) {  // their state may be the cause
      feet.Reset();
      rig_feet.Reset();
    }
  }
  if (failed) FallBackToInput(out);
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
  out.turned_rad = failed ? 0
                          : (filter.applied().leftCols<kJointCount>().colwise().norm().sum() +
                             posture.turned_rad()) /
                                static_cast<float>(kJointCount);
  out.limb_errors_m = predictor.limb_errors_m();
  out.limb_weights = gate.weights();
  out.steps = predictor.steps();
  if (out.held.any()) out.flags |= kHeld;
  if (mixer.fading()) out.flags |= kFading;
  if (domain.outside()) out.flags |= kOutOfDomain;
  if (fresh_session) out.flags |= kNewSession;
  const auto in_force = failed ? std::span<const net::StyleWeight>() : mixer.in_force();
  std::copy(in_force.begin(), in_force.end(), out.in_force.begin());
  out.in_force_count = static_cast<int>(in_force.size());

  predictor.End(seen);
  started = true;
  fresh_session = false;
}

struct Rehearsal::Scratch {
  Stylist stylist;
  Output out;
  std::int64_t time_ns = 0;
};

Rehearsal::Rehearsal(std::shared_ptr<const net::Stylizer> network,
                     const std::shared_ptr<const rig::Binding>& binding, const Options& options)
    : scratch_(new Scratch{Stylist(std::move(network), binding, options),
                           Output(binding->skeleton())}) {}
Rehearsal::~Rehearsal() = default;
Rehearsal::Rehearsal(Rehearsal&&) noexcept = default;
Rehearsal& Rehearsal::operator=(Rehearsal&&) noexcept = default;

void Rehearsal::Adopt(std::shared_ptr<const net::Stylizer> network) noexcept {
  scratch_->stylist.Adopt(std::move(network));
}

std::shared_ptr<Rehearsal> Rehearsal::Shared(const std::shared_ptr<const net::Stylizer>& network,
                                             const std::shared_ptr<const rig::Binding>& binding,
                                             const Options& options) {
  thread_local std::vector<std::weak_ptr<Rehearsal>> rehearsals;
  std::erase_if(rehearsals, [](const auto& kept) { return kept.expired(); });
  const auto fits = [&](const Rehearsal& kept) {
    const Stylist::Impl& s = *kept.scratch_->stylist.impl_;
    return s.predictor.network() == network.get() &&
           s.binding->skeleton().joint_count() == binding->skeleton().joint_count();
  };
  for (const auto& kept : rehearsals) {
    if (auto shared = kept.lock(); fits(*shared)) return shared;
  }
  auto made = std::make_shared<Rehearsal>(network, binding, options);
  rehearsals.push_back(made);
  return made;
}

// Runs the last pose through the scratch stylist, at the usual frame interval.
void Rehearsal::Prewarm(const Stylist& stylist) noexcept {
  const Stylist::Impl& s = *stylist.impl_;
  PrefetchObject(std::as_bytes(std::span(&s, 1)));
  s.predictor.Prefetch();
  Scratch& r = *scratch_;
  constexpr std::int64_t kUsual_ns = 1'000'000'000 / 120;
  const bool usual = s.dt_s > 0 && s.dt_s <= s.options.gap_reset_s;
  r.time_ns += usual ? static_cast<std::int64_t>(s.dt_s * 1e9) : kUsual_ns;
  r.stylist.impl_->mixer = s.mixer;
  r.stylist.Process(r.time_ns, s.input_guard.clean(), r.out);
}

}  // namespace styled::stylist
