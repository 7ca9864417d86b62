#include "model/stylist/stylist.h"

#include <algorithm>
#include <cmath>

#include "model/base/critically_damped.h"
#include "model/base/smooth.h"
#include "model/body/heading.h"
#include "model/feet/feet.h"
#include "model/stylist/change_filter.h"
#include "model/stylist/domain.h"
#include "model/stylist/grounding.h"
#include "model/stylist/guard.h"
#include "model/stylist/input_guard.h"
#include "model/stylist/interleaver.h"
#include "model/stylist/knees.h"
#include "model/stylist/mixer.h"
#include "model/stylist/tuning.h"

namespace styled::stylist {
namespace {

using body::kJointCount;
using body::Pose;
using body::Quat;
using body::Vec3;

// The performer's own motion, bit for bit.
void PassThrough(Output& out) noexcept {
  out.canonical = out.canonical_input;
  std::copy(out.source.translations.begin(), out.source.translations.end(),
            out.rig.translations.begin());
  std::copy(out.source.rotations.begin(), out.source.rotations.end(), out.rig.rotations.begin());
  out.flags |= kBypass;
}

void Prefetch(std::span<const std::byte> bytes) noexcept {
  constexpr std::size_t kLine = 64;
  for (std::size_t at = 0; at < bytes.size(); at += kLine) __builtin_prefetch(&bytes[at]);
}

}  // namespace

struct Stylist::Impl {
  Impl(std::shared_ptr<const net::Stylizer> the_network,
       std::shared_ptr<const rig::Binding> the_rig, const Options& the_options)
      : network(std::move(the_network)),
        binding(std::move(the_rig)),
        options(the_options),
        input_guard(binding->skeleton()),
        feet(feet::HumanoidBinding(), feet::HumanoidBinding(), options.feet_options),
        rig_feet(*binding, *binding, options.feet_options) {
    for (auto& stream : streams) stream = network->MakeStream();
    for (std::size_t joint = 0; joint < kJointCount; ++joint) {
      offsets_in[joint] = offsets_out[joint] = body::Offset(static_cast<int>(joint));
    }
  }

  void Restart() noexcept;
  void RestartAfterGap() noexcept;
  void Forget() noexcept;
  void JudgeFrame(std::int64_t time_ns, Output& out) noexcept;
  struct Step;
  void Begin(std::int64_t time_ns, const rig::RigPose& in, Output& out) noexcept;
  bool NextStep(const Pose& input, Step& step) noexcept;
  net::StepJob JobOf(Step& step) const noexcept;
  void Finish(Output& out) noexcept;
  void Style(Output& out) noexcept;
  void GiveBack(Output& out) noexcept;
  void TakeChange(int state, const Pose& input, const net::Prediction& step) noexcept;
  void ChangeStyle(const Pose& input) noexcept;
  StyleDelta MeanDelta() const noexcept;
  void BlendAbsolute(const Pose& input, StyleDelta& delta) const noexcept;
  void Apply(const Pose& input, Pose& styled) const noexcept;
  void Ground(Output& out) noexcept;
  void HoldFeet(Output& out) noexcept;
  bool Bypassed() const noexcept;
  bool IsSoundOutput(const Output& out) const noexcept;

  std::shared_ptr<const net::Stylizer> network;
  std::shared_ptr<const rig::Binding> binding;
  Options options;
  Settings settings;

  InputGuard input_guard;
  Mixer mixer;
  Interleaver interleaver;
  std::array<std::unique_ptr<net::Stream>, tuning::kMaxInterleaved> streams;
  std::array<StyleDelta, tuning::kMaxInterleaved> wanted;  // each state's latest change
  std::bitset<tuning::kMaxInterleaved> stepped;
  net::Prediction last;  // of the newest tick, for the absolute output
  int steps = 0;         // of the network, for the frame at hand

  ChangeFilter filter;
  Domain domain;

  Pose last_input;
  std::int64_t last_ns = 0;
  double dt_s = 0;        // of the frame at hand, since the one before
  double last_gap_s = 0;  // the same of the one before, where it was beyond gap_reset_s
  bool started = false, fresh_session = true;
  bool bad_step = false;  // of this frame: what the network decoded is no pose
  bool failed = false;    // so it was, or what a stage made of it; no step has been sound since
  float reconstruction_rad = 0;
  CriticallyDamped shift_m,
      rig_shift;                // of the canonical humanoid and of the source skeleton, its units
  feet::Feet feet, rig_feet;    // the same two
  CriticallyDamped feet_style;  // the weight of style, as late as what the style does
  std::array<Vec3, kJointCount> offsets_in, offsets_out;  // the humanoid's as translations
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
  if (settings.transition_s <= 0) impl_->filter.EndSwitch();  // a cut, whatever was being faded
}

const Settings& Stylist::settings() const { return impl_->settings; }

void Stylist::Reset() noexcept {
  impl_->Restart();
  impl_->input_guard.Reset();
  impl_->feet.Reset();
  impl_->rig_feet.Reset();
  impl_->started = false;  // the next frame's time may be anything
  impl_->fresh_session = true;
}

// One step of one recurrent state, on the way to the network and back.
struct Stylist::Impl::Step {
  int state;
  const Pose* pose;
  Pose between;
  net::Prediction out;
};

struct Rehearsal::Scratch {
  Stylist::Impl impl;
  Output out;
  std::int64_t time_ns = 0;
};

Rehearsal::Rehearsal(std::shared_ptr<const net::Stylizer> network,
                     std::shared_ptr<const rig::Binding> binding, const Options& options)
    : scratch_(new Scratch{{std::move(network), binding, options}, Output(binding->skeleton())}) {}
Rehearsal::~Rehearsal() = default;
Rehearsal::Rehearsal(Rehearsal&&) noexcept = default;
Rehearsal& Rehearsal::operator=(Rehearsal&&) noexcept = default;

void Rehearsal::Prewarm(const Stylist& stylist) noexcept {
  const Stylist::Impl& s = *stylist.impl_;
  Prefetch(std::as_bytes(std::span(&s, 1)));
  const auto used = static_cast<std::size_t>(std::max(1, s.interleaver.interleaved()));
  for (std::size_t i = 0; i < used; ++i) Prefetch(s.streams[i]->memory());
  Scratch& r = *scratch_;
  constexpr std::int64_t kUsual_ns = 1'000'000'000 / 120;
  const bool usual = s.dt_s > 0 && s.dt_s <= s.options.gap_reset_s;
  r.time_ns += usual ? static_cast<std::int64_t>(s.dt_s * 1e9) : kUsual_ns;
  r.impl.mixer = s.mixer;
  r.impl.Begin(r.time_ns, s.input_guard.clean(), r.out);
  Stylist::Impl::Step step;
  while (r.impl.NextStep(r.out.canonical_input, step)) {
    const net::StepJob job = r.impl.JobOf(step);
    r.impl.network->Step({&job, 1});
    r.impl.TakeChange(step.state, *step.pose, step.out);
  }
  r.impl.Finish(r.out);
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

// Each state whose tick is due steps once per round; most frames are one tick, so one round.
template <std::size_t Most>
void Stylist::ProcessSome(std::span<const Job> jobs) noexcept {
  for (const Job& job : jobs) job.stylist->impl_->Begin(job.time_ns, *job.in, *job.out);
  std::array<Impl::Step, Most> steps;
  std::array<Impl*, Most> stepping;
  std::array<net::StepJob, Most> together;
  for (;;) {
    std::size_t count = 0;
    for (const Job& job : jobs) {
      Impl& s = *job.stylist->impl_;
      Impl::Step& step = steps[count];
      if (!s.NextStep(job.out->canonical_input, step)) continue;
      together[count] = s.JobOf(step);
      stepping[count++] = &s;
    }
    if (count == 0) break;
    // One network for all, but while another is being taken up.
    for (std::size_t from = 0, to = 0; from < count; from = to) {
      const net::Stylizer& network = *stepping[from]->network;
      while (to < count && stepping[to]->network.get() == &network) ++to;
      network.Step(std::span(together).subspan(from, to - from));
    }
    for (std::size_t i = 0; i < count; ++i) {
      stepping[i]->TakeChange(steps[i].state, *steps[i].pose, steps[i].out);
    }
  }
  for (const Job& job : jobs) job.stylist->impl_->Finish(*job.out);
}

// 1 bind: the source pose, bad joints held, as a pose of the canonical humanoid.
void Stylist::Impl::Begin(std::int64_t time_ns, const rig::RigPose& in, Output& out) noexcept {
  dt_s = started ? static_cast<double>(time_ns - last_ns) * 1e-9 : 0.0;
  last_ns = time_ns;
  out.flags = 0;
  steps = 0;
  bad_step = false;
  input_guard.HoldBadJoints(in, out.source, out.held);
  JudgeFrame(time_ns, out);
  binding->Bind(input_guard.clean(), out.canonical_input);
  mixer.Advance(dt_s);
}

// 2 the input of the next recurrent state whose tick is due. False when none is.
bool Stylist::Impl::NextStep(const Pose& input, Step& step) noexcept {
  Interleaver::Tick tick;
  if (!interleaver.Next(tick)) return false;
  ++steps;
  const bool exact = tick.share >= 1.0F || !started;  // started: there is a last input
  if (!exact) body::Interpolate(last_input, input, tick.share, step.between);
  step.pose = exact ? &input : &step.between;
  step.state = tick.state;
  return true;
}

// For 3 network.
net::StepJob Stylist::Impl::JobOf(Step& step) const noexcept {
  return {step.pose, mixer.input_style(), mixer.in_force(),
          streams[static_cast<std::size_t>(step.state)].get(), &step.out};
}

void Stylist::Impl::Finish(Output& out) noexcept {
  failed = bad_step || (failed && stepped.none());
  if (!failed) {
    Style(out);
    failed = !IsSoundOutput(out);
    if (failed) {  // the feet may remember why
      feet.Reset();
      rig_feet.Reset();
    }
  }
  if (failed) GiveBack(out);

  out.reconstruction_rad = reconstruction_rad;
  out.steps = steps;
  if (out.held.any()) out.flags |= kHeld;
  if (mixer.fading()) out.flags |= kFading;
  if (domain.outside()) out.flags |= kOutOfDomain;
  if (fresh_session) out.flags |= kNewSession;
  const auto in_force = failed ? std::span<const net::StyleWeight>() : mixer.in_force();
  std::copy(in_force.begin(), in_force.end(), out.in_force.begin());
  out.in_force_count = static_cast<int>(in_force.size());

  last_input = out.canonical_input;
  started = true;
  fresh_session = false;
}

void Stylist::Impl::Style(Output& out) noexcept {
  // 4 apply: the change of style, low-passed, on the performer's own motion.
  ChangeStyle(out.canonical_input);
  Apply(out.canonical_input, out.canonical);

  if (options.bypass && Bypassed()) {
    PassThrough(out);
    shift_m.Reset();
    rig_shift.Reset();
  } else {
    // 5 unbind: back onto the source skeleton.
    binding->Unbind(out.canonical, input_guard.clean(), out.rig);
    if (options.ground) Ground(out);
  }
  // 6 feet: on each output skeleton, what the performer plants stays planted.
  HoldFeet(out);
}

bool Stylist::Impl::IsSoundOutput(const Output& out) const noexcept {
  return IsSound(out.canonical, out.canonical_input) &&
         IsSound(out.rig, out.source, binding->scale());
}

// The frame leaves as the performer's own. Whatever the styling remembers starts anew, since what
// is not a number would stay in it for good; the style is then faded in.
void Stylist::Impl::GiveBack(Output& out) noexcept {
  Forget();
  filter.Clear();
  domain.Reset();
  shift_m.Reset();
  rig_shift.Reset();
  feet_style.Reset();
  PassThrough(out);
  out.flags |= kFailed;
  HoldFeet(out);
}

// Ticks, recurrent state and filter start anew; what is applied is faded over from.
void Stylist::Impl::Restart() noexcept {
  interleaver.Restart();
  Forget();
  filter.Restart(started);
}

void Stylist::Impl::RestartAfterGap() noexcept {
  interleaver.Restart();
  Forget();
  filter.RestartAfterGap(started, dt_s, options);
}

void Stylist::Impl::Forget() noexcept {
  for (const auto& stream : streams) network->Start(*stream);
  stepped.reset();
  reconstruction_rad = 0;
}

// Jumps, gaps and changes of rate.
void Stylist::Impl::JudgeFrame(std::int64_t time_ns, Output& out) noexcept {
  const InputGuard::Jump jump = input_guard.JudgeJump(dt_s, binding->scale(), options, out.source);
  if (jump == InputGuard::Jump::kHeld) {
    out.held.set(0);
  } else if (jump == InputGuard::Jump::kAccepted) {
    Restart();
    feet.Reset();
    rig_feet.Reset();
    fresh_session = true;
  }
  // What is longer than gap_reset_s is never bridged, however usual it is: a sender whose clock
  // steps by minutes would have every tick between run in one frame.
  const double usual_s = interleaver.frame_period_s();
  if (started && dt_s > options.gap_reset_s) {
    // A slow rig's frames are all that far apart: nothing is missing.
    if (last_gap_s == 0 || dt_s > tuning::kGapFactor * last_gap_s) out.flags |= kConcealed;
    last_gap_s = dt_s;
    RestartAfterGap();
  } else if (started) {
    last_gap_s = 0;
    if (usual_s > 0 && dt_s > tuning::kGapFactor * usual_s) out.flags |= kConcealed;
  }
  const float rate_hz = network->model().rate_hz;
  if (!interleaver.Begin(time_ns, rate_hz)) {
    RestartAfterGap();
    (void)interleaver.Begin(time_ns, rate_hz);
  }
}

// The change of style that one step asks for, and how well the network knows the pose.
void Stylist::Impl::TakeChange(int state, const Pose& input, const net::Prediction& step) noexcept {
  if (!IsSound(step)) {
    bad_step = true;
    return;
  }
  const Quat heading_from_world = body::Yaw(-step.heading_rad);
  StyleDelta& wish = wanted[static_cast<std::size_t>(state)];
  float error2 = 0;
  for (std::size_t joint = 0; joint < kJointCount; ++joint) {
    const Quat& rec = step.reconstruction.rotations[joint];
    Quat in = input.rotations[joint];
    if (joint == body::kHips) in = heading_from_world * in;
    wish.col(static_cast<Eigen::Index>(joint)) =
        body::LogNear(rec.conjugate() * step.styled.rotations[joint],
                      filter.near().col(static_cast<Eigen::Index>(joint)));
    // Toes say nothing of a posture, and some rigs' turn over.
    const bool toes = joint == body::kLeftToes || joint == body::kRightToes;
    if (!toes) error2 += body::Log(in.conjugate() * rec).squaredNorm();
  }
  // Of a neutral performer a style of weight 0 changes nothing; of another one it takes his away.
  // Before the low-pass, so that being told otherwise is no jump.
  if (mixer.input_style() > 0) wish *= mixer.presence();
  stepped.set(static_cast<std::size_t>(state));
  last = step;
  reconstruction_rad = std::sqrt(error2 / static_cast<float>(kJointCount - 2));
}

// What the interleaved states ask for. Their mean is a box filter over one period of the network,
// whose notch lies on the ripple that their disagreement makes.
StyleDelta Stylist::Impl::MeanDelta() const noexcept {
  StyleDelta mean = StyleDelta::Zero();
  int count = 0;
  for (std::size_t state = 0; state < wanted.size(); ++state) {
    if (!stepped.test(state)) continue;
    mean += wanted[state];
    ++count;
  }
  if (count > 0) mean /= static_cast<float>(count);
  return mean;
}

// The paper's output instead, as far as that is asked for: unfiltered, from the newest step alone.
void Stylist::Impl::BlendAbsolute(const Pose& input, StyleDelta& delta) const noexcept {
  const Quat world_from_heading = body::Yaw(last.heading_rad);
  for (std::size_t joint = 0; joint < kJointCount; ++joint) {
    Quat styled = last.styled.rotations[joint];
    if (joint == body::kHips) styled = world_from_heading * styled;
    const Vec3 whole = mixer.presence() * body::Log(input.rotations[joint].conjugate() * styled);
    auto column = delta.col(static_cast<Eigen::Index>(joint));
    column += mixer.absolute() * (whole - column);
  }
}

void Stylist::Impl::ChangeStyle(const Pose& input) noexcept {
  domain.Follow(reconstruction_rad, input.rotations[body::kHips], static_cast<float>(dt_s),
                !started, options);
  filter.Follow(MeanDelta(), dt_s, reconstruction_rad, mixer, options);
  StyleDelta delta = filter.value();
  if (mixer.absolute() > 0 && stepped.any()) BlendAbsolute(input, delta);
  if (!mixer.whole()) {
    for (int joint = 0; joint < kJointCount; ++joint) {
      delta.col(joint) *= mixer.share(body::PartOf(joint));
    }
  }
  if (domain.reduces()) delta *= domain.weight();
  filter.Apply(delta, dt_s, options);
}

void Stylist::Impl::Apply(const Pose& input, Pose& styled) const noexcept {
  styled.hips_position_m = input.hips_position_m;
  for (std::size_t joint = 0; joint < kJointCount; ++joint) {
    const Vec3 turn = filter.applied().col(static_cast<Eigen::Index>(joint));
    styled.rotations[joint] = (input.rotations[joint] * body::Exp(turn)).normalized();
  }
  if (options.knees) KeepKnees(input, 1 - mixer.absolute(), styled);
}

bool Stylist::Impl::Bypassed() const noexcept {
  return mixer.empty() && filter.applied().isZero(0.0F) && feet_style.value() < tuning::kNoStyle &&
         std::abs(shift_m.value()) < tuning::kSettled_m &&
         std::abs(rig_shift.value()) * binding->scale() < tuning::kSettled_m;
}

void Stylist::Impl::Ground(Output& out) noexcept {
  const auto dt = static_cast<float>(dt_s);
  out.canonical.hips_position_m.y() +=
      shift_m.Follow(GroundShift_m(out.canonical_input, out.canonical), dt, options.ground_tau_s);
  const float wanted = GroundShift(*binding, input_guard.clean(), out.rig);
  ShiftUp(*binding, rig_shift.Follow(wanted, dt, options.ground_tau_s), out.rig);
}

// With no style in force the stages only watch the performer's contacts. Nor are feet held that no
// style moves: a style of the torso or of a leg moves them.
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
                   {out.rig.translations, out.rig.rotations});
  out.contacts = rig_feet.contacts().bits();
  offsets_in[body::kHips] = out.canonical_input.hips_position_m;
  offsets_out[body::kHips] = out.canonical.hips_position_m;
  feet.Process(dt, weight, {offsets_in, out.canonical_input.rotations},
               {offsets_out, out.canonical.rotations});
  out.canonical.hips_position_m = offsets_out[body::kHips];
}

}  // namespace styled::stylist
