#include "daemon/perform/performer/body_binding.h"

#include <array>
#include <cmath>
#include <utility>

#include "model/base/text.h"
#include "model/rig/bind_body.h"
#include "model/rig/calibration.h"

namespace styled::pipeline {
namespace {

using rig::Vec3;
using JointMap = std::array<int, body::kJointCount>;

Status Count(const std::string& field, int found, int expected) {
  if (found == expected) return Status::Ok();
  return Status::Error("body: " + field + ": found " + std::to_string(found) +
                       " values, expected " + std::to_string(expected));
}

// The message as a body; its numbers are checked by rig::CheckBody.
Result<rig::RigBody> ReadBody(const v1::Body& body) {
  const int joints = body.names_size();
  if (joints < 1 || joints > rig::kMaxSourceJoints) {  // before anything of it is copied
    return Status::Error("body: found " + std::to_string(joints) + " joints, expected 1 to " +
                         std::to_string(rig::kMaxSourceJoints));
  }
  Status status = Count("parents", body.parents_size(), joints);
  if (status.ok()) status = Count("offsets", body.offsets_size(), 3 * joints);
  if (status.ok() && body.rest_size() > 0) status = Count("rest", body.rest_size(), 4 * joints);
  if (!status.ok()) return status;
  if (!std::isfinite(body.metres_per_unit()) || body.metres_per_unit() < 0) {
    return Status::Error("body: metres_per_unit: found " + NumberText(body.metres_per_unit()) +
                         ", expected a length in metres, or 0 where it is unknown");
  }
  rig::RigBody read;
  read.metres_per_unit = body.metres_per_unit();
  if (!body.dialect().empty()) read.dialect = body.dialect();
  for (int j = 0; j < joints; ++j) {
    read.skeleton.names.push_back(body.names(j));
    read.skeleton.parents.push_back(body.parents(j));
    read.skeleton.offsets.emplace_back(body.offsets(3 * j), body.offsets(3 * j + 1),
                                       body.offsets(3 * j + 2));
    if (body.rest_size() > 0) {
      read.rest.emplace_back(body.rest(4 * j + 3), body.rest(4 * j), body.rest(4 * j + 1),
                             body.rest(4 * j + 2));
    }
  }
  status = rig::CheckBody(read);
  if (!status.ok()) return status;
  return read;
}

// By the calibration of this skeleton: its sides and axes are known.
Result<BoundBody> BindCalibrated(rig::Skeleton skeleton, const KeptRest& calibrated,
                                 const JointMap& map) {
  BoundBody bound{nullptr, "calibrated", calibrated.left_handed, false, ""};
  rig::BindingSpec spec{std::move(skeleton), map, calibrated.rotations,
                        calibrated.canonical_from_source};
  for (Vec3& offset : spec.skeleton.offsets) {
    if (bound.left_handed) offset = rig::Mirrored(offset);
  }
  auto binding = rig::Binding::Make(std::move(spec));
  if (!binding.ok()) return binding.status();
  bound.toes_backwards = rig::ToesPointBackwards(binding.value().spec());
  bound.binding = std::make_shared<const rig::Binding>(std::move(binding.value()));
  return bound;
}

}  // namespace

Result<rig::Skeleton> ReadSkeleton(const v1::Body& body) {
  auto read = ReadBody(body);
  if (!read.ok()) return read.status();
  return std::move(read.value().skeleton);
}

Result<BoundBody> BindBody(const v1::Body& body, const std::optional<KeptRest>& calibrated,
                           const rig::JointNames& given) {
  auto read = ReadBody(body);
  if (!read.ok()) return read.status();
  rig::Skeleton& skeleton = read.value().skeleton;
  if (calibrated && calibrated->skeleton == SkeletonHash(skeleton)) {
    const auto found = rig::MapBody(read.value(), given);
    if (!found.ok()) return found.status();
    return BindCalibrated(std::move(skeleton), *calibrated, found.value().joint);
  }
  auto bound = rig::BindBody(read.value(), given);
  if (!bound.ok()) return bound.status();
  return BoundBody{bound.value().binding, bound.value().dialect, false,
                   bound.value().toes_backwards, bound.value().remark};
}

}  // namespace styled::pipeline
