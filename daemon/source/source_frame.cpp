#include "daemon/source/source_frame.h"

#include <bit>
#include <cstring>

static_assert(std::endian::native == std::endian::little, "floats are copied as they lie");

namespace styled::source {

bool CopyPose(const SourceFrame& frame, int joint_count, rig::RigPose& pose) noexcept {
  const auto joints = static_cast<std::size_t>(joint_count);
  static_assert(sizeof(rig::Vec3) == 3 * sizeof(float));
  static_assert(sizeof(rig::Quat) == 4 * sizeof(float));  // coefficients x,y,z,w
  if (frame.root_position.size() != sizeof(rig::Vec3)) return false;
  if (frame.rotations.size() != joints * sizeof(rig::Quat)) return false;
  std::memcpy(pose.translations.front().data(), frame.root_position.data(), sizeof(rig::Vec3));
  std::memcpy(pose.rotations.front().coeffs().data(), frame.rotations.data(),
              frame.rotations.size());
  return true;
}

bool ReadBody(const SourceFrame& frame, v1::Body& body) {
  if (frame.body != nullptr) {
    body = *frame.body;
    return true;
  }
  return body.ParseFromArray(frame.body_bytes.data(), static_cast<int>(frame.body_bytes.size()));
}

}  // namespace styled::source
