#include "model/train/reference.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "model/body/heading.h"
#include "model/neutral/neutral.h"
#include "model/train/mean_carriage.h"

namespace styled::train {
namespace {

using body::kJointCount;
using body::Pose;
using body::Quat;

// The speed of the hips over the floor around frame `at`, over 0.2 s as the stylist's.
float SpeedAt(const std::vector<Pose>& poses, std::size_t at, double rate_hz) {
  const auto reach = static_cast<std::size_t>(std::lround(0.1 * rate_hz));
  const std::size_t from = at < reach ? 0 : at - reach;
  const std::size_t to = std::min(poses.size() - 1, at + reach);
  const body::Vec3 way = poses[to].hips_position_m - poses[from].hips_position_m;
  return to == from ? 0
                    : std::hypot(way.x(), way.z()) * static_cast<float>(rate_hz) /
                          static_cast<float>(to - from);
}

}  // namespace

std::optional<neutral::Reference> MeasureReference(std::span<const TrainingClip> clips,
                                                   double rate_hz) {
  neutral::Reference reference;  // its speeds separate walks
  MeanCarriage standing, walking, running;
  for (const TrainingClip& clip : clips) {
    if (clip.style != 0 || !clip.person.empty()) continue;
    for (std::size_t at = 0; at < clip.poses.size(); ++at) {
      for (const bool mirrored : {false, true}) {
        Pose pose = clip.poses[at];
        if (mirrored) body::Mirror(pose, pose);
        body::WorldPose world;
        body::ForwardKinematics(pose, world);
        const neutral::Ordinary ordinary =
            neutral::JudgeOrdinary(world, SpeedAt(clip.poses, at, rate_hz), reference);
        pose.rotations[body::kHips] =
            body::Yaw(-ordinary.heading_rad) * pose.rotations[body::kHips];
        for (int joint = 0; joint < kJointCount; ++joint) {
          const Quat& rotation = pose.rotations[static_cast<std::size_t>(joint)];
          const float moving = ordinary.Of(joint) * ordinary.moving;
          const auto add = [&](MeanCarriage& mean, float weight) {
            mean.Add(joint, rotation, static_cast<double>(weight));
          };
          add(walking, moving * (1 - ordinary.running));
          add(running, moving * ordinary.running);
          add(standing, ordinary.Of(joint) * (1 - ordinary.moving));
        }
      }
    }
  }
  if (!standing.any() || !walking.any()) return std::nullopt;
  reference.walking = walking.Value();
  reference.standing = standing.Value(reference.walking);
  reference.running = running.Value(reference.walking);
  return reference;
}

}  // namespace styled::train
