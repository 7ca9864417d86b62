#include "model/stylist/stride.h"

#include <algorithm>
#include <cmath>

#include "model/base/smooth.h"
#include "model/stylist/tuning.h"

namespace styled::stylist {

using body::Vec3;

Stride::Step Stride::Measure(const Vec3& hips_m, double dt_s, double hole_s) noexcept {
  if (!hips_m.allFinite()) return Step::kNone;
  step_m_ = Vec3(hips_m.x() - last_m_.x(), 0, hips_m.z() - last_m_.z());
  last_m_ = hips_m;
  const bool first = !placed_;
  placed_ = true;
  if (first || !(dt_s > 0)) return Step::kNone;
  const auto dt = static_cast<float>(dt_s);
  if (dt_s >= hole_s || !(step_m_.norm() <= tuning::kRunningFast_mps * dt)) {
    seen_ = 0;  // the former velocity is useless
    return Step::kNone;
  }
  // An average over at most the session, so that a session that begins in mid-stride does not begin
  // with the speed of standing.
  const float share = DecayShare(dt, tuning::kStrideSpeed_s);
  seen_ += share * (1 - seen_);
  // Frames some nanoseconds apart have no share at all.
  if (seen_ > 0) velocity_mps_ += share / seen_ * (step_m_ / dt - velocity_mps_);
  return Step::kAccepted;
}

namespace {

// Farther than any performer walks within days; beyond, a float's steps are visible.
constexpr double kFarthest_m = 1e5;

// A factor that follows exp(`log_target`), and is exactly 1 where it settles at 1.
float FollowFactor(CriticallyDamped& log_factor, float log_target, float dt_s,
                   float tau_s) noexcept {
  // If a stage's state is not sound, which the output will show, the path stays the performer's,
  // because a gained offset would remain.
  if (!std::isfinite(log_target)) log_target = 0;
  const float log = log_factor.Follow(log_target, dt_s, tau_s);
  if (log_target == 0 && std::abs(log) < tuning::kStrideSettled) log_factor.Start(0);
  return log_factor.value() == 0 ? 1.0F : std::exp(log_factor.value());
}

}  // namespace

void Stride::Scale(const GaitChange& change, float dt_s, float settle_s) noexcept {
  const float tau_s = tuning::kStrideFactor_s + settle_s;
  factor_ = FollowFactor(log_factor_, change.log_way, dt_s, tau_s);
  cadence_ = FollowFactor(log_cadence_, change.log_cadence, dt_s, tau_s);
  gained_m_ += (static_cast<double>(factor_) - 1) * step_m_.cast<double>();
  travel_.moved_m = gained_m_.cast<float>();
  travel_.longer = factor_ - 1;
  travel_.along = velocity_mps_ / std::max(speed_mps(), tuning::kStrideStanding_mps);
}

// The gained offset is added to the performer's own place, even if nothing is styled.
void Stride::Carry(Checkpoint& c) noexcept {
  c(gained_m_, last_m_, step_m_, velocity_mps_, seen_, placed_, log_factor_, log_cadence_, factor_,
    cadence_, travel_);
  if (!c.reads() || !c.ok()) return;
  const auto finite = [](float value) { return std::isfinite(value); };
  // The next value shows its speed. Beyond it the factor would overflow.
  const auto bounded = [](CriticallyDamped log) {
    constexpr float kMost = 10;
    return std::abs(log.value()) <= kMost && std::abs(log.Follow(0, 0.01F, 1)) <= kMost;
  };
  const bool near = gained_m_.allFinite() && gained_m_.norm() <= kFarthest_m &&
                    travel_.moved_m.isApprox(gained_m_.cast<float>());
  const bool sound = last_m_.allFinite() && step_m_.allFinite() && velocity_mps_.allFinite() &&
                     seen_ >= 0 && seen_ <= 1 && bounded(log_factor_) && bounded(log_cadence_) &&
                     finite(factor_) && finite(cadence_) && finite(travel_.longer) &&
                     travel_.along.allFinite();
  if (!near || !sound) c.Refuse();
}

namespace {

// The logarithm of x / y; 0 if either was not measured.
float LogRatio(float x, float y) noexcept { return x > 0 && y > 0 ? std::log(x / y) : 0; }

// The performer's speed in relation to the speeds of their own style.
struct Gait {
  Gait(const net::StyleInfo& own, const net::StyleInfo& neutral, float speed_mps) noexcept;

  float moving = 0, running = 0;          // 0 .. 1: not standing; a run, not a walk
  float faster_walk = 0, faster_run = 0;  // logarithms: over the style's own mean speed
};

Gait::Gait(const net::StyleInfo& own, const net::StyleInfo& neutral, float speed_mps) noexcept {
  // A gait that the style lacks is replaced by neutral's.
  const float walk_mps = own.walk_mps > 0 ? own.walk_mps : neutral.walk_mps;
  const float run_mps =
      std::max(own.run_mps > 0 ? own.run_mps : neutral.run_mps, tuning::kStrideLeastRun * walk_mps);
  moving = SmoothStep(speed_mps, tuning::kStrideStands * walk_mps, tuning::kStrideWalks * walk_mps);
  const auto at = [&](float share) { return walk_mps + share * (run_mps - walk_mps); };
  running = SmoothStep(speed_mps, at(tuning::kStrideRunBegins), at(tuning::kStrideRuns));
  const auto faster = [speed_mps](float usual_mps) {
    const float most = std::log(tuning::kStrideUnusual);
    return std::clamp(std::log(std::max(speed_mps, 1e-3F) / usual_mps), -most, most);
  };
  faster_walk = faster(walk_mps);
  faster_run = faster(run_mps);
}

// A figure of each style, from which a change of gait is computed.
struct Figure {
  float net::StyleInfo::*walk;
  float net::StyleInfo::*run;
  float own_share;    // of the performer's deviation from the usual speed that is taken back
  float least, most;  // factor
};
constexpr Figure kSpeed{&net::StyleInfo::walk_mps, &net::StyleInfo::run_mps,
                        tuning::kStrideOwnSpeed, tuning::kLeastStride, tuning::kMostStride};
constexpr Figure kCadence{&net::StyleInfo::walk_spm, &net::StyleInfo::run_spm, 0,
                          tuning::kLeastCadence, tuning::kMostCadence};

// The logarithm of the factor of `figure` that the active styles have at a speed.
float LogFactor(const Figure& figure, const net::Styles& styles, const Mixer& mixer,
                float speed_mps) noexcept {
  if (styles.empty() || styles[0].walk_mps <= 0 || styles[0].run_mps <= 0) return 0;
  const net::StyleInfo& neutral = styles[0];
  const auto info = [&styles](int style) -> const net::StyleInfo& {
    const bool known = style >= 0 && static_cast<std::size_t>(style) < styles.size();
    return styles[known ? static_cast<std::size_t>(style) : 0];
  };
  const net::StyleInfo& own = info(mixer.input_style());
  const Gait gait(own, neutral, speed_mps);
  const auto blend = [&gait](float walk, float run) { return walk + gait.running * (run - walk); };
  const auto change = [&](const net::StyleInfo& style) {
    return blend(LogRatio(style.*figure.walk, neutral.*figure.walk),
                 LogRatio(style.*figure.run, neutral.*figure.run));
  };
  const float faster = blend(gait.faster_walk, gait.faster_run);
  float log = -mixer.presence() * change(own);
  for (const net::StyleWeight& style : mixer.in_force()) {
    const net::StyleInfo& target = info(style.style);
    if (target.*figure.walk <= 0 && target.*figure.run <= 0) continue;
    log += style.weight * (change(target) - figure.own_share * faster);
  }
  return gait.moving * std::clamp(log, std::log(figure.least), std::log(figure.most));
}

}  // namespace

float LogStride(const net::Styles& styles, const Mixer& mixer, float speed_mps) noexcept {
  if (mixer.stride() == 0) return 0;
  return mixer.stride() * LogFactor(kSpeed, styles, mixer, speed_mps);
}

float LogCadence(const net::Styles& styles, const Mixer& mixer, float speed_mps) noexcept {
  return LogFactor(kCadence, styles, mixer, speed_mps);
}

GaitChange ChangeOfGait(const net::Styles& styles, const Mixer& mixer, bool own_cadence,
                        float speed_mps) noexcept {
  const float log_speed = LogStride(styles, mixer, speed_mps);
  if (!own_cadence) return {log_speed, 0};
  const float log_cadence = LogCadence(styles, mixer, speed_mps);
  const float log_step = log_speed - mixer.stride() * log_cadence;
  return {std::clamp(log_step, std::log(tuning::kLeastStride), std::log(tuning::kMostStride)),
          log_cadence};
}

}  // namespace styled::stylist
