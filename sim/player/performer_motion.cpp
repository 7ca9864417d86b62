#include "sim/player/performer_motion.h"

#include <cmath>

#include "model/clip/clip.h"

namespace styled::player {

PerformerMotion::PerformerMotion(synthetic::Options options,
                                 const synthetic::Proportions& proportions, double rate_hz)
    : performer_(std::move(options)), rate_hz_(rate_hz), scale_(proportions.height) {
  body_.skeleton = synthetic::MakeSkeleton(proportions);
  body_.rest.assign(body::kJointCount, rig::Quat::Identity());
  body_.metres_per_unit = 1;
  body_.dialect = "canonical";
}

Motion::Step PerformerMotion::Next(rig::RigPose& pose) {
  performer_.Pose(static_cast<double>(frame_++) / rate_hz_, canonical_);
  if (pose.rotations.size() != body_.skeleton.offsets.size()) pose = rig::RigPose(body_.skeleton);
  pose.translations[0] = scale_ * canonical_.hips_position_m;
  for (int j = 0; j < body::kJointCount; ++j) pose.rotations[j] = canonical_.rotations[j];
  return Step::kPose;
}

Status WriteMotion(Motion& motion, double seconds, double rate_hz,
                   const std::filesystem::path& file) {
  constexpr float kCentimetres = 100;
  const float unit = motion.body().metres_per_unit > 0 ? motion.body().metres_per_unit : 1;
  const float scale = kCentimetres * unit;
  clip::Clip clip;
  clip.skeleton = motion.body().skeleton;
  clip.rate_hz = rate_hz;
  for (rig::Vec3& offset : clip.skeleton.offsets) offset *= scale;
  const auto frames = static_cast<std::size_t>(std::max(1LL, std::llround(seconds * rate_hz)));
  rig::RigPose pose;
  for (std::size_t i = 0; i < frames; ++i) {
    if (motion.Next(pose) != Motion::Step::kPose) break;
    clip.frames.push_back(pose);
    for (rig::Vec3& translation : clip.frames.back().translations) translation *= scale;
  }
  return clip::WriteBvh(clip, file);
}

}  // namespace styled::player
