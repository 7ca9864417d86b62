#include "model/synthetic/feet.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "model/body/heading.h"
#include "model/synthetic/motion_tables.h"
#include "model/synthetic/synthesis.h"

namespace styled::synthetic {
namespace {

using body::Quat;
using body::Vec3;
using Eigen::Vector2d;

constexpr double kRelease_s = 0.10;    // time constant with which an offset is released
constexpr double kLongest_m = 0.22;    // the longest offset
constexpr double kStepFrom_m = 0.035;  // a standing foot farther off takes a small step
constexpr double kStepFrom_rad = 0.20;
constexpr double kStep_s = 0.55, kStepHeight_m = 0.035;
constexpr double kLift_s = 0.05;
constexpr float kStretch = 0.99F, kSoft_m = 0.006F;  // of a leg that reaches for its held foot

struct Leg {
  int upper, lower, foot, toes;
};
constexpr std::array<Leg, 2> kLegs{
    {{body::kLeftUpperLeg, body::kLeftLowerLeg, body::kLeftFoot, body::kLeftToes},
     {body::kRightUpperLeg, body::kRightLowerLeg, body::kRightFoot, body::kRightToes}}};

Vector2d Toe(const body::WorldPose& world, const Leg& leg) {
  const Vec3& toe = world.positions_m[leg.toes];
  return {toe.x(), toe.z()};
}

// The foot's heading from its sideways axis, which is defined for any pitch of the foot.
double FootYaw(const body::WorldPose& world, const Leg& leg) {
  const Vec3 sideways = world.rotations[leg.foot] * Vec3::UnitX();
  return std::atan2(-sideways.z(), sideways.x());
}

// 1 for a foot on the floor; falls with height, for a foot that a blend counts as standing while it
// is in the air.
double Near(double height_m) {
  constexpr double kNear_m = 0.025;
  return 1 / (1 + height_m * height_m / (kNear_m * kNear_m));
}

double Wrap(double angle) { return std::remainder(angle, 2 * std::numbers::pi); }

// A foot that is held too far from its place lifts and returns to it.
void AdvanceStep(FootState& foot, double dt_s) {
  foot.step = std::min(1.0, foot.step + dt_s / kStep_s);
  const double left = 1 - SmootherStep(foot.step);
  foot.offset_m = left * foot.step_offset_m;
  foot.yaw_rad = left * foot.step_yaw_rad;
  if (foot.step >= 1) foot.stepping = false;
}

void BeginStepIfDue(const FeetInput& input, double dt_s, FeetState& state) {
  const bool stands = input.standing > 0.995 && input.contact[0] > 0.99 && input.contact[1] > 0.99;
  const bool busy = state.feet[0].stepping || state.feet[1].stepping;
  state.rested_s = stands && !busy ? state.rested_s + dt_s : 0;
  if (state.rested_s < 0.15) return;
  const auto farness = [](const FootState& foot) {
    return std::max(foot.offset_m.norm() / kStepFrom_m, std::abs(foot.yaw_rad) / kStepFrom_rad);
  };
  FootState& foot =
      farness(state.feet[0]) >= farness(state.feet[1]) ? state.feet[0] : state.feet[1];
  if (farness(foot) < 1) return;
  foot.stepping = true;
  foot.step = 0;
  foot.step_offset_m = foot.offset_m;
  foot.step_yaw_rad = foot.yaw_rad;
}

// IK of a leg of two equal bones: moves the ankle from `ankle_was` to `ankle`; the knee keeps its
// axis.
void Reach(const Leg& leg, const Vec3& hip, const Vec3& ankle_was, const Vec3& ankle, Quat& upper,
           Quat& lower) {
  const float l1 = body::Offset(leg.lower).norm(), l2 = body::Offset(leg.foot).norm();
  const float was = (ankle_was - hip).norm();
  float reach = (ankle - hip).norm();
  if (reach > was) {
    // Approach the stretched leg smoothly, without reaching it: near it a small change of reach
    // bends the knee much. A leg that the motion itself stretches farther is left as it is.
    const float room = kSoft_m * std::log1p(std::exp((kStretch * (l1 + l2) - was) / kSoft_m));
    reach = was + room * std::tanh((reach - was) / room);
  }
  const auto flexion = [l1, l2](float distance) {
    const float cosine = (l1 * l1 + l2 * l2 - distance * distance) / (2 * l1 * l2);
    return std::numbers::pi_v<float> - std::acos(std::clamp(cosine, -1.0F, 1.0F));
  };
  const Vec3 axis = upper * Vec3::UnitX();
  lower = Quat(Eigen::AngleAxisf(flexion(reach) - flexion(was), axis)) * lower;
  const Vec3 now = upper * body::Offset(leg.lower) + lower * body::Offset(leg.foot);
  const Quat swing = body::ShortestTurn(now, ankle - hip);
  upper = (swing * upper).normalized();
  lower = (swing * lower).normalized();
}

}  // namespace

void AdvanceFeet(const FeetInput& input, const body::WorldPose& world, double dt_s,
                 FeetState& state) noexcept {
  double contacts = 1e-6, error = 0;
  for (int side = 0; side < 2; ++side) {
    FootState& foot = state.feet[side];
    const Leg& leg = kLegs[side];
    const Vector2d toe_m = input.path_m + Toe(world, leg);
    const double foot_yaw_rad = FootYaw(world, leg);
    const double c = input.contact[side];
    if (foot.started && foot.stepping) {
      AdvanceStep(foot, dt_s);
    } else if (foot.started) {
      const double give_back = (1 - c) * dt_s / kRelease_s;
      const Vector2d drift = toe_m - foot.toe_m;
      const double far = std::min(1.0, foot.offset_m.squaredNorm() / (kLongest_m * kLongest_m));
      foot.offset_m -= c * (1 - far) * drift + give_back * foot.offset_m;
      foot.yaw_rad -= c * Wrap(foot_yaw_rad - foot.foot_yaw_rad) + give_back * foot.yaw_rad;
      foot.yaw_rad = std::clamp(foot.yaw_rad, -0.8, 0.8);
    }
    foot.toe_m = toe_m;
    foot.foot_yaw_rad = foot_yaw_rad;
    foot.started = true;
    const double below_m = kToeHeight_m - world.positions_m[leg.toes].y();
    const double weight = c * c * Near(below_m);
    contacts += weight;
    error += weight * below_m;
  }
  // The body's height follows the feet that carry it, critically damped. During the flight of a run
  // `grip` is 0, and no force acts.
  const double grip = std::min(1.0, contacts);
  const double wanted = error / contacts;
  const double acceleration =
      grip * (wanted - state.lift_m) / (kLift_s * kLift_s) - 2 * state.lift_speed_m / kLift_s;
  state.lift_speed_m += acceleration * dt_s;
  state.lift_m += state.lift_speed_m * dt_s;
  BeginStepIfDue(input, dt_s, state);
}

void ApplyFeet(const FeetInput& input, const FeetState& state, const body::WorldPose& world,
               body::Pose& pose) noexcept {
  const Quat hips = world.rotations[body::kHips];
  for (int side = 0; side < 2; ++side) {
    const FootState& foot = state.feet[side];
    const Leg& leg = kLegs[side];
    const Vec3& hip = world.positions_m[leg.upper];
    const Vec3& ankle_was = world.positions_m[leg.foot];
    Vec3 toe = world.positions_m[leg.toes];
    const Vec3 toe_to_ankle = ankle_was - toe;
    // The distance that is left between this toe and the floor after the body's lift.
    const double below_m = kToeHeight_m - state.lift_m - static_cast<double>(toe.y());
    toe.y() += static_cast<float>(input.contact[side] * Near(below_m) * below_m);
    if (foot.stepping) {
      const double s = foot.step * (1 - foot.step);
      toe.y() += static_cast<float>(kStepHeight_m * 64 * s * s * s);
    }
    toe.x() += static_cast<float>(foot.offset_m.x());
    toe.z() += static_cast<float>(foot.offset_m.y());
    const Quat turn = body::Yaw(static_cast<float>(foot.yaw_rad));
    Quat upper = world.rotations[leg.upper], lower = world.rotations[leg.lower];
    Reach(leg, hip, ankle_was, toe + turn * toe_to_ankle, upper, lower);
    pose.rotations[leg.upper] = (hips.conjugate() * upper).normalized();
    pose.rotations[leg.lower] = (upper.conjugate() * lower).normalized();
    pose.rotations[leg.foot] = (lower.conjugate() * turn * world.rotations[leg.foot]).normalized();
  }
  pose.hips_position_m.y() += static_cast<float>(state.lift_m);
}

}  // namespace styled::synthetic
