#include "model/feet/two_bone_ik.h"

#include <algorithm>
#include <cmath>

#include "model/base/smooth.h"
#include "model/feet/tuning.h"

namespace styled::feet {
namespace {

constexpr float kTiny = 1e-6F;

// The axis about which the knee bends now. Its component along the anatomical hinge is kept
// positive, so that the axis does not flip when the leg passes through straight, nor when a style
// bends the knee backwards.
Vec3 BendAxis(const TwoBones& limb, const Vec3& thigh, const Vec3& shank) {
  const Vec3 bend = thigh.normalized().cross(shank.normalized());  // length: sin(bend)
  const float along = bend.dot(limb.hinge);
  float kept = along;
  if (along < tuning::kNearlyStraight) {
    const float u =
        std::max(0.0F, (along + tuning::kNearlyStraight) / (2 * tuning::kNearlyStraight));
    kept = tuning::kNearlyStraight * (0.25F + 0.75F * u * u * u);
  }
  const Vec3 axis = bend + (kept - along) * limb.hinge;
  const float length = axis.norm();
  return length > kTiny ? Vec3(axis / length) : limb.hinge;
}

// `over`: by how much the knee is beyond straight now. The target flexion may be reached with the
// knee bent either way. From 2 * over on it is bent the right way; up to `over` it stays beyond
// straight; between, where the reach hardly depends on the angle, a straight line joins the two
// without a jump.
float Flexion(float wanted, float over) {
  if (wanted >= 2 * over) return wanted;
  return wanted >= over ? 3 * wanted - 4 * over : -wanted;
}

}  // namespace

KneeTurn KneeFor(const TwoBones& limb, float distance) noexcept {
  KneeTurn knee;
  const Vec3 thigh = limb.knee - limb.hip;
  const Vec3 shank = limb.ankle - limb.knee;
  const float a = thigh.norm();
  const float b = shank.norm();
  if (a < kTiny || b < kTiny) return knee;
  const float now = (limb.ankle - limb.hip).norm();
  const float farthest = std::max(tuning::kOutermost * (a + b), now);
  const float nearest = std::min(std::abs(a - b) + 1e-3F * (a + b), now);
  distance = std::clamp(distance, nearest, farthest);

  // Turning the shank by x about the unit axis n gives
  //
  //   |ankle - hip|^2 = a^2 + b^2 + 2 (A + B cos x + C sin x),
  //
  // A = (thigh.n)(n.shank), B = thigh.shank - A, C = thigh.(n x shank). With B = R cos(s), C = R
  // sin(s) it is solved by x = s +- acos(((|ankle - hip|^2 - a^2 - b^2) / 2 - A) / R).
  const Vec3 n = BendAxis(limb, thigh, shank);
  const float along = thigh.dot(n) * n.dot(shank);
  const float cosine = thigh.dot(shank) - along;
  const float sine = thigh.dot(n.cross(shank));
  const float amplitude = std::hypot(cosine, sine);
  const auto flexion = [&](float apart) {  // from straight, about n
    const float level = 0.5F * (apart * apart - a * a - b * b) - along;
    return std::acos(std::clamp(level / std::max(amplitude, kTiny), -1.0F, 1.0F));
  };
  knee.axis = n;
  knee.bend_rad = -std::atan2(sine, cosine);
  if (std::abs(distance - now) > kTiny * (a + b)) {
    knee.turn_rad = Flexion(flexion(distance), std::max(0.0F, -knee.bend_rad)) - knee.bend_rad;
  }
  return knee;
}

TwoBoneTurns Turn(const TwoBones& limb, const Vec3& axis, float turn_rad,
                  const Vec3& target) noexcept {
  TwoBoneTurns turns;
  const Vec3 wish = target - limb.hip;
  const float wanted = wish.norm();
  if (wanted < kTiny) {
    turns.missed = (target - limb.ankle).norm();
    return turns;
  }
  if (turn_rad != 0) turns.lower = Quat(Eigen::AngleAxisf(turn_rad, axis));
  const Vec3 reached = limb.knee - limb.hip + turns.lower * (limb.ankle - limb.knee);
  turns.missed = std::abs(wanted - reached.norm());
  // Not body::ShortestTurn: only inlined does it round as in every output so far.
  if (reached.norm() > kTiny) turns.upper = Quat::FromTwoVectors(reached, wish).normalized();
  return turns;
}

TwoBoneTurns ReachFor(const TwoBones& limb, const Vec3& target) noexcept {
  const KneeTurn knee = KneeFor(limb, (target - limb.hip).norm());
  return Turn(limb, knee.axis, knee.turn_rad, target);
}

float SoftReach(float wanted, float length, float corner) noexcept {
  return length - SoftPositive(length - wanted, corner);
}

}  // namespace styled::feet
