#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "model/rig/binding.h"
#include "model/rig/tail.h"
#include "proto/styled/v1/body.pb.h"

namespace styled::publish {

// FNV-1a (64 bit) over each name and a zero byte, the parents as 32-bit integers, and offsets, rest
// and unit as IEEE floats; all little-endian. Frames carry the hash of their body.
std::uint64_t BodyHash(const v1::Body& body);

// The bodies for subscribers, with their hash: the rig's skeleton as received, with the T-pose
// rests of its binding (mirrored back if the binding is that of a mirrored skeleton), and the
// canonical humanoid with `tail`, the rig's fingers, eyes and jaw, behind its joints.
v1::Body RigBody(const std::string& performer, const rig::Binding& binding, bool mirrored,
                 float metres_per_unit, const std::string& dialect);
v1::Body CanonicalBody(const std::string& performer, const rig::Tail& tail);
// A body made of joints, offsets and rests in one frame of reference.
v1::Body SkeletonBody(const rig::Skeleton& skeleton, const std::vector<rig::Quat>& rest,
                      float metres_per_unit, const std::string& dialect, v1::Output output);

}  // namespace styled::publish
