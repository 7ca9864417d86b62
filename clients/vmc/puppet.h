#pragma once

#include <string>
#include <vector>

#include "model/base/status.h"
#include "proto/rigs/vmc/packer.h"
#include "proto/styled/v1/body.pb.h"
#include "proto/styled/v1/frame.pb.h"

namespace styled::stylevmc {

// What carries the performer through the room.
enum class Carrier {
  kHips,  // the hips alone, the root stays at the origin: what VirtualMotionCapture does
  kRoot,  // the root moves over the floor, the hips stay above it
};

// Turns frames on the canonical humanoid into the bones of VMC: our axes (right-handed, +Y up,
// +Z forward, +X the body's left) are mirrored in x = 0 and so become Unity's, in which +X is the
// body's right; names become HumanBodyBones' own; rotations stay relative to the parent and to the
// T-pose, since both humanoids rest in it with identity rotations. Each bone comes with its offset:
// receivers that write positions into the avatar (EVMC4U) would fold it up at zero.
//
// One thread. Pinned by tests/unit/vmc_out/puppet_test.cpp.
class Puppet {
 public:
  explicit Puppet(Carrier carrier) : carrier_(carrier) {}

  // Takes a body of OUTPUT_CANONICAL that client::Validate passed. Refuses one with a joint that is
  // no bone, or whose joint 0 is not the hips; the old body then stays. Allocates.
  Status Bind(const v1::Body& body);

  // `frame` must fit the body bound (client::Validate). What is returned views into this object
  // and into `frame`, until the next call. The frame's expressions become Blends, its thru is sent
  // on.
  vmc::Packed Pose(const v1::Frame& frame, float time_s);

 private:
  Carrier carrier_;
  std::vector<vmc::Bone> bones_;  // in the body's order; names of the codec's table
  std::vector<vmc::Blend> blends_;
  std::vector<vmc::Thru> thrus_;
};

}  // namespace styled::stylevmc
