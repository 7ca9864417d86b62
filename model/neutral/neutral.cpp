#include "model/neutral/neutral.h"

#include <algorithm>
#include <cmath>
#include <utility>

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

Ordinary JudgeOrdinary(const Pose& pose, float speed_mps, const Reference& reference) noexcept {
  WorldPose world;
  body::ForwardKinematics(pose, world);
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

// The speed of the hips over the floor, averaged over a step. The window is at most as long as the
// session, so that a session that begins in mid-stride does not begin with the speed of standing.
float Neutral::Speed_mps(const Vec3& hips_m, float dt_s) noexcept {
  const Vec3 step_m(hips_m.x() - last_hips_m_.x(), 0, hips_m.z() - last_hips_m_.z());
  last_hips_m_ = hips_m;
  const bool first = !std::exchange(placed_, true);
  if (first || step_m.norm() > tuning::kFastest_mps * dt_s) {
    seen_ = 0;  // the former velocity is useless
    return velocity_mps_.norm();
  }
  const float share = DecayShare(dt_s, tuning::kSpeed_s);
  seen_ += share * (1 - seen_);
  if (seen_ > 0 && dt_s > 0) velocity_mps_ += share / seen_ * (step_m / dt_s - velocity_mps_);
  return velocity_mps_.norm();
}

void Neutral::Follow(const Pose& input, float dt_s, bool learns,
                     const Reference& reference) noexcept {
  const float speed_mps = Speed_mps(input.hips_position_m, dt_s);
  const Ordinary ordinary = JudgeOrdinary(input, speed_mps, reference);
  heading_rad_ = ordinary.heading_rad;
  if (learns && !calibrated_ && ordinary.body > 0 && seen_ > 0) {
    Learn(input, ordinary, std::min(dt_s, tuning::kLongest_s), reference);
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
  c(learned_, used_, seconds_, calibrates_s_, heading_rad_, last_hips_m_, velocity_mps_, seen_,
    placed_, calibrated_);
  if (!c.reads() || !c.ok()) return;
  constexpr float kTolerance = 1e-3F;
  const auto is_turn = [](const Quat& turn) { return std::abs(turn.norm() - 1) <= kTolerance; };
  const auto is_time = [](float seconds) {
    return seconds >= 0 && seconds <= tuning::kRemembered_s;
  };
  if (!std::all_of(learned_.rotations.begin(), learned_.rotations.end(), is_turn) ||
      !std::all_of(used_.rotations.begin(), used_.rotations.end(), is_turn) ||
      !std::all_of(seconds_.begin(), seconds_.end(), is_time) || !(calibrates_s_ >= 0) ||
      !std::isfinite(calibrates_s_) || !std::isfinite(heading_rad_) || !last_hips_m_.allFinite() ||
      !velocity_mps_.allFinite() || !(seen_ >= 0 && seen_ <= 1)) {
    c.Refuse();
  }
}

float Neutral::learned() const { return seconds_[kBody] / (seconds_[kBody] + tuning::kBelieved_s); }

void Neutral::Forget() noexcept {
  learned_ = Carriage();
  seconds_.fill(0);
  calibrated_ = false;
  calibrates_s_ = 0;
}

void Neutral::Calibrate(float seconds) noexcept {
  Forget();
  calibrates_s_ = seconds;
}

Known Neutral::Tell(const Reference& reference) const noexcept {
  Known known{{}, seconds_[kBody], seconds_[kArms], calibrated_};
  for (std::size_t joint = 0; joint < kJointCount; ++joint) {
    known.own.rotations[joint] =
        (learned_.rotations[joint].conjugate() * reference.walking.rotations[joint]).normalized();
  }
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
}

}  // namespace styled::neutral
