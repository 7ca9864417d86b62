#pragma once

#include "model/body/pose.h"

// The coordinate axes of a skeleton's source. Pure function; no allocation; any thread.
namespace styled::rig {

// The signed coordinate axis nearest to a direction; zero for none.
inline body::Vec3 NearestAxis(const body::Vec3& direction) {
  Eigen::Index axis = 0;
  const float most = direction.cwiseAbs().maxCoeff(&axis);
  body::Vec3 nearest = body::Vec3::Zero();
  if (most > 0) nearest[axis] = direction[axis] < 0 ? -1.0F : 1.0F;
  return nearest;
}

}  // namespace styled::rig
