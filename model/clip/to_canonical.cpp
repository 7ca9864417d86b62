// The canonical poses of a clip.
#include <deque>
#include <string>
#include <vector>

#include "model/clip/clip.h"

namespace styled::clip {
namespace {

// Binds a frame, and chooses the signs of its rotations that continue the pose before it, if any.
void BindFrame(const rig::Binding& binding, const rig::RigPose& frame, const body::Pose* before,
               body::Pose& pose) {
  binding.Bind(frame, pose);
  if (before == nullptr) return;
  for (int joint = 0; joint < body::kJointCount; ++joint) {
    rig::Quat& q = pose.rotations[joint];
    if (q.dot(before->rotations[joint]) < 0) q.coeffs() = -q.coeffs();
  }
}

}  // namespace

std::vector<body::Pose> ToCanonical(const Clip& clip, const rig::Binding& binding) {
  std::vector<body::Pose> poses(clip.frames.size());
  for (std::size_t frame = 0; frame < poses.size(); ++frame) {
    BindFrame(binding, clip.frames[frame], frame == 0 ? nullptr : &poses[frame - 1], poses[frame]);
  }
  return poses;
}

Result<std::deque<body::Pose>> ToCanonical(Clip&& clip, const rig::Binding& binding,
                                           const WorkLimit& work, const std::string& file) {
  constexpr std::size_t kPerCheck = 256;
  std::deque<body::Pose> poses;
  for (std::size_t frame = 0; frame < clip.frames.size(); ++frame) {
    if (frame % kPerCheck == 0 && work.exceeded()) return work.Refusal(file);
    const body::Pose* const before = frame == 0 ? nullptr : &poses.back();
    BindFrame(binding, clip.frames[frame], before, poses.emplace_back());
    clip.frames[frame] = {};
  }
  return poses;
}

}  // namespace styled::clip
