#include "model/stylist/avatar.h"

#include <cassert>
#include <utility>

#include "model/stylist/grounding.h"
#include "model/stylist/guard.h"

namespace styled::stylist {
namespace {

rig::TailMap TailOf(const rig::Binding& binding, const rig::TailMap& map) {
  return rig::Tail::Make(binding, map).map();
}

}  // namespace

Avatar::Avatar(std::shared_ptr<const rig::Binding> performer,
               std::shared_ptr<const rig::Binding> avatar, const rig::RigPose& rest,
               const Options& options, const rig::TailMap& tail)
    : performer_(std::move(performer)),
      avatar_(std::move(avatar)),
      ground_(options.ground),
      hold_(options.feet),
      ground_tau_s_(options.ground_tau_s),
      feet_(*performer_, *avatar_, options.feet_options),
      performed_(performer_->skeleton()),
      last_(rest),
      pose_(rest) {
  const auto theirs =
      TailOf(*performer_, rig::FindTail(performer_->skeleton(), performer_->spec().source_joint));
  const auto own = TailOf(*avatar_, tail);
  performer_tail_ = rig::Tail::Make(*performer_, rig::Both(theirs, own));
  avatar_tail_ = rig::Tail::Make(*avatar_, rig::Both(own, theirs));
  assert(performer_tail_.size() == avatar_tail_.size());
  tail_.assign(performer_tail_.size(), rig::Quat::Identity());
}

void Avatar::Reset() noexcept {
  started_ = false;
  feet_.Reset();
  shift_m_.Reset();
}

bool Avatar::Process(std::int64_t time_ns, const Output& styled) noexcept {
  const bool sound = ProcessBody(time_ns, styled);
  performer_tail_.Read(styled.rig.rotations, tail_);
  avatar_tail_.Write(tail_, pose_.rotations);
  return sound;
}

bool Avatar::ProcessBody(std::int64_t time_ns, const Output& styled) noexcept {
  if ((styled.flags & kNewSession) != 0) Reset();
  const float dt_s = started_ ? static_cast<float>(time_ns - last_ns_) * 1e-9F : 0.0F;
  last_ns_ = time_ns;
  started_ = true;
  for (std::size_t joint = 0; joint < performed_.rotations.size(); ++joint) {
    performed_.translations[joint] = styled.source.translations[joint];
    performed_.rotations[joint] = styled.source.rotations[joint].normalized();
  }
  // Unbind needs the former pose as `received`: for its joints without a source and for signs.
  std::swap(last_, pose_);
  avatar_->Unbind(styled.canonical, last_, pose_);
  if (ground_) {
    const float wanted_m = GroundShift_m(*performer_, performed_, *avatar_, pose_);
    ShiftUp(*avatar_, shift_m_.Follow(wanted_m, dt_s, ground_tau_s_) / avatar_->scale(), pose_);
  }
  feet_.Process(dt_s, hold_ ? 1.0F : 0.0F, {performed_.translations, performed_.rotations},
                {pose_.translations, pose_.rotations}, styled.travel);
  if (IsSound(*avatar_, pose_, styled.canonical)) return true;
  // The feet's state may be the cause: reset it, and show the performer's own motion.
  Reset();
  body::Pose own = styled.canonical_input;
  own.hips_position_m += styled.travel.moved_m;
  avatar_->Unbind(own, last_, pose_);
  return false;
}

}  // namespace styled::stylist
