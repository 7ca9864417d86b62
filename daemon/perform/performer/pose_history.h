#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "model/base/realtime.h"
#include "model/rig/skeleton.h"

namespace styled::pipeline {

// The performer's last pose and some poses of the last third of a second, which show whether the
// performer stood still. Input of a calibration. Sized once; pipeline thread. A pose may have more
// joints than the skeleton; those behind are left out.
class PoseHistory {
 public:
  explicit PoseHistory(const rig::Skeleton& skeleton) : pose_(skeleton) { kept_.fill(pose_); }

  STYLED_REALTIME void Add(const rig::RigPose& pose, std::int64_t now_ns) noexcept {
    if (now_ns - kept_at_ns_[newest_] >= kStep_ns) {
      newest_ = (newest_ + 1) % kKept;
      Copy(pose_, kept_[newest_]);
      kept_at_ns_[newest_] = now_ns;
    }
    Copy(pose, pose_);
    last_ns_ = now_ns;
  }

  const rig::RigPose& pose() const { return pose_; }
  std::int64_t last_ns() const { return last_ns_; }

  // The joint that turned most within the history, and by how much.
  struct Motion {
    std::size_t joint = 0;
    float radians = 0;
  };
  Motion Moved() const noexcept {
    Motion most;
    for (std::size_t k = 0; k < kKept; ++k) {
      if (kept_at_ns_[k] == kNever || last_ns_ - kept_at_ns_[k] > kRemembered_ns) continue;
      for (std::size_t j = 0; j < pose_.rotations.size(); ++j) {
        const float radians =
            kept_[k].rotations[j].normalized().angularDistance(pose_.rotations[j].normalized());
        if (radians > most.radians) most = {j, radians};
      }
    }
    return most;
  }

 private:
  static constexpr std::size_t kKept = 4;
  static constexpr std::int64_t kStep_ns = 100'000'000, kRemembered_ns = 450'000'000;
  static constexpr std::int64_t kNever = -1'000'000'000'000;

  static void Copy(const rig::RigPose& from, rig::RigPose& to) noexcept {
    std::copy_n(from.translations.begin(), to.translations.size(), to.translations.begin());
    std::copy_n(from.rotations.begin(), to.rotations.size(), to.rotations.begin());
  }

  rig::RigPose pose_;
  std::array<rig::RigPose, kKept> kept_;
  std::array<std::int64_t, kKept> kept_at_ns_{kNever, kNever, kNever, kNever};
  std::size_t newest_ = 0;
  std::int64_t last_ns_ = kNever;
};

}  // namespace styled::pipeline
