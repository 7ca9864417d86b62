// A performer's frame in its six steps (ProcessSome), the steps between binding and unbinding, and
// the queries of the state.
#include "model/stylist/stylist.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "model/stylist/knees.h"
#include "model/stylist/stylist_impl.h"
#include "model/stylist/tuning.h"

namespace styled::stylist {

// Processes several performers' frames at once, so that step 2 runs for all of them together.
template <std::size_t kMost>
void Stylist::ProcessSome(std::span<const Job> jobs) noexcept {
  std::array<BatchEntry, kMost> entries;
  for (std::size_t i = 0; i < jobs.size(); ++i) {
    Impl& s = *jobs[i].stylist->impl_;
    // 1 Bind: the source pose, with invalid joints held, as a pose of the canonical humanoid.
    s.Bind(jobs[i].time_ns, *jobs[i].in, *jobs[i].out);
    entries[i] = s.EntryOf(*jobs[i].out);
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

// Source time counts from any moment; a day of it is exact to a tenth of a nanosecond.
constexpr std::int64_t kDay_ns = 86'400'000'000'000;

BatchEntry Stylist::Impl::EntryOf(const Output& out) noexcept {
  BatchEntry entry{&predictor, &seen, &mixer, &filter.near(), {}};
  if (const neutral::Reference* const reference = Gaits(); reference != nullptr) {
    entry.performer = {&out.canonical_input, &neutral, reference,
                       filter.delay_s() + predictor.delay_s(),
                       static_cast<double>(last_ns % kDay_ns) * 1e-9};
  }
  return entry;
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

// False if the network's prediction was not sound, in this frame or in the last frame that had a
// step.
bool Stylist::Impl::HasSoundSteps() noexcept {
  if (predictor.unsound()) {
    failure = Failure::kPrediction;
  } else if (predictor.any()) {
    failure = Failure::kNone;
  }
  return !failed();
}

// Order: low-pass, absolute output, parts and limbs, in-domain weight. The last three have fades of
// their own, so they come after the low-pass.
void Stylist::Impl::ChangeStyle(const body::Pose& input) noexcept {
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
    for (int joint = 0; joint < body::kJointCount; ++joint) {
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

// The share of its style that a part of the body shows.
float Stylist::Impl::Shown(body::Part part) const noexcept {
  return mixer.share(part) * gate.weight(LimbOf(part));
}

void Stylist::Impl::Apply(Output& out) const noexcept {
  const body::Pose& input = out.canonical_input;
  body::Pose& styled = out.canonical;
  styled.hips_position_m = input.hips_position_m + out.travel.moved_m + filter.applied().col(kRise);
  for (std::size_t joint = 0; joint < body::kJointCount; ++joint) {
    const body::Vec3 turn = filter.applied().col(static_cast<Eigen::Index>(joint));
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

Stylist::Impl::Impl(std::shared_ptr<const net::Stylizer> network,
                    std::shared_ptr<const rig::Binding> the_rig, const Options& the_options)
    : binding(std::move(the_rig)),
      options(the_options),
      input_guard(binding->skeleton()),
      predictor(std::move(network)),
      feet(feet::HumanoidBinding(), feet::HumanoidBinding(), options.feet_options),
      rig_feet(*binding, *binding, options.feet_options) {
  for (std::size_t joint = 0; joint < body::kJointCount; ++joint) {
    offsets_in[joint] = offsets_out[joint] = body::Offset(static_cast<int>(joint));
  }
}

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

void Stylist::SetMeasured(bool measured) noexcept { impl_->measured = measured; }

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

void Stylist::Mirror() noexcept {
  impl_->filter.Mirror();
  impl_->posture.Mirror();
  impl_->gate.Mirror();
  impl_->neutral.Mirror();
  Reset();
}

void Stylist::Carry(Checkpoint& c) noexcept {
  Impl& s = *impl_;
  const net::Model& model = s.predictor.network()->model();
  const auto styles = static_cast<int>(model.styles.size());
  const auto contents = static_cast<int>(model.contents.size());
  s.settings.Carry(c, styles, contents);
  s.mixer.Carry(c, styles, contents);
  c(s.input_guard, s.neutral, s.predictor, s.filter, s.domain, s.gate, s.posture, s.stride,
    s.shift_m, s.rig_shift, s.feet, s.rig_feet, s.feet_style);
  c.Time(s.last_ns);
  bool failed = s.failed();
  c(s.dt_s, s.last_gap_s, s.started, s.fresh_session, failed);
  // The checkpoint does not record which pose failed.
  if (c.reads()) s.failure = failed ? Failure::kPrediction : Failure::kNone;
}

}  // namespace styled::stylist
