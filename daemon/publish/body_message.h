#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "model/rig/binding.h"
#include "proto/styled/v1/body.pb.h"

namespace styled::publish {

// FNV-1a (64 bit) over each name and a zero byte, the parents as 32-bit and offsets, rest and the
// unit as IEEE floats, little-endian. Frames carry the hash of their body.
std::uint64_t BodyHash(const v1::Body& body);

// The bodies that subscribers get, hash filled in: the rig's skeleton as received with the T-pose
// rests that its binding uses (mirrored back where the binding is of a mirrored skeleton), and the
// canonical humanoid.
v1::Body RigBody(const std::string& performer, const rig::Binding& binding, bool mirrored,
                 float metres_per_unit, const std::string& dialect);
v1::Body CanonicalBody(const std::string& performer);
// Of joints, offsets and rests in one frame of reference.
v1::Body SkeletonBody(const rig::Skeleton& skeleton, const std::vector<rig::Quat>& rest,
                      float metres_per_unit, const std::string& dialect, v1::Output output);

}  // namespace styled::publish
