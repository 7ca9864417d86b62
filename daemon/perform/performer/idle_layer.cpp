#include "daemon/perform/performer/idle_layer.h"

#include <algorithm>
#include <utility>

#include "model/base/hash.h"
#include "model/base/smooth.h"

namespace styled::pipeline {

namespace {

// In which a changed amount is reached: a switch is not seen as a jump.
constexpr float kAmountTau_s = 0.5F;
// In which the head begins to wander when nothing measures it any more.
constexpr float kHeadTau_s = 2.0F;
// Below this, 0.02 mm of breath, the motion has faded.
constexpr float kNone = 2e-3F;
// A longer step is a gap of the session's time: the motion continues where it was.
constexpr double kLongestStep_s = 0.1;

std::uint32_t SeedOf(std::string_view id) {
  Fnv1a hash;
  hash.Text(id);
  return static_cast<std::uint32_t>(hash.value() ^ (hash.value() >> 32U));
}

bool IsSound(const rig::Quat& rotation) noexcept {
  return rotation.coeffs().allFinite() && rotation.squaredNorm() > 1e-6F;
}

}  // namespace

IdleLayer::IdleLayer(std::shared_ptr<const rig::Binding> binding, std::string_view id)
    : binding_(std::move(binding)),
      idle_(SeedOf(id)),
      last_(binding_->skeleton()),
      left_(last_),
      shown_(last_),
      scratch_(last_) {}

void IdleLayer::Advance(std::int64_t elapsed_ns, float amount, bool silent) noexcept {
  const double passed_s =
      static_cast<double>(elapsed_ns - std::exchange(elapsed_ns_, elapsed_ns)) * 1e-9;
  const double step_s = std::clamp(passed_s, 0.0, kLongestStep_s);
  time_s_ += step_s;
  step_s_ = static_cast<float>(step_s);
  amounts_.body += (amount - amounts_.body) * DecayShare(step_s_, kAmountTau_s);
  if (amount == 0 && amounts_.body < kNone) amounts_.body = 0;
  const float head = silent ? std::min(amount, 1.0F) : 0;
  amounts_.head += (head - amounts_.head) * DecayShare(step_s_, kHeadTau_s);
  if (head == 0 && amounts_.head < kNone) amounts_.head = 0;
}

void IdleLayer::KeepFinite(const rig::RigPose& pose) noexcept {
  if (pose.translations.front().allFinite()) last_.translations.front() = pose.translations.front();
  for (std::size_t j = 0; j < pose.rotations.size(); ++j) {
    if (IsSound(pose.rotations[j])) last_.rotations[j] = pose.rotations[j].normalized();
  }
  has_last_ = true;
}

// last_ with the motion, or on the way back to it.
void IdleLayer::Show() noexcept {
  body::Pose pose;
  binding_->Bind(last_, pose);
  idle_.Add(time_s_, amounts_, pose);
  binding_->Unbind(pose, last_, shown_);
  if (returning_ <= 0) return;
  const float share = SmoothStep(returning_);
  rig::Vec3& root = shown_.translations.front();
  root += share * (left_.translations.front() - root);
  for (std::size_t j = 0; j < shown_.rotations.size(); ++j) {
    shown_.rotations[j] = shown_.rotations[j].slerp(share, left_.rotations[j]).normalized();
  }
}

void IdleLayer::Apply(std::int64_t elapsed_ns, float amount, rig::RigPose& pose) noexcept {
  Advance(elapsed_ns, amount, false);
  if (std::exchange(silent_, false)) {
    returning_ = 1;
    left_ = shown_;  // of the same size: allocates nothing
  } else {
    returning_ = std::max(returning_ - step_s_ / kReturn_s, 0.0F);
  }
  KeepFinite(pose);  // always: the motion may begin when the rig is silent already
  if (amounts_.body == 0 && amounts_.head == 0 && returning_ == 0) return;
  Show();
  if (pose.translations.front().allFinite())
    pose.translations.front() = shown_.translations.front();
  for (std::size_t j = 0; j < pose.rotations.size(); ++j) {
    if (IsSound(pose.rotations[j])) pose.rotations[j] = shown_.rotations[j];
  }
}

bool IdleLayer::ApplySilent(std::int64_t elapsed_ns, float amount, rig::RigPose& pose) noexcept {
  if (!has_last_) return false;
  Advance(elapsed_ns, amount, true);
  silent_ = true;
  returning_ = std::max(returning_ - step_s_ / kReturn_s, 0.0F);
  Show();
  pose.translations.front() = shown_.translations.front();
  std::ranges::copy(shown_.rotations, pose.rotations.begin());
  return true;
}

void IdleLayer::Mirror(const rig::MirrorMap& map) noexcept {
  for (rig::RigPose* const pose : {&last_, &left_, &shown_}) {
    map.Apply(*pose, scratch_);
    std::swap(*pose, scratch_);
  }
}

void IdleLayer::Carry(Checkpoint& c) noexcept {
  c(time_s_, amounts_.body, amounts_.head, has_last_, silent_, returning_, last_, left_, shown_);
  c.Time(elapsed_ns_);
}

}  // namespace styled::pipeline
