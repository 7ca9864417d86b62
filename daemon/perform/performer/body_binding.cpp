#include "daemon/perform/performer/body_binding.h"

#include <array>
#include <cmath>
#include <set>
#include <span>
#include <utility>
#include <vector>

#include "model/base/text.h"
#include "model/rig/calibration.h"
#include "model/rig/find_humanoid.h"

namespace styled::pipeline {
namespace {

using rig::Quat;
using rig::Vec3;
using JointMap = std::array<int, body::kJointCount>;

Status Count(const std::string& field, int found, int expected) {
  if (found == expected) return Status::Ok();
  return Status::Error("body: " + field + ": found " + std::to_string(found) +
                       " values, expected " + std::to_string(expected));
}

Status FillSkeleton(const v1::Body& body, rig::Skeleton& skeleton) {
  const int joints = body.names_size();
  if (joints < 1 || joints > rig::kMaxSourceJoints) {
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
  std::set<std::string> names;
  for (int j = 0; j < joints; ++j) {
    const auto refuse = [j](const std::string& what) {
      return Status::Error("body: joint " + std::to_string(j) + ": " + what);
    };
    const std::string& name = body.names(j);
    if (name.empty() || name.size() > 128) return refuse("name is empty or too long");
    if (!names.insert(name).second) return refuse("name \"" + name + "\" is used twice");
    const int parent = body.parents(j);
    if (j == 0 ? parent != -1 : parent < 0 || parent >= j) {
      return refuse("parent " + std::to_string(parent) +
                    (j == 0 ? ", expected -1" : ", expected an earlier joint"));
    }
    const Vec3 offset(body.offsets(3 * j), body.offsets(3 * j + 1), body.offsets(3 * j + 2));
    if (!offset.allFinite()) return refuse("offset is not finite");
    skeleton.names.push_back(name);
    skeleton.parents.push_back(parent);
    skeleton.offsets.push_back(offset);
  }
  return Status::Ok();
}

// The signed source axis nearest to a direction.
Vec3 NearestAxis(const Vec3& direction) {
  Eigen::Index axis = 0;
  direction.cwiseAbs().maxCoeff(&axis);
  Vec3 nearest = Vec3::Zero();
  nearest[axis] = direction[axis] < 0 ? -1.0F : 1.0F;
  return nearest;
}

// Positions of the joints in the T-pose of the rests, in source axes.
std::vector<Vec3> RestPositions(const rig::BindingSpec& spec) {
  std::vector<Vec3> positions(spec.skeleton.offsets);
  for (std::size_t j = 1; j < positions.size(); ++j) {
    const auto parent = static_cast<std::size_t>(spec.skeleton.parents[j]);
    positions[j] = positions[parent] + spec.rest_rotations[parent] * spec.skeleton.offsets[j];
  }
  return positions;
}

// Finds which source axes are left, up and forward in the T-pose of the rests.
Status FindAxes(rig::BindingSpec& spec) {
  const std::vector<Vec3> positions = RestPositions(spec);
  for (const int needed : {body::kLeftUpperArm, body::kRightUpperArm, body::kHead, body::kHips}) {
    if (spec.source_joint[static_cast<std::size_t>(needed)] < 0) {
      return Status::Error("body: no joint is the " +
                           std::string(body::kHumanoid[static_cast<std::size_t>(needed)].name));
    }
  }
  const auto at = [&](body::Joint joint) {
    return positions[static_cast<std::size_t>(spec.source_joint[joint])];
  };
  const Vec3 left = NearestAxis(at(body::kLeftUpperArm) - at(body::kRightUpperArm));
  const Vec3 up = NearestAxis(at(body::kHead) - at(body::kHips));
  if (left.dot(up) != 0) return Status::Error("body: rest: does not make a T-pose");
  Eigen::Matrix3f axes;
  // The rows are the canonical axes in source coordinates, so the matrix maps source to canonical.
  // left x up is forward, which makes it a rotation.
  axes.row(0) = left;
  axes.row(1) = up;
  axes.row(2) = left.cross(up);
  spec.canonical_from_source = Quat(axes).normalized();
  return Status::Ok();
}

// The T-pose that the rig sent: world rotations.
Result<std::vector<Quat>> ReadRests(const v1::Body& body) {
  std::vector<Quat> rests;
  for (int j = 0; j < body.names_size() && body.rest_size() > 0; ++j) {
    rests.emplace_back(body.rest(4 * j + 3), body.rest(4 * j), body.rest(4 * j + 1),
                       body.rest(4 * j + 2));
    if (!(std::abs(rests.back().norm() - 1.0F) < 1e-3F)) {
      return Status::Error("body: joint " + std::to_string(j) + ": rest is not of unit length");
    }
  }
  return rests;
}

// That T-pose as a pose; without one the zero pose.
rig::RigPose RestPose(const rig::Skeleton& skeleton, const std::vector<Quat>& rests) {
  rig::RigPose pose(skeleton);
  for (std::size_t j = 0; j < rests.size(); ++j) {
    const int parent = skeleton.parents[j];
    pose.rotations[j] =
        parent < 0 ? rests[j] : rests[static_cast<std::size_t>(parent)].conjugate() * rests[j];
  }
  return pose;
}

Result<rig::Binding> BindByRests(rig::Skeleton skeleton, std::vector<Quat> rests,
                                 const JointMap& map) {
  rig::BindingSpec spec;
  spec.source_joint = map;
  spec.skeleton = std::move(skeleton);
  spec.rest_rotations = std::move(rests);
  const Status status = FindAxes(spec);
  if (!status.ok()) return status;
  return rig::Binding::Make(std::move(spec));
}

// By a dialect; a zero pose that stands upright with its arms down is a rest pose, too.
Result<rig::Binding> BindByZeroPose(const rig::Skeleton& skeleton, const std::string& dialect,
                                    const JointMap& map, std::string& used) {
  auto bound = rig::BindMapped(skeleton, dialect, &used, map);
  if (bound.ok() || dialect != "auto" || !rig::CanCalibrate(map).ok()) return bound;
  auto standing = rig::BindStanding(skeleton, map, rig::RigPose(skeleton), false);
  if (!standing.ok()) return bound;
  used = "standing";
  return standing;
}

bool ToesPointBackwards(const rig::BindingSpec& spec) {
  const auto positions = RestPositions(spec);
  Vec3 ahead = Vec3::Zero();
  for (const auto& [foot, toes] : {std::pair{body::kLeftFoot, body::kLeftToes},
                                   std::pair{body::kRightFoot, body::kRightToes}}) {
    const int from = spec.source_joint[static_cast<std::size_t>(foot)];
    const int to = spec.source_joint[static_cast<std::size_t>(toes)];
    if (from < 0 || to < 0) continue;
    const Vec3 along = spec.canonical_from_source * (positions[static_cast<std::size_t>(to)] -
                                                     positions[static_cast<std::size_t>(from)]);
    ahead += Vec3(along.x(), 0, along.z());
  }
  return ahead.z() < 0 && -ahead.z() > std::abs(ahead.x());
}

}  // namespace

Result<rig::Skeleton> ReadSkeleton(const v1::Body& body) {
  rig::Skeleton skeleton;
  const Status status = FillSkeleton(body, skeleton);
  if (!status.ok()) return status;
  return skeleton;
}

Result<BoundBody> BindBody(const v1::Body& body, const std::optional<KeptRest>& calibrated,
                           const rig::JointNames& given) {
  auto skeleton = ReadSkeleton(body);
  if (!skeleton.ok()) return skeleton.status();
  const std::string dialect = body.dialect().empty() ? "auto" : body.dialect();
  BoundBody bound{nullptr, "given"};
  auto rests = ReadRests(body);
  if (!rests.ok()) return rests.status();
  const rig::RigPose rest = RestPose(skeleton.value(), rests.value());
  const auto found = rig::FindHumanoid(skeleton.value(), given, std::span(&rest, 1));
  if (!found.ok()) return found.status();
  const JointMap& map = found.value().joint;
  bound.remark = found.value().remark;
  const auto bind = [&]() -> Result<rig::Binding> {
    if (calibrated && calibrated->skeleton == SkeletonHash(skeleton.value())) {
      bound.dialect = "calibrated";
      bound.remark.clear();  // the calibration has found sides and axes
      bound.left_handed = calibrated->left_handed;
      rig::BindingSpec spec{std::move(skeleton.value()), map, calibrated->rotations,
                            calibrated->canonical_from_source};
      for (Vec3& offset : spec.skeleton.offsets) {
        if (bound.left_handed) offset = rig::Mirrored(offset);
      }
      return rig::Binding::Make(std::move(spec));
    }
    if (!rests.value().empty()) {
      return BindByRests(std::move(skeleton.value()), std::move(rests.value()), map);
    }
    return BindByZeroPose(skeleton.value(), dialect, map, bound.dialect);
  };
  auto binding = bind();
  if (!binding.ok()) return binding.status();
  bound.toes_backwards = ToesPointBackwards(binding.value().spec());
  bound.binding = std::make_shared<const rig::Binding>(std::move(binding.value()));
  return bound;
}

}  // namespace styled::pipeline
