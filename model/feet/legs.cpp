#include "model/feet/legs.h"

#include <utility>

namespace styled::feet {
namespace {

constexpr std::array<std::array<int, 4>, kLegs> kLegJoints = {{
    {body::kLeftUpperLeg, body::kLeftLowerLeg, body::kLeftFoot, body::kLeftToes},
    {body::kRightUpperLeg, body::kRightLowerLeg, body::kRightFoot, body::kRightToes},
}};

bool HangsBelow(const rig::Skeleton& skeleton, int joint, int above) {
  while (joint > above) joint = skeleton.parents[static_cast<std::size_t>(joint)];
  return joint == above;
}

}  // namespace

Legs::Legs(const rig::Binding& binding)
    : metres_per_unit_(binding.scale()),
      canonical_from_source_(binding.spec().canonical_from_source) {
  const rig::BindingSpec& spec = binding.spec();
  const rig::Skeleton& skeleton = spec.skeleton;
  // Select the joints on the paths from the root to the hips and the feet.
  std::vector<bool> needed(skeleton.names.size(), false);
  const auto need = [&](int joint) {
    for (; joint >= 0; joint = skeleton.parents[static_cast<std::size_t>(joint)]) {
      needed[static_cast<std::size_t>(joint)] = true;
    }
  };
  need(spec.source_joint[body::kHips]);
  for (const auto& names : kLegJoints) {
    for (const int joint : names) need(spec.source_joint[static_cast<std::size_t>(joint)]);
  }
  std::vector<int> index(needed.size(), -1);
  for (std::size_t joint = 0; joint < needed.size(); ++joint) {
    if (!needed[joint]) continue;
    index[joint] = static_cast<int>(joints_.size());
    joints_.push_back(static_cast<int>(joint));
    const int parent = skeleton.parents[joint];
    parents_.push_back(parent < 0 ? -1 : index[static_cast<std::size_t>(parent)]);
  }
  const auto at = [&](int joint) {
    return joint < 0 ? -1 : index[static_cast<std::size_t>(joint)];
  };
  hips_ = at(spec.source_joint[body::kHips]);

  // Heights in the T-pose, relative to the root, from world rest rotations.
  std::vector<float> rest_height_m(joints_.size(), 0.0F);
  for (std::size_t i = 1; i < joints_.size(); ++i) {
    const auto joint = static_cast<std::size_t>(joints_[i]);
    const auto parent = static_cast<std::size_t>(skeleton.parents[joint]);
    const Vec3 bone = spec.rest_rotations[parent] * skeleton.offsets[joint];
    rest_height_m[i] = rest_height_m[static_cast<std::size_t>(parents_[i])] +
                       metres_per_unit_ * (canonical_from_source_ * bone).y();
  }
  for (std::size_t side = 0; side < legs_.size(); ++side) {
    std::array<int, 4> source{};
    for (std::size_t i = 0; i < source.size(); ++i) {
      source[i] = spec.source_joint[static_cast<std::size_t>(kLegJoints[side][i])];
    }
    const auto [upper, lower, foot, toes] = source;
    Leg& leg = legs_[side];
    leg.upper = at(upper);
    leg.lower = at(lower);
    leg.foot = at(foot);
    if (foot < 0 || !HangsBelow(skeleton, lower, upper) || !HangsBelow(skeleton, foot, lower) ||
        !HangsBelow(skeleton, upper, spec.source_joint[body::kHips])) {
      continue;
    }
    leg.resolved = true;
    if (toes >= 0 && HangsBelow(skeleton, toes, foot)) {
      leg.toes = at(toes);
      leg.ankle_above_toes_m = rest_height_m[static_cast<std::size_t>(leg.foot)] -
                               rest_height_m[static_cast<std::size_t>(leg.toes)];
    }
    // The body's left (canonical +X) in a joint's own frame in the T-pose.
    const auto left_in = [&](int joint) -> Vec3 {
      const Quat& rest = spec.rest_rotations[static_cast<std::size_t>(joint)];
      return (canonical_from_source_ * rest).conjugate() * Vec3::UnitX();
    };
    leg.hinge_in_upper = left_in(upper);
    leg.across_foot = left_in(foot);
  }
}

void Legs::Place(const PoseView& pose, std::span<Placed> placed) const noexcept {
  for (std::size_t i = 0; i < joints_.size(); ++i) {
    const auto joint = static_cast<std::size_t>(joints_[i]);
    const int parent = parents_[i];
    const Vec3 step = metres_per_unit_ * pose.translations[joint];
    if (parent < 0) {
      placed[i] = {canonical_from_source_ * step, canonical_from_source_ * pose.rotations[joint]};
    } else {
      const Placed& above = placed[static_cast<std::size_t>(parent)];
      placed[i] = {above.position_m + above.rotation * step,
                   above.rotation * pose.rotations[joint]};
    }
  }
}

Quat Legs::ParentRotation(int index, std::span<const Placed> placed) const noexcept {
  const int parent = parents_[static_cast<std::size_t>(index)];
  return parent < 0 ? canonical_from_source_ : placed[static_cast<std::size_t>(parent)].rotation;
}

rig::Binding HumanoidBinding() {
  rig::BindingSpec spec;
  for (int joint = 0; joint < body::kJointCount; ++joint) {
    const body::JointRow& row = body::kHumanoid[static_cast<std::size_t>(joint)];
    spec.skeleton.names.emplace_back(row.name);
    spec.skeleton.parents.push_back(row.parent);
    spec.skeleton.offsets.push_back(body::Offset(joint));
    spec.source_joint[static_cast<std::size_t>(joint)] = joint;
    spec.rest_rotations.push_back(Quat::Identity());
  }
  return rig::Binding::Make(std::move(spec)).value();
}

}  // namespace styled::feet
