// BindStanding: a rest pose from a clip's own frames.
#include <cmath>

#include "model/clip/clip.h"
#include "model/rig/calibration.h"
#include "model/rig/dialects.h"

namespace styled::clip {
namespace {

constexpr double kStandsFor_s = 0.1;  // a performer who stands stays standing for some time

}  // namespace

Result<rig::Binding> BindStanding(const Clip& clip) {
  const auto joints = rig::MapJoints(clip.skeleton, {});
  if (!joints.ok()) return joints.status();
  const auto bind = [&](std::size_t frame) {
    return rig::BindStanding(clip.skeleton, joints.value(), clip.frames[frame], false);
  };
  const auto stride = static_cast<std::size_t>(std::ceil(clip.rate_hz * kStandsFor_s));
  for (std::size_t frame = 0; frame < clip.frames.size(); frame += stride) {
    Result<rig::Binding> bound = bind(frame);
    if (bound.ok()) return bound;
  }
  return bind(0);
}

}  // namespace styled::clip
