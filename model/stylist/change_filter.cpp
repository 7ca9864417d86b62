#include "model/stylist/change_filter.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "model/base/smooth.h"
#include "model/body/pose.h"
#include "model/stylist/tuning.h"

namespace styled::stylist {
namespace {

using body::kJointCount;

// By Newton's method: the compiler computes no std::sqrt beforehand.
constexpr float Length_m(const body::JointRow& row) {
  const double x = row.x_m, y = row.y_m, z = row.z_m;
  double length = 1;
  for (int i = 0; i < 60; ++i) length = (length + (x * x + y * y + z * z) / length) / 2;
  return static_cast<float>(length);
}

// The distance (m) that the body extends beyond each joint.
constexpr std::array<float, kJointCount> LimbReaches_m() {
  std::array<float, kJointCount> reach_m{};
  reach_m.fill(tuning::kEndReach_m);
  for (int joint = kJointCount - 1; joint > 0; --joint) {
    const auto j = static_cast<std::size_t>(joint);
    const auto parent = static_cast<std::size_t>(body::kHumanoid[j].parent);
    reach_m[parent] = std::max(reach_m[parent], Length_m(body::kHumanoid[j]) + reach_m[j]);
  }
  return reach_m;
}
constexpr std::array<float, kJointCount> kLimbReach_m = LimbReaches_m();

// An upper bound (m) on the displacement of any point of the body when `to` replaces `from`.
float Displacement_m(const StyleDelta& from, const StyleDelta& to) {
  std::array<float, kJointCount> moved_m;
  float most_m = 0;
  for (int joint = 0; joint < kJointCount; ++joint) {
    const auto j = static_cast<std::size_t>(joint);
    const float above_m =
        joint == 0 ? 0 : moved_m[static_cast<std::size_t>(body::kHumanoid[j].parent)];
    moved_m[j] = above_m + (to.col(joint) - from.col(joint)).norm() * kLimbReach_m[j];
    most_m = std::max(most_m, moved_m[j]);
  }
  return most_m;
}

float FadeStep(double dt_s, const Options& options) {
  return static_cast<float>(dt_s) / std::max(1e-3F, options.restart_fade_s);
}

}  // namespace

float ChangeFilter::UsualDelay_s(float dt_s, float reconstruction_rad, const Mixer& mixer,
                                 const Options& options) noexcept {
  const float share = started_ ? DecayShare(dt_s, tuning::kReconstruction_s) : 1.0F;
  reconstruction_rad_ += (reconstruction_rad - reconstruction_rad_) * share;
  const float early = 1 - SmoothStep(age_s_ / tuning::kStart_s);
  // while fading to bypass, its error does not matter
  const float badly =
      mixer.empty()
          ? 0
          : SmoothStep((reconstruction_rad_ - tuning::kSlowerBegin_rad) / tuning::kSlowerSpan_rad);
  const float slower = std::max(tuning::kSlowerBy * badly, tuning::kSlowerAtStart * early);
  return options.change_tau_s * (1 + slower);
}

// If the target steps by d metres, a low-pass with delay T accelerates a limb by about d / T^2.
float ChangeFilter::SwitchDelay_s(const StyleDelta& target, float dt_s, float usual_s,
                                  const Mixer& mixer) noexcept {
  switching_ = mixer.fading() ? 1.0F : std::max(0.0F, switching_ - dt_s / tuning::kSwitchTail_s);
  if (switching_ == 0) {
    switch_delay_s_ = 0;
    return usual_s;
  }
  const float displacement_m = Displacement_m(low_pass_.value(), target);
  switch_delay_s_ = std::max(std::sqrt(displacement_m / tuning::kSwitchAcceleration_mps2),
                             switch_delay_s_ * (1 - DecayShare(dt_s, tuning::kSwitchHold_s)));
  return usual_s + switching_ * std::max(0.0F, switch_delay_s_ - usual_s);
}

void ChangeFilter::Follow(const StyleDelta& target, double dt_s, float reconstruction_rad,
                          const Mixer& mixer, const Options& options) noexcept {
  first_ = !started_;
  const auto dt = static_cast<float>(dt_s);
  age_s_ = first_ ? 0 : age_s_ + dt;
  const float usual_s = UsualDelay_s(dt, reconstruction_rad, mixer, options);
  delay_s_ = first_ ? 0 : SwitchDelay_s(target, dt, usual_s, mixer);
  low_pass_.Follow(target, first_ ? 0 : dt_s, delay_s_);
  started_ = true;
  if (mixer.empty()) low_pass_.SettleAtZero();
}

void ChangeFilter::Apply(const StyleDelta& delta, double dt_s, const Options& options) noexcept {
  applied_ = delta;
  if (fade_ >= 1.0F) return;
  if (!first_) fade_ += FadeStep(dt_s, options);
  applied_ = fade_from_ + SmoothStep(fade_) * (delta - fade_from_);
}

void ChangeFilter::Restart(bool fade) noexcept {
  fade_from_ = applied_;
  fade_ = fade ? 0.0F : 1.0F;
  started_ = false;
  reconstruction_rad_ = switching_ = switch_delay_s_ = 0;
}

void ChangeFilter::RestartAfterGap(bool fade, double dt_s, const Options& options) noexcept {
  const float under_way = fade_;
  const StyleDelta from = fade_from_;
  Restart(fade);
  if (under_way >= 1.0F) return;
  fade_from_ = from;
  fade_ = under_way + FadeStep(dt_s, options);
}

void ChangeFilter::Mirror() noexcept {
  const StyleDelta applied = applied_;
  for (int joint = 0; joint < kJointCount; ++joint) {
    applied_.col(joint) = applied.col(body::MirrorJoint(joint)).cwiseProduct(body::Vec3(1, -1, -1));
  }
}

void ChangeFilter::Clear() noexcept {
  *this = ChangeFilter();
  fade_ = 0;
}

}  // namespace styled::stylist
