#include "daemon/publish/body_message.h"

#include <span>

#include "model/base/hash.h"
#include "model/body/humanoid.h"

namespace styled::publish {

std::uint64_t BodyHash(const v1::Body& body) {
  Fnv1a hash;
  for (const auto& name : body.names()) hash.Bytes(name.c_str(), name.size() + 1);
  for (const std::int32_t parent : body.parents()) hash.Bytes(&parent, sizeof parent);
  for (const float value : body.offsets()) hash.Bytes(&value, sizeof value);
  for (const float value : body.rest()) hash.Bytes(&value, sizeof value);
  const float unit_m = body.metres_per_unit();
  hash.Bytes(&unit_m, sizeof unit_m);
  return hash.value();
}

v1::Body SkeletonBody(const rig::Skeleton& skeleton, const std::vector<rig::Quat>& rest,
                      float metres_per_unit, const std::string& dialect, v1::Output output) {
  v1::Body body;
  for (const auto& name : skeleton.names) body.add_names(name);
  for (const int parent : skeleton.parents) body.add_parents(parent);
  for (const rig::Vec3& offset : skeleton.offsets) {
    for (const float value : std::span(offset.data(), 3)) body.add_offsets(value);
  }
  for (const rig::Quat& rotation : rest) {
    for (const float value : std::span(rotation.coeffs().data(), 4)) body.add_rest(value);
  }
  body.set_metres_per_unit(metres_per_unit);
  body.set_dialect(dialect);
  body.set_output(output);
  body.set_hash(BodyHash(body));
  return body;
}

v1::Body RigBody(const std::string& performer, const rig::Binding& binding, bool mirrored,
                 float metres_per_unit, const std::string& dialect) {
  rig::Skeleton skeleton = binding.skeleton();
  std::vector<rig::Quat> rest = binding.spec().rest_rotations;
  if (mirrored) {
    for (rig::Vec3& offset : skeleton.offsets) offset = rig::Mirrored(offset);
    for (rig::Quat& rotation : rest) rotation = rig::Mirrored(rotation);
  }
  v1::Body body = SkeletonBody(skeleton, rest, metres_per_unit, dialect, v1::OUTPUT_RIG);
  body.set_performer(performer);
  return body;
}

v1::Body CanonicalBody(const std::string& performer, const rig::Tail& tail) {
  v1::Body body;
  body.set_performer(performer);
  const auto add = [&body](std::string_view name, int parent, const rig::Vec3& offset_m) {
    body.add_names(std::string(name));
    body.add_parents(parent);
    for (const float value : std::span(offset_m.data(), 3)) body.add_offsets(value);
    for (const float value : {0.0F, 0.0F, 0.0F, 1.0F}) body.add_rest(value);
  };
  for (int joint = 0; joint < body::kJointCount; ++joint) {
    const body::JointRow& row = body::kHumanoid[static_cast<std::size_t>(joint)];
    add(row.name, row.parent, body::Offset(joint));
  }
  for (const rig::Tail::Joint& joint : tail.joints()) {
    add(rig::kTailNames[static_cast<std::size_t>(joint.joint)], joint.parent, joint.offset_m);
  }
  body.set_metres_per_unit(1);
  body.set_dialect("canonical");
  body.set_output(v1::OUTPUT_CANONICAL);
  body.set_hash(BodyHash(body));
  return body;
}

}  // namespace styled::publish
