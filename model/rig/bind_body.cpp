#include "model/rig/bind_body.h"

#include <array>
#include <cmath>
#include <set>
#include <span>
#include <utility>
#include <vector>

#include "model/rig/axes.h"
#include "model/rig/calibration.h"

namespace styled::rig {
namespace {

using BodyMap = std::array<int, body::kJointCount>;

// Positions of the joints in the T-pose of the rests, in source axes.
std::vector<Vec3> RestPositions(const BindingSpec& spec) {
  std::vector<Vec3> positions(spec.skeleton.offsets);
  for (std::size_t j = 1; j < positions.size(); ++j) {
    const auto parent = static_cast<std::size_t>(spec.skeleton.parents[j]);
    positions[j] = positions[parent] + spec.rest_rotations[parent] * spec.skeleton.offsets[j];
  }
  return positions;
}

// Finds which source axes are left, up and forward in the T-pose of the rests.
Status FindAxes(BindingSpec& spec) {
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
  if (left.isZero() || up.isZero() || left.dot(up) != 0)
    return Status::Error("body: rest: does not make a T-pose");
  Eigen::Matrix3f axes;
  // The rows are the canonical axes in source coordinates, so the matrix maps source to canonical.
  // left x up is forward, which makes it a rotation.
  axes.row(0) = left;
  axes.row(1) = up;
  axes.row(2) = left.cross(up);
  spec.canonical_from_source = Quat(axes).normalized();
  return Status::Ok();
}

// That T-pose as a pose; without one the zero pose.
RigPose RestPose(const Skeleton& skeleton, const std::vector<Quat>& rests) {
  RigPose pose(skeleton);
  for (std::size_t j = 0; j < rests.size(); ++j) {
    const int parent = skeleton.parents[j];
    pose.rotations[j] =
        parent < 0 ? rests[j] : rests[static_cast<std::size_t>(parent)].conjugate() * rests[j];
  }
  return pose;
}

Result<Binding> BindByRests(Skeleton skeleton, std::vector<Quat> rests, const BodyMap& map) {
  BindingSpec spec;
  spec.source_joint = map;
  spec.skeleton = std::move(skeleton);
  spec.rest_rotations = std::move(rests);
  const Status status = FindAxes(spec);
  if (!status.ok()) return status;
  return Binding::Make(std::move(spec));
}

// By a dialect; a zero pose that stands upright with its arms down is a rest pose, too.
Result<Binding> BindByZeroPose(const Skeleton& skeleton, const std::string& dialect,
                               const BodyMap& map, std::string& used) {
  auto bound = BindMapped(skeleton, dialect, &used, map);
  if (bound.ok() || dialect != "auto" || !CanCalibrate(map).ok()) return bound;
  auto standing = BindStanding(skeleton, map, RigPose(skeleton), false);
  if (!standing.ok()) return bound;
  used = "standing";
  return standing;
}

}  // namespace

bool ToesPointBackwards(const BindingSpec& spec) {
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

Status CheckBody(const RigBody& body) {
  const Skeleton& skeleton = body.skeleton;
  const int joints = skeleton.joint_count();
  if (joints < 1 || joints > kMaxSourceJoints) {
    return Status::Error("body: found " + std::to_string(joints) + " joints, expected 1 to " +
                         std::to_string(kMaxSourceJoints));
  }
  std::set<std::string> names;
  for (int j = 0; j < joints; ++j) {
    const auto refuse = [j](const std::string& what) {
      return Status::Error("body: joint " + std::to_string(j) + ": " + what);
    };
    const auto at = static_cast<std::size_t>(j);
    const std::string& name = skeleton.names[at];
    if (name.empty() || name.size() > 128) return refuse("name is empty or too long");
    if (!names.insert(name).second) return refuse("name \"" + name + "\" is used twice");
    const int parent = skeleton.parents[at];
    if (j == 0 ? parent != -1 : parent < 0 || parent >= j) {
      return refuse("parent " + std::to_string(parent) +
                    (j == 0 ? ", expected -1" : ", expected an earlier joint"));
    }
    if (!skeleton.offsets[at].allFinite()) return refuse("offset is not finite");
    if (!body.rest.empty() && !(std::abs(body.rest[at].norm() - 1.0F) < 1e-3F)) {
      return refuse("rest is not of unit length");
    }
  }
  return Status::Ok();
}

Result<HumanoidMap> MapBody(const RigBody& body, const JointNames& given) {
  const RigPose rest = RestPose(body.skeleton, body.rest);
  return FindHumanoid(body.skeleton, given, std::span(&rest, 1));
}

Result<BoundBody> BindBody(const RigBody& body, const JointNames& given) {
  const Status status = CheckBody(body);
  if (!status.ok()) return status;
  const auto found = MapBody(body, given);
  if (!found.ok()) return found.status();
  BoundBody bound{nullptr, "given", false, found.value().remark};
  auto binding = body.rest.empty() ? BindByZeroPose(body.skeleton, body.dialect,
                                                    found.value().joint, bound.dialect)
                                   : BindByRests(body.skeleton, body.rest, found.value().joint);
  if (!binding.ok()) return binding.status();
  bound.toes_backwards = ToesPointBackwards(binding.value().spec());
  bound.binding = std::make_shared<const Binding>(std::move(binding.value()));
  return bound;
}

}  // namespace styled::rig
