#pragma once

#include <vector>

#include "model/base/status.h"
#include "proto/rigs/vmc/packer.h"
#include "proto/styled/v1/body.pb.h"
#include "proto/styled/v1/frame.pb.h"

namespace styled::stylevmc {

// Which transform carries the performer's movement through space.
enum class Carrier {
  kHips,  // the hips only; the root stays at the origin, as VirtualMotionCapture sends it
  kRoot,  // the root moves on the floor; the hips stay above it
};

// Converts frames on the canonical humanoid to the bones of VMC. Our axes (right-handed, +Y up, +Z
// forward, +X the body's left) are mirrored in x = 0 to become Unity's, in which +X is the body's
// right. Joints, with the fingers, eyes and jaw that the performer has, get the names of
// HumanBodyBones; bones that the body lacks are not sent. Rotations stay relative to the parent and
// the T-pose, since both humanoids rest in the T-pose with identity rotations. Each bone is sent
// with its offset: receivers that write positions into the avatar (EVMC4U) would collapse it if the
// offsets were zero.
//
// One thread. Pinned by tests/unit/vmc_out/puppet_test.cpp.
class Puppet {
 public:
  explicit Puppet(Carrier carrier) : carrier_(carrier) {}

  // `body` must be of OUTPUT_CANONICAL and have passed client::Validate. Refuses a body with a
  // joint that is not a bone of VMC, or whose joint 0 is not the hips; the previous body then stays
  // bound. Allocates.
  Status Bind(const v1::Body& body);

  // `frame` must fit the bound body (client::Validate). The result refers to memory of this object
  // and of `frame`, and is valid until the next call. The frame's expressions become Blends, its
  // props trackers (Device) in the same world; its pass-through messages (thru) are sent unchanged.
  vmc::Packed Pose(const v1::Frame& frame, float time_s);

 private:
  Carrier carrier_;
  std::vector<vmc::Bone> bones_;  // in the body's order; names from the codec's table
  std::vector<vmc::Blend> blends_;
  std::vector<vmc::Thru> thrus_;
  std::vector<vmc::Device> devices_;
};

}  // namespace styled::stylevmc
