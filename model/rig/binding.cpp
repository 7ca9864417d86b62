#include "model/rig/binding.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "model/base/text.h"

namespace styled::rig {
namespace {

using body::kHumanoid;
using body::kJointCount;

constexpr std::array kRequired = {
    body::kHips,          body::kHead,          body::kLeftUpperArm, body::kLeftLowerArm,
    body::kRightUpperArm, body::kRightLowerArm, body::kLeftUpperLeg, body::kLeftLowerLeg,
    body::kRightUpperLeg, body::kRightLowerLeg,
};

Status ValidateSkeleton(const Skeleton& skeleton) {
  const int count = skeleton.joint_count();
  if (count == 0) return Status::Error("skeleton: found no joints, expected at least the hips");
  if (count > kMaxSourceJoints) {
    return Status::Error("skeleton: found " + std::to_string(count) + " joints, expected at most " +
                         std::to_string(kMaxSourceJoints));
  }
  if (skeleton.parents.size() != skeleton.names.size() ||
      skeleton.offsets.size() != skeleton.names.size()) {
    return Status::Error("skeleton: found " + std::to_string(skeleton.parents.size()) +
                         " parents and " + std::to_string(skeleton.offsets.size()) +
                         " offsets, expected " + std::to_string(count) + " of each");
  }
  for (int joint = 0; joint < count; ++joint) {
    const int parent = skeleton.parents[joint];
    if (joint == 0 ? parent != -1 : (parent < 0 || parent >= joint)) {
      return Status::Error("skeleton: joint " + std::to_string(joint) + " (" +
                           skeleton.names[joint] + "): found parent " + std::to_string(parent) +
                           ", expected " + (joint == 0 ? "-1" : "an earlier joint"));
    }
    const Vec3& offset = skeleton.offsets[joint];
    if (!offset.allFinite() || offset.cwiseAbs().maxCoeff() > 1e6F) {  // false for NaN as well
      return Status::Error("skeleton: joint " + skeleton.names[joint] +
                           ": found an offset that is not finite or beyond a million units, "
                           "expected less");
    }
  }
  return Status::Ok();
}

Status ValidateMapping(const BindingSpec& spec) {
  const int count = spec.skeleton.joint_count();
  std::vector<int> user(count, -1);
  for (int c = 0; c < kJointCount; ++c) {
    const int source = spec.source_joint[c];
    if (source == -1) continue;
    const std::string name(kHumanoid[c].name);
    if (source < -1 || source >= count) {
      return Status::Error("binding: " + name + ": found source joint " + std::to_string(source) +
                           ", expected -1 to " + std::to_string(count - 1));
    }
    if (user[source] >= 0) {
      return Status::Error("binding: found source joint " + spec.skeleton.names[source] + " for " +
                           std::string(kHumanoid[user[source]].name) + " and for " + name +
                           ", expected one canonical joint for each");
    }
    user[source] = c;
  }
  std::string missing;
  for (int c : kRequired) {
    if (spec.source_joint[c] < 0) missing.append(" ").append(kHumanoid[c].name);
  }
  if (!missing.empty()) return Status::Error("binding: found no source joint for" + missing);
  return Status::Ok();
}

Status ValidateRest(const BindingSpec& spec) {
  if (spec.rest_rotations.size() != spec.skeleton.names.size()) {
    return Status::Error("binding: found " + std::to_string(spec.rest_rotations.size()) +
                         " rest rotations, expected " +
                         std::to_string(spec.skeleton.joint_count()) + ", one per source joint");
  }
  const auto unit = [](const Quat& q) { return std::abs(q.norm() - 1.0F) < 1e-3F; };
  for (std::size_t joint = 0; joint < spec.rest_rotations.size(); ++joint) {
    if (!unit(spec.rest_rotations[joint])) {
      return Status::Error("binding: rest rotation of " + spec.skeleton.names[joint] +
                           ": found length " + NumberText(spec.rest_rotations[joint].norm()) +
                           ", expected 1");
    }
  }
  if (!unit(spec.canonical_from_source)) {
    return Status::Error("binding: canonical_from_source: found length " +
                         NumberText(spec.canonical_from_source.norm()) + ", expected 1");
  }
  return Status::Ok();
}

// The height of the hips above the lowest of `joints` in the T-pose: in source units, and on the
// canonical humanoid in metres.
struct HipsHeight {
  float source = 0, canonical_m = 0;
};
HipsHeight HeightAbove(const BindingSpec& spec, std::array<body::Joint, 2> joints) {
  // The rest rotations are world rotations, so heights follow without composing local rotations.
  std::vector<float> height(spec.skeleton.joint_count(), 0.0F);
  for (int joint = 1; joint < spec.skeleton.joint_count(); ++joint) {
    const int parent = spec.skeleton.parents[joint];
    const Vec3 bone = spec.rest_rotations[parent] * spec.skeleton.offsets[joint];
    height[joint] = height[parent] + (spec.canonical_from_source * bone).y();
  }
  HipsHeight result;
  for (int c : joints) {
    const int source = spec.source_joint[c];
    if (source < 0) continue;
    const float below = height[spec.source_joint[body::kHips]] - height[source];
    if (below <= result.source) continue;
    result.source = below;
    result.canonical_m = 0;
    for (int up = c; up != body::kHips; up = kHumanoid[up].parent) {
      result.canonical_m -= kHumanoid[up].y_m;
    }
  }
  return result;
}

}  // namespace

Result<Binding> Binding::Make(BindingSpec spec) {
  if (Status status = ValidateSkeleton(spec.skeleton); !status.ok()) return status;
  if (Status status = ValidateMapping(spec); !status.ok()) return status;
  if (Status status = ValidateRest(spec); !status.ok()) return status;
  for (Quat& rest : spec.rest_rotations) rest.normalize();
  spec.canonical_from_source.normalize();

  HipsHeight height = HeightAbove(spec, {body::kLeftToes, body::kRightToes});
  if (height.source <= 0) height = HeightAbove(spec, {body::kLeftFoot, body::kRightFoot});
  if (height.source <= 1e-9F) {
    return Status::Error(
        "binding: found no foot or toes below the hips in the T-pose, expected at least one "
        "(check rest rotations and up axis)");
  }

  Binding binding;
  binding.scale_ = height.canonical_m / height.source;
  binding.canonical_joint_.assign(spec.skeleton.joint_count(), -1);
  for (int c = 0; c < kJointCount; ++c) {
    if (spec.source_joint[c] >= 0) binding.canonical_joint_[spec.source_joint[c]] = c;
  }
  for (int up = spec.source_joint[body::kHips]; up >= 0; up = spec.skeleton.parents[up]) {
    binding.hips_chain_.push_back(up);
  }
  std::reverse(binding.hips_chain_.begin(), binding.hips_chain_.end());
  binding.spec_ = std::move(spec);
  return binding;
}

void Binding::Bind(const RigPose& source, body::Pose& pose) const noexcept {
  const std::vector<int>& parents = spec_.skeleton.parents;
  const Quat& canonical_from_source = spec_.canonical_from_source;
  std::array<Quat, kMaxSourceJoints> source_world;
  for (int joint = 0; joint < spec_.skeleton.joint_count(); ++joint) {
    source_world[joint] =
        joint == 0 ? source.rotations[0] : source_world[parents[joint]] * source.rotations[joint];
  }

  // change = source_world * conj(rest): the world rotation away from the T-pose. It is the same for
  // both skeletons.
  std::array<Quat, kJointCount> world;
  for (int c = 0; c < kJointCount; ++c) {
    const int parent = kHumanoid[c].parent;
    const Quat parent_world = parent < 0 ? Quat::Identity() : world[parent];
    const int joint = spec_.source_joint[c];
    if (joint < 0) {
      world[c] = parent_world;
      pose.rotations[c] = Quat::Identity();
      continue;
    }
    const Quat change = source_world[joint] * spec_.rest_rotations[joint].conjugate();
    world[c] = canonical_from_source * change * canonical_from_source.conjugate();
    Quat local = (parent_world.conjugate() * world[c]).normalized();
    if (local.w() < 0) local.coeffs() = -local.coeffs();
    pose.rotations[c] = local;
  }

  // The hips' world position: forward kinematics along the chain from the root.
  Vec3 hips = Vec3::Zero();
  for (int joint : hips_chain_) {
    const int parent = parents[joint];
    if (parent < 0) {
      hips = source.translations[joint];
    } else {
      hips += source_world[parent] * source.translations[joint];
    }
  }
  pose.hips_position_m = scale_ * (canonical_from_source * hips);
}

void Binding::Unbind(const body::Pose& pose, const RigPose& received, RigPose& out) const noexcept {
  const std::vector<int>& parents = spec_.skeleton.parents;
  const Quat& canonical_from_source = spec_.canonical_from_source;
  std::array<Quat, kJointCount> world;
  for (int c = 0; c < kJointCount; ++c) {
    const int parent = kHumanoid[c].parent;
    world[c] = parent < 0 ? pose.rotations[c] : world[parent] * pose.rotations[c];
  }

  std::array<Quat, kMaxSourceJoints> out_world;
  for (int joint = 0; joint < spec_.skeleton.joint_count(); ++joint) {
    const Quat parent_world = joint == 0 ? Quat::Identity() : out_world[parents[joint]];
    out.translations[joint] = received.translations[joint];
    const int c = canonical_joint_[joint];
    if (c < 0) {
      out.rotations[joint] = received.rotations[joint];
    } else {
      const Quat change = canonical_from_source.conjugate() * world[c] * canonical_from_source;
      const Quat target = change * spec_.rest_rotations[joint];
      Quat local = (parent_world.conjugate() * target).normalized();
      if (local.dot(received.rotations[joint]) < 0) local.coeffs() = -local.coeffs();
      out.rotations[joint] = local;
    }
    out_world[joint] = parent_world * out.rotations[joint];
  }

  // Joints above the hips stay as received; the hips' own translation puts them in place.
  const Vec3 hips = canonical_from_source.conjugate() * (pose.hips_position_m / scale_);
  Vec3 parent_position = Vec3::Zero();
  for (int joint : hips_chain_) {
    const int parent = parents[joint];
    const Quat parent_world = parent < 0 ? Quat::Identity() : out_world[parent];
    if (joint == spec_.source_joint[body::kHips]) {
      out.translations[joint] = parent_world.conjugate() * (hips - parent_position);
    } else {
      parent_position += parent_world * out.translations[joint];
    }
  }
}

Vec3 Binding::RootPosition(const RigPose& pose) const noexcept {
  Vec3 position = pose.translations[0];
  Quat parent_world = pose.rotations[0];
  for (std::size_t i = 1; i < hips_chain_.size(); ++i) {
    const int joint = hips_chain_[i];
    // The difference between the joint's translation and its offset is moved to joint 0.
    position += parent_world * (pose.translations[joint] - spec_.skeleton.offsets[joint]);
    parent_world = parent_world * pose.rotations[joint];
  }
  return position;
}

void WorldTransforms(const Skeleton& skeleton, const RigPose& pose, std::vector<Vec3>& positions,
                     std::vector<Quat>& rotations) {
  positions.resize(skeleton.joint_count());
  rotations.resize(skeleton.joint_count());
  for (int joint = 0; joint < skeleton.joint_count(); ++joint) {
    const int parent = skeleton.parents[joint];
    if (parent < 0) {
      positions[joint] = pose.translations[joint];
      rotations[joint] = pose.rotations[joint];
    } else {
      positions[joint] = positions[parent] + rotations[parent] * pose.translations[joint];
      rotations[joint] = rotations[parent] * pose.rotations[joint];
    }
  }
}

}  // namespace styled::rig
