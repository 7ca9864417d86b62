// Fuzzes the binding of skeletons: whatever the tree, the names and the poses are, a map has only
// joints that exist, each once, and a binding makes finite poses and gives its own poses back.
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <set>

#include "model/clip/bind_clip.h"
#include "model/rig/calibration.h"
#include "model/rig/check_binding.h"
#include "model/rig/find_humanoid.h"
#include "model/rig/motion_up.h"
#include "model/rig/tail.h"
#include "tests/fuzz/binder/skeleton_bytes.h"

namespace {

using namespace styled;

void Require(bool condition) {
  if (!condition) std::abort();
}

void RequireMap(const std::array<int, body::kJointCount>& map, const rig::Skeleton& skeleton) {
  std::set<int> seen;
  for (const int joint : map) {
    Require(joint >= -1 && joint < skeleton.joint_count());
    if (joint >= 0) Require(seen.insert(joint).second);
  }
}

void RequireBinding(const rig::Binding& binding, const clip::Clip& clip) {
  Require(std::isfinite(binding.scale()) && binding.scale() > 0);
  body::Pose pose;
  rig::RigPose back(clip.skeleton);
  for (const rig::RigPose& frame : clip.frames) {
    binding.Bind(frame, pose);
    for (const body::Quat& rotation : pose.rotations) {
      Require(std::abs(rotation.norm() - 1) < 1e-2F);
    }
    binding.Unbind(pose, frame, back);
    for (std::size_t j = 0; j < back.rotations.size(); ++j) {
      Require(std::abs(back.rotations[j].dot(frame.rotations[j])) > 0.999F);
    }
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const clip::Clip clip = fuzz::ReadClip({data, size});
  const rig::Skeleton& skeleton = clip.skeleton;
  const auto map = rig::FindHumanoid(skeleton, {}, clip.frames);
  if (map.ok()) {
    RequireMap(map.value().joint, skeleton);
    Require(map.value().confidence >= 0 && map.value().confidence <= 1);
    for (const int joint : rig::FindTail(skeleton, map.value().joint)) {
      Require(joint >= -1 && joint < skeleton.joint_count());
    }
  } else {
    Require(!map.status().message().empty());
  }
  for (const auto pose : {rig::StandingPose::kT, rig::StandingPose::kN}) {
    const auto calibrated = rig::Calibrate(skeleton, clip.frames.front(), pose);
    if (calibrated.ok()) Require(rig::Binding::Make(calibrated.value().spec).ok());
  }
  const auto bound = clip::BindClip(clip);
  if (!bound.ok()) return 0;
  RequireMap(bound.value().map.joint, skeleton);
  RequireBinding(bound.value().binding, clip);
  const clip::Clip straight = clip::WithTPose(clip, bound.value().binding);
  Require(straight.frames.size() == clip.frames.size());
  return 0;
}
