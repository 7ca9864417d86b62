#include "model/stylist/guard.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "model/stylist/grounding.h"
#include "model/stylist/tuning.h"

namespace styled::stylist {
namespace {

// Comparisons are written so that NaN fails them.
bool AreUnit(std::span<const body::Quat> rotations) noexcept {
  return std::all_of(rotations.begin(), rotations.end(), [](const body::Quat& rotation) {
    return std::abs(rotation.squaredNorm() - 1) < tuning::kOutputUnitTolerance;
  });
}

bool AreFinite(std::span<const float> values) noexcept {
  return std::all_of(values.begin(), values.end(),
                     [](float value) { return std::isfinite(value); });
}

bool IsNear(const body::Vec3& place, const body::Vec3& own, float most) noexcept {
  const float apart = (place - own).cwiseAbs().maxCoeff();
  return place.allFinite() && apart <= most + tuning::kFarRounding * own.cwiseAbs().maxCoeff();
}

bool IsSound(const net::Decoded& decoded) noexcept {
  return AreUnit(decoded.rotations) && AreFinite(decoded.velocities_m_s) &&
         std::isfinite(decoded.hips_height_m);
}

}  // namespace

// Velocities and height are not part of the pose, but they reveal a non-finite state: normalization
// turns an invalid rotation into the identity.
bool IsSound(const net::Prediction& step) noexcept {
  return IsSound(step.reconstruction) && IsSound(step.styled);
}

bool IsSound(const body::Pose& styled, const body::Pose& own, const body::Vec3& moved_m) noexcept {
  return AreUnit(styled.rotations) &&
         IsNear(styled.hips_position_m, own.hips_position_m + moved_m, tuning::kFarthest_m);
}

bool IsSound(const rig::Binding& binding, const rig::RigPose& styled, const rig::RigPose& own,
             const body::Vec3& moved_m) noexcept {
  const float most = tuning::kFarthest_m / binding.scale();
  const auto hips = static_cast<std::size_t>(binding.spec().source_joint[body::kHips]);
  for (std::size_t joint = 0; joint < styled.translations.size(); ++joint) {
    body::Vec3 place = own.translations[joint];
    if (joint == hips && !moved_m.isZero(0)) place += HipsShift(binding, moved_m, own);
    if (!IsNear(styled.translations[joint], place, most)) return false;
  }
  return AreUnit(styled.rotations);
}

bool IsSound(const rig::Binding& binding, const rig::RigPose& pose,
             const body::Pose& canonical) noexcept {
  for (const body::Vec3& translation : pose.translations) {
    if (!translation.allFinite()) return false;
  }
  if (!AreUnit(pose.rotations)) return false;
  body::Pose bound;
  binding.Bind(pose, bound);
  return IsSound(bound, canonical);
}

}  // namespace styled::stylist
