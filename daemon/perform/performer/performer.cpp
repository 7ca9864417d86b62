#include "daemon/perform/performer/performer.h"

#include <bit>
#include <span>
#include <utility>

#include "daemon/looks/refusal.h"
#include "daemon/source/face.h"
#include "model/base/crc32c.h"
#include "model/base/text.h"

namespace styled::pipeline {

static_assert(decide::kLimbs == stylist::kLimbCount);
static_assert(int{v1::FAILURE_RIG} == static_cast<int>(stylist::Failure::kRig));

namespace {

// Of the stylist's time, where the rig's returns before it.
constexpr std::int64_t kLeastStep_ns = 1'000'000;
// After a checkpoint was restored, the silence before the body moves by itself: as stale_ms.
constexpr std::int64_t kRestored_ns = 250'000'000;

runtime::Counter CounterOf(v1::Failure failure) noexcept {
  switch (failure) {
    case v1::FAILURE_CANONICAL:
      return runtime::Counter::kStylistFailedCanonical;
    case v1::FAILURE_RIG:
      return runtime::Counter::kStylistFailedRig;
    case v1::FAILURE_AVATAR:
      return runtime::Counter::kStylistFailedAvatar;
    default:
      return runtime::Counter::kStylistFailedPrediction;
  }
}

}  // namespace

Performer::Performer(Profile& the_profile, int the_source, std::string the_name,
                     std::uint64_t epoch, std::int64_t now_ns,
                     publish::Subscriptions& subscriptions, runtime::Counters& counters)
    : profile(the_profile),
      source(the_source),
      name(std::move(the_name)),
      added_ns(now_ns),
      outputs(profile.id, epoch, subscriptions, counters),
      counters_(counters) {
  face_.reserve(kMaxFace);
  resting_face_.reserve(kMaxFace);
}

const rig::JointNames& Performer::Names(const RuntimeConfig& config) const {
  static const rig::JointNames kNone;
  const auto index = static_cast<std::size_t>(source);
  return index < config.joints.size() ? config.joints[index] : kNone;
}

void Performer::SetFingers(std::vector<FingerLayer*> layers) {
  finger_layers_ = std::move(layers);
  binding_.WantFingers(JointsOf(finger_layers_));
}

Status Performer::AcceptBody(const source::SourceFrame& body, const RuntimeConfig& config) {
  KeepNeutral();
  Status status = binding_.Accept(body, profile, Names(config));
  if (status.ok()) UseBinding(config);
  return status;
}

Result<v1::CalibrateReply> Performer::Calibrate(const v1::Calibrate& request,
                                                const RuntimeConfig& config, std::int64_t now_ns) {
  KeepNeutral();
  auto calibrated = binding_.Calibrate(request, profile, Names(config), now_ns);
  if (calibrated.ok()) UseBinding(config);
  return calibrated;
}

Status Performer::CalibrateNeutral(const v1::Calibrate& request) {
  constexpr float kUsual_s = 5, kLongest_s = 60;
  if (request.clear()) {
    profile.neutral.reset();
    if (styling_) styling_->stylist().ForgetNeutral();
    return Status::Ok();
  }
  const float seconds = request.seconds() == 0 ? kUsual_s : request.seconds();
  if (!(seconds >= 1 && seconds <= kLongest_s)) {
    return Refused(v1::CODE_OUT_OF_RANGE, "calibrate: seconds: found " +
                                              NumberText(request.seconds()) + ", expected 1 to " +
                                              NumberText(kLongest_s));
  }
  if (!styling_ || !admission.live()) {
    return Refused(v1::CODE_NOT_READY,
                   profile.id + ": expected a performer with a bound body that sends frames");
  }
  if (!styling_->stylist().has_neutral()) {
    return Refused(v1::CODE_NOT_READY,
                   "calibrate: these weights have no reference of how people stand and walk, or "
                   "[model] neutral is false; expected weights of version 3");
  }
  styling_->stylist().CalibrateNeutral(seconds);
  calibrates_neutral_ = true;
  return Status::Ok();
}

std::optional<KeptNeutral> Performer::TellNeutral() const {
  if (!styling_ || !styling_->stylist().has_neutral()) return profile.neutral;
  // The neutral saved for another body stays until this body has one of its own.
  if (styling_->stylist().neutral().body_s() == 0) return profile.neutral;
  // It is that of the performer as captured, so that it stays right while the look changes.
  const neutral::Known known = styling_->stylist().Tell();
  return KeptNeutral{BindingHash(*binding_.body().binding),
                     mirrored_ ? neutral::Mirrored(known) : known};
}

void Performer::KeepNeutral() { profile.neutral = TellNeutral(); }

bool Performer::PopNeutralCalibrated() noexcept {
  if (!calibrates_neutral_ || !styling_ || styling_->stylist().neutral().calibrates_s() > 0) {
    return false;
  }
  calibrates_neutral_ = false;
  return true;
}

void Performer::UseBinding(const RuntimeConfig& config) {
  styling_.emplace(binding_.body(), config, counters_);
  const rig::Binding& binding = *binding_.body().binding;
  mirror_ = rig::MirrorMap(binding, rig::FindTail(binding.skeleton(), binding.spec().source_joint));
  mirrored_ = profile.look.mirror();
  if (profile.neutral && profile.neutral->binding == BindingHash(binding)) {
    const neutral::Known& known = profile.neutral->known;
    styling_->stylist().Know(mirrored_ ? neutral::Mirrored(known) : known);
  }
  outputs.Bind(binding_.body(), binding_.given(), config);
  const auto index = static_cast<std::size_t>(source);
  const auto& skeleton = binding_.body().binding->skeleton();
  static const config::PropHands kAuto;
  props_.emplace(binding_.body(), index < config.props.size() ? config.props[index] : kAuto);
  smoothing_ = PoseSmoothing(
      index < config.smoothing.size() ? config.smoothing[index] : config::Smoothing(),
      static_cast<std::size_t>(skeleton.joint_count()), binding_.given().metres_per_unit());
  fingers_ = Fingers(finger_layers_, *binding_.body().binding);
  idle_.emplace(binding_.body().binding, profile.id);
  (void)ApplyLook(config);
  styling_->Relieve(relieved_);
}

void Performer::Relieve(bool relieved) noexcept {
  relieved_ = relieved;
  if (styling_) styling_->Relieve(relieved);
}

std::vector<std::string> Performer::ApplyLook(const RuntimeConfig& config) {
  UseMirror();
  unknown_styles_.clear();
  if (styling_) {
    unknown_styles_ = styling_->ApplyLook(profile, config);
  } else {
    (void)Resolve(profile.look, config.network->model().styles, unknown_styles_);
  }
  return unknown_styles_;
}

// For subscribers a change is a cut, as a new session is: the performer is elsewhere at once.
void Performer::UseMirror() noexcept {
  if (std::exchange(mirrored_, profile.look.mirror()) == profile.look.mirror()) return;
  if (styling_) styling_->Mirror();
  if (idle_) idle_->Mirror(mirror_);
  facing_.Reset();
}

void Performer::Rebuild(const RuntimeConfig& config) {
  if (!styling_) return;
  styling_->Rebuild(binding_.body(), config);
  outputs.Bind(binding_.body(), binding_.given(), config);
}

void Performer::Adopt(const RuntimeConfig& config) {
  if (!styling_) return;
  styling_->Adopt(config);
  outputs.Adopt(config);
}

void Performer::Restart() noexcept {
  if (styling_) styling_->Restart();
  ahead_ns_ = 0;
  sent_idle_ = false;
  smoothing_.Reset();
  facing_.Reset();
}

void Performer::Carry(Checkpoint& c, std::int64_t now_ns) noexcept {
  admission.Carry(c, now_ns);
  bool has_timecode = timecode.has_value();
  std::int64_t label = timecode.value_or(0);
  c(has_timecode);
  c.Time(label);
  if (c.reads()) timecode = has_timecode ? std::optional(label) : std::nullopt;
  c(smoothing_, fingers_, *idle_, *styling_, outputs, facing_, backwards_, backwards_logged_,
    sent_idle_);
  c.Time(faced_ns_);
  c.Time(ahead_ns_);
  c.Time(frame_.elapsed_ns);
  // The rig's next frame may be on its way, so that its body does not move by itself at once.
  if (c.reads()) next_idle_ns = now_ns + kRestored_ns;
}

runtime::Counter Performer::Accept(const decide::FrameInTransit& transit) noexcept {
  const source::SourceFrame& frame = *transit.given;
  if (!binding_.Receive(frame, transit.receive_ns)) return runtime::Counter::kPipelineWrongSize;
  if (!styling_) return runtime::Counter::kPipelineUncalibrated;
  const rig::MirrorMap* const mirror = mirrored_ ? &mirror_ : nullptr;
  const std::size_t left_out = props_->Accept(frame.props, frame.scene_props, mirror);
  if (left_out > 0) counters_.AddOf(source, runtime::Counter::kPipelinePropsLeftOut, left_out);
  // The hands are moved by the filter and by the body's own motion.
  if (smoothing_.active() || profile.look.idle() > 0) props_->AcceptUnfiltered(binding_.received());
  smoothing_.Apply(binding_.received(), transit.elapsed_ns);
  styling_->SetInput(binding_.received());
  fingers_.Apply(transit.elapsed_ns, styling_->in());
  if (mirrored_) {
    MirrorInput(transit.face);
  } else {
    face_.assign(transit.face.begin(), transit.face.end());
  }
  std::int64_t elapsed_ns = transit.elapsed_ns + ahead_ns_;
  if (std::exchange(sent_idle_, false) && elapsed_ns <= frame_.elapsed_ns) {
    ahead_ns_ += frame_.elapsed_ns + kLeastStep_ns - elapsed_ns;
    elapsed_ns = frame_.elapsed_ns + kLeastStep_ns;
  }
  frame_ = transit;
  frame_.given = nullptr;
  frame_.face = {};
  frame_.elapsed_ns = elapsed_ns;
  idle_->Apply(elapsed_ns, profile.look.idle(), styling_->in());
  styling_->stylist().SetMeasured(true);
  return decide::Decision::kNoReason;
}

// The face of another source that is here, or the performer's own, which relaxes and blinks.
void Performer::RestFace(std::span<const std::byte> merged) noexcept {
  if (!merged.empty() && !mirrored_) {
    resting_face_.assign(merged.begin(), merged.end());
    return;
  }
  resting_face_.resize(kMaxFace);  // as much as is reserved
  resting_face_.resize(!merged.empty() ? source::MirrorFace(merged, resting_face_)
                                       : source::RestFace(face_, idle_->FaceKept(),
                                                          idle_->EyesClosed(), resting_face_));
}

bool Performer::AcceptSilent(const decide::FrameInTransit& transit) noexcept {
  if (!idles()) return false;
  if (!idle_->ApplySilent(transit.elapsed_ns, profile.look.idle(), styling_->in())) return false;
  RestFace(transit.face);
  frame_.decision = {};
  frame_.decision.fate = v1::FATE_STYLED;
  frame_.elapsed_ns = transit.elapsed_ns;
  frame_.arrival_ns = transit.arrival_ns;
  frame_.receive_ns = transit.receive_ns;
  frame_.wall_ns = transit.wall_ns;
  frame_.flags = v1::FLAG_STALE;
  frame_.failure = v1::FAILURE_NONE;
  styling_->stylist().SetMeasured(false);
  sent_idle_ = true;
  return true;
}

// The pose, with the fingers that other sources add, and the face. The props are mirrored already.
void Performer::MirrorInput(std::span<const std::byte> face) noexcept {
  mirror_.Apply(styling_->in(), binding_.received());
  std::swap(styling_->in(), binding_.received());
  face_.resize(kMaxFace);  // as much as is reserved
  face_.resize(source::MirrorFace(face, face_));
}

stylist::Stylist::Job Performer::Style() noexcept { return styling_->MakeJob(frame_.elapsed_ns); }

void Performer::LeavePropsTo(const Performer& other) noexcept {
  if (other.shares_props()) props_->LeaveTo(*other.props_);
}

void Performer::Finish(std::int64_t publish_ns) noexcept {
  frame_.publish_ns = publish_ns;
  // Retargeting needs canonical axes, so it comes before the poses are transformed to the rig's
  // axes.
  const bool failed = outputs.Retarget(frame_.elapsed_ns, styling_->out(), *props_);
  styling_->Finish(failed ? stylist::kFailed : 0U);
  WatchFacing();
  const stylist::Output& out = styling_->out();
  frame_.flags |= out.flags;
  frame_.failure = static_cast<v1::Failure>(out.failure);
  // The flag of an avatar's own failure is on its topic alone.
  if (failed && frame_.failure == v1::FAILURE_NONE) frame_.failure = v1::FAILURE_AVATAR;
  if (frame_.failure != v1::FAILURE_NONE) counters_.Add(CounterOf(frame_.failure));
  frame_.held_joints = static_cast<int>(out.held.count());
  frame_.first_held_joint = static_cast<int>(out.held._Find_first());
  // The rig's joint is meant, not the one that shows it.
  if (mirrored_ && out.held.any()) frame_.first_held_joint = mirror_.pair(frame_.first_held_joint);
  frame_.limb_weights = out.limb_weights;
  frame_.limb_errors_m = out.limb_errors_m;
  Serialize();
  repeats_ = false;
}

void Performer::WatchFacing() noexcept {
  const std::int64_t step_ns = frame_.elapsed_ns - std::exchange(faced_ns_, frame_.elapsed_ns);
  facing_.Sample(styling_->out().canonical_input, static_cast<double>(step_ns) * 1e-9);
  backwards_ = binding_.body().toes_backwards || facing_.backwards();
  if (!backwards_) return;
  frame_.flags |= v1::FLAG_BACKWARDS;
  counters_.Add(runtime::Counter::kPipelineBackwards);
}

void Performer::Prewarm() noexcept {
  if (styling_ && !relieved_) styling_->Prewarm();
}

std::uint32_t Performer::StyledCrc() const noexcept {
  const body::Pose* const pose = styled();
  if (pose == nullptr) return 0;
  const std::uint32_t hips = Crc32c(std::as_bytes(std::span(pose->hips_position_m.data(), 3)));
  return Crc32c(std::as_bytes(std::span(pose->rotations))) ^ std::rotl(hips, 1);
}

bool Performer::Repeat(const decide::FrameInTransit& now) noexcept {
  if (!styling_ || !styling_->has_output()) return false;
  const std::uint32_t once = v1::FLAG_CONCEALED | v1::FLAG_NEW_SESSION;
  const std::uint32_t backwards = backwards_ ? v1::FLAG_BACKWARDS : v1::FLAG_NONE;
  frame_.flags = (styling_->out().flags & ~once) | backwards | v1::FLAG_STALE;
  frame_.arrival_ns = now.arrival_ns;
  frame_.receive_ns = now.receive_ns;
  frame_.publish_ns = now.publish_ns;
  frame_.wall_ns = now.wall_ns;
  Serialize();
  repeats_ = true;
  return true;
}

void Performer::Serialize() noexcept {
  frame_.decision.sequence = profile.next_sequence++;
  frame_.contacts = styling_->out().contacts;
  outputs.Serialize(frame_, *styling_, sent_idle_ ? resting_face_ : face_);
}

void Performer::Send(publish::Publisher& publisher, std::span<publish::Bundle> bundles,
                     std::int64_t now_ns) {
  outputs.Send(publisher, bundles, now_ns, repeats_);
}

std::string Performer::Warning() const {
  if (refusal != nullptr && !admission.live()) return *refusal;
  if (binding_.waits()) {
    return "the rig's rest pose is unknown: let the performer stand in T-pose, and stylectl "
           "calibrate " +
           profile.id + " --pose t";
  }
  if (binding_.bound() && binding_.body().toes_backwards) {
    return "the toes point backwards: left and right are exchanged, or the axes are mirrored; "
           "correct it in the rig, or by stylectl calibrate " +
           profile.id + " --pose t";
  }
  if (backwards_) {
    return "walks against where the toes point; if that is not meant, left and right are "
           "exchanged, or the axes are mirrored: correct it in the rig, or by stylectl calibrate " +
           profile.id + " --pose t";
  }
  return binding_.bound() ? binding_.body().remark : "";
}

bool Performer::FacingChanged() noexcept {
  return std::exchange(backwards_logged_, backwards_) != backwards_;
}

void Performer::Sample(std::int64_t now_ns) {
  admission.Sample(outputs.Sample());
  latency.Sample(admission.live(), now_ns);
  if (styling_) styling_->Sample();
}

void Performer::Describe(v1::PerformerStats& stats) const {
  admission.Describe(stats);
  stats.set_published(outputs.published());
  latency.Describe(stats);
  stats.set_overload_bypass(relieved_);
  stats.set_overload_bypassed(relieved_frames_);
  stats.set_warning(Warning());
  if (stats.warning().empty() && !unknown_styles_.empty()) {
    stats.set_warning("no style \"" + unknown_styles_.front() +
                      "\" is here any more, and it has no effect: choose another");
  }
  if (styling_) styling_->Describe(stats);
  if (!binding_.bound()) return;
  stats.set_joints(static_cast<std::uint32_t>(binding_.body().binding->skeleton().joint_count()));
  stats.set_dialect(binding_.body().dialect);
}

}  // namespace styled::pipeline
