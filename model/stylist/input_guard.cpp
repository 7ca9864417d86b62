#include "model/stylist/input_guard.h"

#include <algorithm>
#include <cmath>

#include "model/stylist/tuning.h"

namespace styled::stylist {
namespace {

bool Good(const rig::Vec3& translation) {
  return translation.allFinite() && translation.cwiseAbs().maxCoeff() < tuning::kLargestCoordinate;
}

bool Good(const rig::Quat& rotation) {
  const float length2 = rotation.squaredNorm();
  return std::isfinite(length2) && length2 > tuning::kLeastLength2;
}

// Copies vectors of equal size, without allocating.
void Copy(const rig::RigPose& from, rig::RigPose& to) {
  std::copy(from.translations.begin(), from.translations.end(), to.translations.begin());
  std::copy(from.rotations.begin(), from.rotations.end(), to.rotations.begin());
}

}  // namespace

InputGuard::InputGuard(const rig::Skeleton& skeleton)
    : clean_(skeleton), last_(skeleton), last_clean_(skeleton), rest_(skeleton) {}

void InputGuard::HoldBadJoints(const rig::RigPose& in, rig::RigPose& source,
                               std::bitset<256>& held) noexcept {
  held.reset();
  const rig::RigPose& before = has_last_ ? last_ : rest_;
  const std::size_t joints = rest_.rotations.size();
  for (std::size_t joint = 0; joint < joints; ++joint) {
    const bool good = Good(in.translations[joint]) && Good(in.rotations[joint]);
    const rig::RigPose& from = good ? in : before;
    if (!good) held.set(joint);
    source.translations[joint] = clean_.translations[joint] = from.translations[joint];
    const rig::Quat& rotation = from.rotations[joint];
    clean_.rotations[joint] = rotation.normalized();
    const bool is_unit = std::abs(rotation.squaredNorm() - 1) < tuning::kInputUnitTolerance;
    source.rotations[joint] = is_unit ? rotation : clean_.rotations[joint];
  }
}

InputGuard::Jump InputGuard::JudgeJump(double dt_s, float metres, const Options& options,
                                       rig::RigPose& source) noexcept {
  const rig::Vec3& root = source.translations[0];
  since_last_s_ += dt_s;
  const auto near = [&](const rig::Vec3& to, double elapsed_s) {
    const float reach_m =
        std::max(options.jump_m, tuning::kRunningFast_mps * static_cast<float>(elapsed_s));
    return (root - to).norm() * metres <= reach_m;
  };
  Jump verdict = Jump::kNone;
  if (has_last_ && !near(last_.translations[0], since_last_s_)) {
    // Count consecutive frames at the new place, each near the one before.
    candidate_frames_ = candidate_frames_ > 0 && near(candidate_, dt_s) ? candidate_frames_ + 1 : 1;
    candidate_ = root;
    verdict = candidate_frames_ >= options.jump_accept_frames ? Jump::kAccepted : Jump::kHeld;
  }
  if (verdict == Jump::kHeld) {
    since_last_s_ -= dt_s;  // time in a hold must not make a jump plausible
    Copy(last_, source);
    Copy(last_clean_, clean_);
    return verdict;
  }
  Copy(source, last_);
  Copy(clean_, last_clean_);
  has_last_ = true;
  since_last_s_ = 0;
  candidate_frames_ = 0;
  return verdict;
}

// A held pose is published, so a pose that is not plausible is refused.
void InputGuard::Carry(Checkpoint& c) noexcept {
  c(clean_, last_, last_clean_, candidate_);
  c.Within(candidate_frames_, 0, kMostFrames);
  c(since_last_s_, has_last_);
  if (!c.reads() || !c.ok()) return;
  const auto good = [](const rig::RigPose& pose) {
    return std::all_of(pose.translations.begin(), pose.translations.end(),
                       [](const auto& translation) { return Good(translation); }) &&
           std::all_of(pose.rotations.begin(), pose.rotations.end(),
                       [](const auto& rotation) { return Good(rotation); });
  };
  const auto unit = [](const rig::RigPose& pose) {
    return std::all_of(pose.rotations.begin(), pose.rotations.end(), [](const auto& rotation) {
      return std::abs(rotation.squaredNorm() - 1) < tuning::kInputUnitTolerance;
    });
  };
  if (!good(clean_) || !good(last_) || !good(last_clean_) || !unit(clean_) || !unit(last_clean_) ||
      !candidate_.allFinite() || !std::isfinite(since_last_s_)) {
    c.Refuse();
  }
}

}  // namespace styled::stylist
