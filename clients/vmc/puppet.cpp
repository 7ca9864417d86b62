#include "clients/vmc/puppet.h"

#include <span>

#include "proto/rigs/vmc/bones.h"

namespace styled::stylevmc {

Status Puppet::Bind(const v1::Body& body) {
  std::vector<vmc::Bone> bones;
  for (int joint = 0; joint < body.names_size(); ++joint) {
    // The names are VRM 1.0's: leftThumbProximal is Unity's ThumbIntermediate.
    const int bone = vmc::FindBone(body.names(joint), true);
    if (bone < 0 || (joint == 0 && bone != vmc::kHips)) {
      return Status::Error("body of " + body.performer() + ": joint " + std::to_string(joint) +
                           " is '" + body.names(joint) + "', expected " +
                           (joint == 0 ? "hips" : "a bone of Unity's HumanBodyBones"));
    }
    const float* offset = body.offsets().data() + 3 * joint;
    bones.push_back({vmc::kBones[static_cast<std::size_t>(bone)].name,
                     {{-offset[0], offset[1], offset[2]}, {0, 0, 0, 1}}});
  }
  bones_ = std::move(bones);
  return Status::Ok();
}

vmc::Packed Puppet::Pose(const v1::Frame& frame, float time_s) {
  for (std::size_t joint = 0; joint < bones_.size(); ++joint) {
    const float* q = frame.rotations().data() + 4 * joint;
    bones_[joint].transform.rotation = {q[0], -q[1], -q[2], q[3]};
  }
  vmc::Packed packed;
  auto& hips = bones_.front().transform.position;
  hips = {-frame.root_position(0), frame.root_position(1), frame.root_position(2)};
  if (carrier_ == Carrier::kRoot) {
    packed.root.transform.position = {hips[0], 0, hips[2]};
    hips[0] = hips[2] = 0;
  }
  packed.bones = bones_;
  blends_.clear();
  thrus_.clear();
  devices_.clear();
  for (const auto& expression : frame.expressions()) {
    blends_.push_back({expression.name(), expression.value()});
  }
  for (const auto& message : frame.thru()) {
    thrus_.push_back({std::as_bytes(std::span(message))});
  }
  packed.blends = blends_;
  for (const auto& prop : frame.props()) {
    const auto& p = prop.position();
    const auto& q = prop.rotation();
    devices_.push_back({vmc::Device::Kind::kTracker,
                        prop.name(),
                        {{-p[0], p[1], p[2]}, {q[0], -q[1], -q[2], q[3]}}});
  }
  packed.thrus = thrus_;
  packed.devices = devices_;
  packed.available.tracking = (frame.flags() & v1::FLAG_STALE) == 0 ? 1 : 0;
  packed.time_s = time_s;
  return packed;
}

}  // namespace styled::stylevmc
