#include "model/gait/tracker.h"

#include <algorithm>
#include <cmath>

#include "model/base/smooth.h"
#include "model/body/heading.h"

namespace styled::gait {
namespace {

using body::Vec3;

// An angle within -pi .. pi.
float Wrapped(float rad) noexcept {
  return rad - tuning::kTurn_rad * std::round(rad / tuning::kTurn_rad);
}

// The same angle within 0 .. 2 pi.
float WithinTurn(float rad) noexcept {
  return rad - tuning::kTurn_rad * std::floor(rad / tuning::kTurn_rad);
}

void Approach(float& mean, float value, float dt_s, float tau_s) noexcept {
  mean += DecayShare(dt_s, tau_s) * (value - mean);
}

}  // namespace

float RunShare(const Phase& phase, float speed_mps) noexcept {
  float share = SmoothStep(phase.bounce_m, tuning::kSinks_m, tuning::kBounces_m);
  if (speed_mps > tuning::kOnTheSpot_mps) {
    share *= SmoothStep(speed_mps, tuning::kSurelyWalk_mps, tuning::kMayRun_mps);
  }
  return std::max(share, SmoothStep(speed_mps, tuning::kMayWalk_mps, tuning::kSurelyRun_mps));
}

void Tracker::Follow(const body::WorldPose& world, float heading_rad, const Vec3& velocity_mps,
                     float dt_s) noexcept {
  if (!(dt_s < tuning::kHole_s)) Reset();
  const Vec3 apart_m = world.positions_m[body::kLeftFoot] - world.positions_m[body::kRightFoot];
  const float distance_m =
      apart_m.x() * std::sin(heading_rad) + apart_m.z() * std::cos(heading_rad);
  const float hips_m = world.positions_m[body::kHips].y();
  const bool sound = apart_m.norm() < tuning::kFarthest_m && std::isfinite(distance_m) &&
                     std::isfinite(hips_m) && velocity_mps.norm() <= tuning::kFastest_mps;
  if (!sound) return Reset();
  if (!started_) {
    started_ = true;
    distance_m_ = distance_m;
    hips_m_ = hips_m;
    return;
  }
  if (!(dt_s > tuning::kShortest_s)) return;
  const float dt = std::min(dt_s, tuning::kLongest_s);
  // 1 The analytic signal: the distance about its slow mean, and its derivative a quarter of a
  // period later. Only a gait has a mean, or one long stance would be it.
  const float speed_mps = (distance_m - distance_m_) / dt_s;
  distance_m_ = distance_m;
  const float share = DecayShare(dt_s, tuning::kDerivative_s);
  speed_mps_ += share * (speed_mps - speed_mps_);
  // Without the sine itself, which it would follow a little.
  const float sine_m = amplitude_m_ * std::cos(phase_.phase_rad + dt_s * phase_.rate_rad_s);
  mean_m_ += phase_.confidence * DecayShare(dt, tuning::kMean_s) * (distance_m - mean_m_ - sine_m);
  float& rate = phase_.rate_rad_s;
  // The smoothed derivative is late by half a frame and by the low-pass; a sine's is known without.
  const float late = rate * dt_s * (1 / share - 0.5F);
  const float ahead_m = distance_m - mean_m_;
  const std::complex<float> signal(ahead_m, ahead_m * late - (1 + late * late) * speed_mps_ / rate);
  const float size_m = std::abs(signal);
  // 2 The loop.
  const float error_rad = Wrapped(std::arg(signal) - phase_.phase_rad - dt_s * rate);
  const float followed = std::min(1.0F, size_m / tuning::kFollowed_m);
  const float loop_rad_s =
      tuning::kSearch_rad_s + phase_.confidence * (tuning::kLoop_rad_s - tuning::kSearch_rad_s);
  const float pull = loop_rad_s * error_rad * followed;
  phase_.phase_rad = WithinTurn(phase_.phase_rad + dt_s * rate + dt * 2 * tuning::kDamping * pull);
  rate =
      std::clamp(rate + 0.5F * dt * loop_rad_s * pull, tuning::kLeast_rad_s, tuning::kMost_rad_s);
  if (followed < tuning::kIdle) Approach(rate, tuning::kUsual_rad_s, dt, tuning::kIdle_s);
  // 3 The way.
  const float cosine = std::cos(heading_rad), sine = std::sin(heading_rad);
  Approach(heading_.x(), sine, dt, tuning::kVelocity_s);  // as late as the velocity
  Approach(heading_.y(), cosine, dt, tuning::kVelocity_s);
  const float x = velocity_mps.x(), z = velocity_mps.z();
  Approach(way_mps_.x(), x * heading_.y() - z * heading_.x(), dt, tuning::kWay_s);
  Approach(way_mps_.y(), x * heading_.x() + z * heading_.y(), dt, tuning::kWay_s);
  // 4 The confidence.
  Approach(amplitude_m_, size_m, dt, tuning::kMeans_s);
  Approach(lock_, std::cos(error_rad), dt, tuning::kMeans_s);
  Approach(lift_, apart_m.y() * speed_mps, dt, tuning::kMeans_s);
  Approach(square_speed_, speed_mps_ * speed_mps_, dt, tuning::kSpeed_s);
  Approach(hips_m_, hips_m, dt, tuning::kHips_s);
  Approach(phase_.bounce_m, (hips_m - hips_m_) * std::cos(2 * phase_.phase_rad), dt,
           tuning::kBounce_s);
  const float target = Target();
  Approach(phase_.confidence, target, dt,
           target < phase_.confidence ? tuning::kFall_s : tuning::kRise_s);
}

// 1 for steps ahead, 0 for steps sideways or backward. Where the performer gets somewhere, the way
// decides; on the spot, the foot that moves forward must be the higher one.
float Tracker::Ahead() const noexcept {
  const float speed_mps = way_mps_.norm();
  const float known = SmoothStep(speed_mps, tuning::kDirected_mps, tuning::kSurely_mps);
  const float by_lift = SmoothStep(lift_, tuning::kBackward, tuning::kForward);
  const float by_way =
      SmoothStep(way_mps_.y() / std::max(speed_mps, 1e-3F), tuning::kSideways, tuning::kStraight);
  return by_lift + known * (by_way - by_lift);
}

float Tracker::Target() const noexcept {
  const float by_speed_m =
      std::sqrt(2 * square_speed_) / std::max(phase_.rate_rad_s, tuning::kSlow_rad_s);
  return SmoothStep(std::min(amplitude_m_, by_speed_m), tuning::kNoStep_m, tuning::kStep_m) *
         SmoothStep(lock_, tuning::kUnlocked, tuning::kLocked) * Ahead();
}

Tracker Tracker::Before(float s) const noexcept {
  Tracker before = *this;
  before.phase_.phase_rad = WithinTurn(phase_.After(-s));
  before.started_ = false;  // the next frame has no distance before it
  return before;
}

void Tracker::Mirror() noexcept {
  phase_.phase_rad = WithinTurn(phase_.phase_rad + tuning::kTurn_rad / 2);
  for (float* const to_the_left : {&distance_m_, &mean_m_, &speed_mps_, &heading_[0], &way_mps_[0]})
    *to_the_left = -*to_the_left;
}

void Tracker::Carry(Checkpoint& c) noexcept {
  c(phase_.phase_rad, phase_.rate_rad_s, phase_.confidence, distance_m_, mean_m_, speed_mps_,
    amplitude_m_, square_speed_, lock_, lift_, heading_, way_mps_, hips_m_, phase_.bounce_m,
    started_);
  if (!c.reads() || !c.ok()) return;
  const auto within = [](float x, float least, float most) { return x >= least && x <= most; };
  constexpr float kMost_m = 2 * tuning::kFarthest_m, kMost = 1e9F, kTolerance = 1e-3F;
  const bool sound = within(phase_.phase_rad, 0, tuning::kTurn_rad) &&
                     within(phase_.rate_rad_s, tuning::kLeast_rad_s, tuning::kMost_rad_s) &&
                     within(phase_.confidence, 0, 1) && within(distance_m_, -kMost_m, kMost_m) &&
                     within(mean_m_, -kMost_m, kMost_m) && within(speed_mps_, -kMost, kMost) &&
                     within(amplitude_m_, 0, kMost) && within(square_speed_, 0, kMost * kMost) &&
                     within(lock_, -1, 1) && within(lift_, -kMost, kMost) &&
                     heading_.norm() <= 1 + kTolerance && way_mps_.norm() <= kMost &&
                     within(hips_m_, -kMost, kMost) && within(phase_.bounce_m, -kMost, kMost);
  if (!sound) c.Refuse();
}

}  // namespace styled::gait
