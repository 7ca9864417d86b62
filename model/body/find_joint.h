#pragma once

#include <string_view>

#include "model/body/humanoid.h"

namespace styled::body {

// The index of the joint with that name in kHumanoid, or -1.
constexpr int FindJoint(std::string_view name) {
  for (int joint = 0; joint < kJointCount; ++joint) {
    if (kHumanoid[static_cast<std::size_t>(joint)].name == name) return joint;
  }
  return -1;
}

}  // namespace styled::body
