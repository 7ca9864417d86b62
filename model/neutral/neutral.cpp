#include "model/neutral/neutral.h"

#include <algorithm>
#include <cmath>

#include "model/base/smooth.h"
#include "model/body/heading.h"
#include "model/body/parts.h"
#include "model/neutral/tuning.h"

namespace styled::neutral {
namespace {

using body::kJointCount;
using body::Pose;
using body::Quat;
using body::Vec3;
using body::WorldPose;

// The unit quaternion of a weighted sum of two rotations, along the shorter arc.
Quat Blend(const Quat& a, const Quat& b, float share) noexcept {
  const float sign = a.dot(b) < 0 ? -1.0F : 1.0F;
  Quat blend;
  blend.coeffs() = (1 - share) * a.coeffs() + (share * sign) * b.coeffs();
  return blend.normalized();
}

bool IsArm(int joint) { return joint >= body::kLeftShoulder && joint <= body::kRightHand; }

// The largest turn of a joint, and the cosine of its half.
struct Bound {
  explicit Bound(float rad) : most_rad(rad), half_cosine(std::cos(rad / 2)) {}
  float most_rad, half_cosine;
};

// Made before the program begins: no frame waits for it.
const Bound kCollar(tuning::kMostCollar_rad), kArm(tuning::kMostArm_rad),
    kTrunk(tuning::kMostTrunk_rad), kLeg(tuning::kMostLeg_rad);

const Bound& BoundOf(int joint) noexcept {
  if (joint == body::kLeftShoulder || joint == body::kRightShoulder) return kCollar;
  if (IsArm(joint)) return kArm;
  return joint < body::kLeftShoulder ? kTrunk : kLeg;
}

// `turn`, limited to the largest angle that counts as a carriage.
Quat Bounded(const Quat& turn, int joint) noexcept {
  const Bound& bound = BoundOf(joint);
  if (std::abs(turn.w()) >= bound.half_cosine) return turn;
  const Vec3 vector = body::Log(turn);
  return body::Exp(vector * (bound.most_rad / vector.norm()));
}

// How upright a body is, and on how straight legs, 0 .. 1.
float Upright(const WorldPose& world) noexcept {
  const Vec3 trunk = world.positions_m[body::kNeck] - world.positions_m[body::kHips];
  const float up = trunk.y() / std::max(trunk.norm(), 1e-3F);
  const float height_m = world.positions_m[body::kHips].y() - body::LowestFoot_m(world);
  return SmoothStep(up, tuning::kBowed, tuning::kUpright) *
         SmoothStep(height_m, tuning::kCrouches_m, tuning::kStandsUp_m);
}

// How near each other the feet are, 0 .. 1.
float FeetTogether(const WorldPose& world) noexcept {
  const Vec3 apart_m = world.positions_m[body::kLeftFoot] - world.positions_m[body::kRightFoot];
  return 1 -
         SmoothStep(std::hypot(apart_m.x(), apart_m.z()), tuning::kTogether_m, tuning::kApart_m);
}

// How much a part of an arm, from one joint to the next, hangs, 0 .. 1.
float Hangs(const WorldPose& world, int from, int to) noexcept {
  const Vec3 bone = world.positions_m[static_cast<std::size_t>(to)] -
                    world.positions_m[static_cast<std::size_t>(from)];
  return SmoothStep(-bone.y() / std::max(bone.norm(), 1e-3F), tuning::kArmLifted,
                    tuning::kArmHangs);
}

}  // namespace

float Ordinary::Of(int joint) const noexcept {
  switch (body::PartOf(joint)) {
    case body::Part::kLeftArm:
      return left_arm;
    case body::Part::kRightArm:
      return right_arm;
    default:
      return body;
  }
}

Ordinary JudgeOrdinary(const WorldPose& world, float speed_mps,
                       const Reference& reference) noexcept {
  Ordinary ordinary;
  ordinary.heading_rad = body::Heading_rad(world);
  ordinary.moving = SmoothStep(speed_mps, tuning::kStands * reference.walk_mps,
                               tuning::kWalks * reference.walk_mps);
  const float run_mps = std::max(reference.run_mps, tuning::kLeastRun * reference.walk_mps);
  const auto at = [&](float share) {
    return reference.walk_mps + share * (run_mps - reference.walk_mps);
  };
  ordinary.running = SmoothStep(speed_mps, at(tuning::kRunBegins), at(tuning::kRuns));
  // People who walk bend their elbows; people who stand with bent elbows gesture or are on guard.
  const auto mixed = [&](float standing, float moving) {
    return standing + ordinary.moving * (moving - standing);
  };
  const auto arm = [&](int shoulder, int elbow, int hand) {
    const float upper = Hangs(world, shoulder, elbow);
    return mixed(upper * Hangs(world, elbow, hand), upper);
  };
  ordinary.left_arm = arm(body::kLeftUpperArm, body::kLeftLowerArm, body::kLeftHand);
  ordinary.right_arm = arm(body::kRightUpperArm, body::kRightLowerArm, body::kRightHand);
  ordinary.body = Upright(world) * mixed(FeetTogether(world), 1) *
                  std::min(ordinary.left_arm, ordinary.right_arm);
  ordinary.left_arm *= ordinary.body;
  ordinary.right_arm *= ordinary.body;
  return ordinary;
}

void Neutral::Follow(const Pose& input, float dt_s, bool learns,
                     const Reference& reference) noexcept {
  WorldPose world;
  body::ForwardKinematics(input, world);
  velocity_.Follow(input.hips_position_m, dt_s);
  const Ordinary ordinary = JudgeOrdinary(world, velocity_.mps().norm(), reference);
  heading_rad_ = ordinary.heading_rad;
  const bool learned = learns && !calibrated_ && ordinary.body > 0 && velocity_.known();
  if (learned) Learn(input, ordinary, std::min(dt_s, tuning::kLongest_s), reference);
  if (reference.gaits) {
    tracker_.Follow(world, ordinary.heading_rad, velocity_.mps(), dt_s);
    const float run = gait::RunShare(tracker_.phase(), velocity_.mps().norm());
    running_ += DecayShare(dt_s, tuning::kRunFade_s) * (run - running_);
    FollowGait(input, learned ? ordinary.body : 0, std::min(dt_s, tuning::kLongest_s), reference);
  }
  if (calibrates_s_ > 0) {
    calibrates_s_ = std::max(0.0F, calibrates_s_ - dt_s);
    calibrated_ = calibrates_s_ == 0 && seconds_[kBody] >= tuning::kEnough_s;
  }
  const float share = DecayShare(dt_s, tuning::kFade_s);
  for (std::size_t joint = 0; joint < kJointCount; ++joint) {
    used_.rotations[joint] = Blend(used_.rotations[joint], learned_.rotations[joint], share);
  }
}

// The mean of the seconds so far and of `dt_s` more.
void Neutral::Learn(const Pose& input, const Ordinary& ordinary, float dt_s,
                    const Reference& reference) noexcept {
  const Quat heading_from_world = body::Yaw(-heading_rad_);
  for (int joint = 0; joint < kJointCount; ++joint) {
    const auto j = static_cast<std::size_t>(joint);
    const float new_s = dt_s * ordinary.Of(joint);
    if (!(new_s > 0)) continue;
    const float known_s = tuning::kBelieved_s + seconds_[IsArm(joint) ? kArms : kBody];
    const Quat own =
        joint == body::kHips ? heading_from_world * input.rotations[j] : input.rotations[j];
    const Quat moving =
        Blend(reference.walking.rotations[j], reference.running.rotations[j], ordinary.running);
    const Quat usual = Blend(reference.standing.rotations[j], moving, ordinary.moving);
    Quat& turn = learned_.rotations[j];
    turn = Bounded(Blend(turn, usual * own.conjugate(), new_s / (known_s + new_s)), joint);
  }
  const auto add = [](float& seconds, float more) {
    seconds = std::min(seconds + more, tuning::kRemembered_s);
  };
  add(seconds_[kBody], dt_s * ordinary.body);
  add(seconds_[kArms], dt_s * std::min(ordinary.left_arm, ordinary.right_arm));
}

namespace {

// A series about the rotations `from`, about `to` instead.
gait::Series MovedTo(const gait::Series& series, const gait::Rotations& from,
                     const gait::Rotations& to) {
  gait::Series moved = series;
  for (int joint = 0; joint < kJointCount; ++joint) {
    const auto j = static_cast<std::size_t>(joint);
    const Quat mean = from[j] * body::Exp(series.col(0).segment<3>(3 * joint));
    moved.col(0).segment<3>(3 * joint) = body::Log(to[j].conjugate() * mean);
  }
  return moved;
}

// The gait of many people with this performer's carriage: the same pattern about their mean.
gait::Series PriorOf(const gait::Curve& gait, const Carriage& turns, const Carriage& usual) {
  gait::Series prior = gait.series;
  for (int joint = 0; joint < kJointCount; ++joint) {
    const auto j = static_cast<std::size_t>(joint);
    const Quat own = turns.rotations[j].conjugate() * usual.rotations[j];
    prior.col(0).segment<3>(3 * joint) += body::Log(gait.mean[j].conjugate() * own);
  }
  return prior;
}

}  // namespace

// A sample of the gait now and then, for walking and running in their shares, and now and then the
// curves of all samples.
void Neutral::FollowGait(const Pose& input, float learned, float dt_s,
                         const Reference& reference) noexcept {
  const Gaits& usual = *reference.gaits;
  sample_s_ += dt_s;
  if (sample_s_ >= tuning::kSample_s) {
    const float seconds = sample_s_ * learned * phase().confidence;
    sample_s_ = 0;
    stale_ = stale_ || learned > 0;
    if (seconds > 0) {
      const gait::Terms terms = gait::TermsAt(phase().phase_rad);
      const gait::Rotations own = gait::HeadingRelative(input, heading_rad_);
      const auto learn = [&](OwnGait& gait, const gait::Curve& mean, float share) {
        if (share > 0) gait.Learn(terms, gait::VectorsAbout(mean.mean, own), share * seconds);
      };
      learn(walk_, usual.walking, 1 - running_);
      learn(run_, usual.running, running_);
    }
  }
  solved_s_ += dt_s;
  if (!stale_ || solved_s_ < tuning::kSolved_s) return;
  SolveGaits(reference);
}

void Neutral::SolveGaits(const Reference& reference) noexcept {
  const Gaits& usual = *reference.gaits;
  walk_.Solve(PriorOf(usual.walking, learned_, reference.walking));
  run_.Solve(PriorOf(usual.running, learned_, reference.running));
  stale_ = false;
  solved_s_ = 0;
}

void Neutral::RemoveCarriage(const Pose& input, Pose& out) const noexcept {
  out.hips_position_m = input.hips_position_m;
  for (std::size_t joint = 0; joint < kJointCount; ++joint) {
    out.rotations[joint] = (used_.rotations[joint] * input.rotations[joint]).normalized();
  }
  const Quat world_from_heading = body::Yaw(heading_rad_);
  out.rotations[body::kHips] = (world_from_heading * used_.rotations[body::kHips] *
                                world_from_heading.conjugate() * input.rotations[body::kHips])
                                   .normalized();
}

// An invalid rotation would stay in every frame that follows.
void Neutral::Carry(Checkpoint& c) noexcept {
  c(learned_, used_, seconds_, calibrates_s_, heading_rad_, velocity_, tracker_, walk_, run_,
    running_, sample_s_, solved_s_, stale_, calibrated_);
  if (!c.reads() || !c.ok()) return;
  constexpr float kTolerance = 1e-3F;
  const auto is_turn = [](const Quat& turn) { return std::abs(turn.norm() - 1) <= kTolerance; };
  const auto is_time = [](float seconds) {
    return seconds >= 0 && seconds <= tuning::kRemembered_s;
  };
  if (!std::all_of(learned_.rotations.begin(), learned_.rotations.end(), is_turn) ||
      !std::all_of(used_.rotations.begin(), used_.rotations.end(), is_turn) ||
      !std::all_of(seconds_.begin(), seconds_.end(), is_time) || !(calibrates_s_ >= 0) ||
      !std::isfinite(calibrates_s_) || !std::isfinite(heading_rad_) ||
      !(running_ >= 0 && running_ <= 1) || !(sample_s_ >= 0 && std::isfinite(sample_s_)) ||
      !(solved_s_ >= 0 && std::isfinite(solved_s_))) {
    c.Refuse();
  }
}

float Neutral::learned() const { return seconds_[kBody] / (seconds_[kBody] + tuning::kBelieved_s); }

void Neutral::Forget() noexcept {
  learned_ = Carriage();
  seconds_.fill(0);
  walk_ = run_ = OwnGait();
  stale_ = true;
  calibrated_ = false;
  calibrates_s_ = 0;
}

void Neutral::Calibrate(float seconds) noexcept {
  Forget();
  calibrates_s_ = seconds;
}

void Neutral::Mirror() noexcept {
  learned_.rotations = gait::Mirrored(learned_.rotations);
  used_.rotations = gait::Mirrored(used_.rotations);
  tracker_.Mirror();
  walk_.Mirror();
  run_.Mirror();
}

Known Mirrored(const Known& known) {
  Known mirrored = known;
  mirrored.own.rotations = gait::Mirrored(known.own.rotations);
  mirrored.walking = gait::Mirrored(known.walking);
  mirrored.running = gait::Mirrored(known.running);
  return mirrored;
}

Known Neutral::Tell(const Reference& reference) const noexcept {
  Known known;
  known.body_s = seconds_[kBody];
  known.arms_s = seconds_[kArms];
  known.calibrated = calibrated_;
  for (std::size_t joint = 0; joint < kJointCount; ++joint) {
    known.own.rotations[joint] =
        (learned_.rotations[joint].conjugate() * reference.walking.rotations[joint]).normalized();
  }
  if (!reference.gaits) return known;
  const auto tell = [&known](const OwnGait& gait, const gait::Curve& usual, gait::Series& series,
                             float& seconds) {
    series = MovedTo(gait.series(), usual.mean, known.own.rotations);
    seconds = gait.seconds();
  };
  tell(walk_, reference.gaits->walking, known.walking, known.walking_s);
  tell(run_, reference.gaits->running, known.running, known.running_s);
  return known;
}

void Neutral::Know(const Known& known, const Reference& reference) noexcept {
  Forget();
  for (std::size_t joint = 0; joint < kJointCount; ++joint) {
    const Quat turn =
        (reference.walking.rotations[joint] * known.own.rotations[joint].conjugate()).normalized();
    learned_.rotations[joint] = Bounded(turn, static_cast<int>(joint));
  }
  seconds_ = {known.body_s, known.arms_s};
  for (float& seconds : seconds_) seconds = std::clamp(seconds, 0.0F, tuning::kRemembered_s);
  calibrated_ = known.calibrated;
  used_ = learned_;
  if (!reference.gaits) return;
  const auto know = [&known](const gait::Series& series, float seconds, const gait::Curve& usual,
                             OwnGait& gait) {
    gait.Know(MovedTo(series, known.own.rotations, usual.mean), seconds);
  };
  know(known.walking, known.walking_s, reference.gaits->walking, walk_);
  know(known.running, known.running_s, reference.gaits->running, run_);
  SolveGaits(reference);
}

}  // namespace styled::neutral
