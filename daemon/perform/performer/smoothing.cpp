#include "daemon/perform/performer/smoothing.h"

#include <algorithm>
#include <numbers>

#include "model/body/pose.h"

namespace styled::pipeline {
namespace {

// Cutoff of the speed's own low-pass, Hz; the paper's value.
constexpr float kSpeed_hz = 1;
// The position's growth of the cutoff per m/s over a joint's per rad/s: hips move at a tenth of the
// speed, in numbers, at which limbs turn (walks of set 2: 1.2 m/s beside 3 to 8 rad/s).
constexpr float kPerMetre = 5;

float Share(float cutoff_hz, float step_s) noexcept {
  const float r = 2 * std::numbers::pi_v<float> * cutoff_hz * step_s;
  return r / (r + 1);
}

}  // namespace

PoseSmoothing::PoseSmoothing(const config::Smoothing& options, std::size_t joints,
                             float metres_per_unit)
    : options_(options),
      metres_per_unit_(metres_per_unit > 0 ? metres_per_unit : 1),
      joints_(options.rest_hz > 0 ? joints : 0) {}

void PoseSmoothing::Turn(Joint& joint, rig::Quat& rotation, float step_s) const noexcept {
  const float length = rotation.norm();
  if (!(length > 0.5F && length < 2)) return;  // not tracked; the stylist sees to it
  rig::Quat now(rotation.coeffs() / length);
  if (!joint.known) {
    joint = {now, rig::Vec3::Zero(), true};
    return;
  }
  if (now.dot(joint.rotation) < 0) now.coeffs() = -now.coeffs();
  const rig::Vec3 speed = body::Log(joint.rotation.conjugate() * now) / step_s;
  joint.speed += Share(kSpeed_hz, step_s) * (speed - joint.speed);
  const float cutoff_hz = options_.rest_hz + options_.per_speed * joint.speed.norm();
  joint.rotation = joint.rotation.slerp(Share(cutoff_hz, step_s), now).normalized();
  rotation = joint.rotation;
}

void PoseSmoothing::Move(rig::Vec3& position, float step_s) noexcept {
  if (!position.allFinite()) return;
  if (!has_position_) {
    has_position_ = true;
    position_ = position;
    velocity_.setZero();
    return;
  }
  const rig::Vec3 velocity = (position - position_) / step_s;
  velocity_ += Share(kSpeed_hz, step_s) * (velocity - velocity_);
  const float speed_mps = metres_per_unit_ * velocity_.norm();
  const float cutoff_hz = options_.rest_hz + kPerMetre * options_.per_speed * speed_mps;
  position_ += Share(cutoff_hz, step_s) * (position - position_);
  position = position_;
}

void PoseSmoothing::Apply(rig::RigPose& pose, std::int64_t time_ns) noexcept {
  if (!active()) return;
  const std::int64_t step_ns = time_ns - time_ns_;
  time_ns_ = time_ns;
  if (!any_ || step_ns <= 0 || step_ns > kGap_ns) {
    for (Joint& joint : joints_) joint.known = false;
    has_position_ = false;
    any_ = true;
  }
  const float step_s = static_cast<float>(std::clamp<std::int64_t>(step_ns, 1, kGap_ns)) * 1e-9F;
  const std::size_t count = std::min(joints_.size(), pose.rotations.size());
  for (std::size_t i = 0; i < count; ++i) Turn(joints_[i], pose.rotations[i], step_s);
  if (!pose.translations.empty()) Move(pose.translations.front(), step_s);
}

}  // namespace styled::pipeline
