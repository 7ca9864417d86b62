#include "model/gait/curve.h"

#include <algorithm>
#include <cmath>

#include "model/body/heading.h"

namespace styled::gait {

Terms TermsAt(float phase_rad) noexcept {
  Terms terms;
  const float cosine = std::cos(phase_rad), sine = std::sin(phase_rad);
  terms[0] = 1;
  float c = 1, s = 0;
  for (int k = 1; k <= kHarmonics; ++k) {
    const float next = c * cosine - s * sine;
    s = s * cosine + c * sine;
    c = next;
    terms[k] = c;
    terms[kHarmonics + k] = s;
  }
  return terms;
}

Rotations Curve::At(const Terms& terms) const noexcept {
  const Vectors vectors = VectorsAt(terms);
  Rotations at;
  for (int joint = 0; joint < body::kJointCount; ++joint) {
    const auto j = static_cast<std::size_t>(joint);
    at[j] = mean[j] * body::Exp(VectorOf(vectors, joint));
  }
  return at;
}

Rotations Mirrored(const Rotations& rotations) noexcept {
  Rotations mirrored;
  for (int joint = 0; joint < body::kJointCount; ++joint) {
    const body::Quat& q = rotations[static_cast<std::size_t>(body::MirrorJoint(joint))];
    mirrored[static_cast<std::size_t>(joint)] = body::Quat(q.w(), q.x(), -q.y(), -q.z());
  }
  return mirrored;
}

Terms MirrorSigns() noexcept {
  Terms signs;
  signs[0] = 1;
  for (int k = 1; k <= kHarmonics; ++k) signs[k] = signs[kHarmonics + k] = (k % 2 == 0 ? 1 : -1);
  return signs;
}

Series Mirrored(const Series& series) noexcept {
  const Terms signs = MirrorSigns();
  Series mirrored = Series::Zero();
  for (int joint = 0; joint < body::kJointCount; ++joint) {
    for (int axis = 0; axis < 3; ++axis) {
      const float sign = axis == 0 ? 1.0F : -1.0F;
      mirrored.row(3 * joint + axis) =
          sign * series.row(3 * body::MirrorJoint(joint) + axis).cwiseProduct(signs.transpose());
    }
  }
  return mirrored;
}

Rotations HeadingRelative(const body::Pose& pose, float heading_rad) noexcept {
  Rotations rotations = pose.rotations;
  rotations[body::kHips] = body::Yaw(-heading_rad) * rotations[body::kHips];
  return rotations;
}

Vectors VectorsAbout(const Rotations& mean, const Rotations& rotations) noexcept {
  Vectors vectors = Vectors::Zero();
  for (int joint = 0; joint < body::kJointCount; ++joint) {
    const auto j = static_cast<std::size_t>(joint);
    vectors.segment<3>(3 * joint) = body::Log(mean[j].conjugate() * rotations[j]);
  }
  return vectors;
}

void Curve::Carry(Checkpoint& c) noexcept {
  c(mean, series);
  if (!c.reads() || !c.ok()) return;
  constexpr float kTolerance = 1e-3F;
  const bool turns = std::all_of(mean.begin(), mean.end(), [](const body::Quat& rotation) {
    return std::abs(rotation.norm() - 1) <= kTolerance;
  });
  if (!turns || !series.allFinite()) c.Refuse();
}

}  // namespace styled::gait
