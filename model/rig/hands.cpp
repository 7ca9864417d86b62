#include "model/rig/hands.h"

#include <algorithm>
#include <array>
#include <string>
#include <utility>

#include "model/rig/axes.h"

namespace styled::rig {
namespace {

// A finger, palm down: where it begins in the left hand's frame, its direction, and the lengths of
// its two inner bones.
struct Finger {
  std::array<float, 3> begin_m, along;
  float lengths_m[2];
};
constexpr std::array<Finger, kFingersPerHand> kFingers{{
    {{0.025F, -0.01F, 0.025F}, {0.74F, 0, 0.67F}, {0.035F, 0.03F}},
    {{0.09F, 0, 0.025F}, {1, 0, 0}, {0.035F, 0.025F}},
    {{0.092F, 0, 0.004F}, {1, 0, 0}, {0.04F, 0.027F}},
    {{0.086F, 0, -0.016F}, {1, 0, 0}, {0.037F, 0.026F}},
    {{0.078F, 0, -0.034F}, {1, 0, 0}, {0.029F, 0.019F}},
}};

// Whether the skeleton has a joint further out in the same finger.
bool HasBeyond(const TailMap& own, int joint) {
  for (int next = joint + 1; next % kFingerJoints != 0; ++next) {
    if (own[static_cast<std::size_t>(next)] >= 0) return true;
  }
  return false;
}

// The directions that follow from the hands, in source axes; not of unit length.
struct Directions {
  std::array<Vec3, 2> left{Vec3::Zero(), Vec3::Zero()};  // according to each hand
  Vec3 forward = Vec3::Zero();
};
Directions Look(const Tail& tail) {
  Directions look;
  Vec3 index_side = Vec3::Zero();  // where the hand's first finger begins
  int hand = -1;
  for (const Tail::Joint& joint : tail.joints()) {
    const bool thumb = joint.joint % kHandTail < kFingerJoints;
    if (joint.parent >= body::kJointCount || thumb) continue;
    if (std::exchange(hand, joint.parent) != joint.parent) index_side = joint.offset_m;
    if (joint.parent == body::kLeftHand) {
      look.left[0] += joint.offset_m;
    } else {
      look.left[1] -= joint.offset_m;
    }
    look.forward += index_side - joint.offset_m;
  }
  return look;
}

}  // namespace

TailSet FingersOf(body::Joint hand) {
  TailSet fingers;
  for (int t = 0; t < kTailLeftEye; ++t) {
    if (TailAnchor(t) == hand) fingers.set(static_cast<std::size_t>(t));
  }
  return fingers;
}

Vec3 FingerOffset_m(int joint) {
  const Finger& finger = kFingers[static_cast<std::size_t>(joint % kHandTail / kFingerJoints)];
  const int bone = joint % kFingerJoints;
  Vec3 offset_m(finger.begin_m.data());
  if (bone > 0) offset_m = finger.lengths_m[bone - 1] * Vec3(finger.along.data());
  if (joint >= kTailRightThumb) offset_m.x() = -offset_m.x();
  return offset_m;
}

Binding WithFingers(const Binding& binding, const TailSet& wanted) {
  BindingSpec spec = binding.spec();
  Skeleton& skeleton = spec.skeleton;
  const TailMap own = Tail::Make(binding, FindTail(skeleton, binding.spec().source_joint)).map();
  TailMap place = own;
  for (int t = 0; t < kTailLeftEye; ++t) {
    const auto at = static_cast<std::size_t>(t);
    const std::string name(kTailNames[at]);
    if (!wanted[at] || own[at] >= 0 || HasBeyond(own, t) ||
        std::ranges::find(skeleton.names, name) != skeleton.names.end()) {
      continue;
    }
    int before = TailBefore(t);
    while (before >= 0 && place[static_cast<std::size_t>(before)] < 0) before = TailBefore(before);
    const int parent = before >= 0 ? place[static_cast<std::size_t>(before)]
                                   : spec.source_joint[static_cast<std::size_t>(TailAnchor(t))];
    if (parent < 0) continue;
    const Quat rest = spec.rest_rotations[static_cast<std::size_t>(parent)];
    place[at] = skeleton.joint_count();
    skeleton.names.push_back(name);
    skeleton.parents.push_back(parent);
    skeleton.offsets.emplace_back(rest.conjugate() * (spec.canonical_from_source.conjugate() *
                                                      (FingerOffset_m(t) / binding.scale())));
    spec.rest_rotations.push_back(rest);
  }
  auto grown = Binding::Make(std::move(spec));
  if (!grown.ok()) return binding;
  return std::move(grown.value());
}

Result<BindingSpec> BindHands(const Skeleton& skeleton, const std::vector<Quat>& rest,
                              const JointNames& given) {
  const auto joints = MapJoints(skeleton, given);
  if (!joints.ok()) return joints.status();
  BindingSpec spec;
  spec.skeleton = skeleton;
  spec.source_joint.fill(-1);
  for (const body::Joint hand : {body::kLeftHand, body::kRightHand}) {
    spec.source_joint[hand] = joints.value()[hand];
  }
  spec.rest_rotations = rest;
  if (rest.empty()) spec.rest_rotations.assign(skeleton.names.size(), Quat::Identity());
  const Tail tail = Tail::Make(spec, 1, FindTail(skeleton, spec.source_joint));
  if (std::ranges::none_of(tail.joints(),
                           [](const Tail::Joint& joint) { return joint.joint < kTailLeftEye; })) {
    return Status::Error(
        "body: found no finger below a hand; expected e.g. leftHand, leftIndexProximal, "
        "leftIndexIntermediate, leftIndexDistal");
  }
  const Directions look = Look(tail);
  const Vec3 left = NearestAxis(look.left[0] + look.left[1]);
  if (left.isZero()) return spec;
  Vec3 forward = NearestAxis(look.forward);
  if (forward.isZero()) forward = left.cross(Vec3::UnitY());
  const bool agree = std::ranges::all_of(
      look.left, [&](const Vec3& one) { return one.isZero() || NearestAxis(one) == left; });
  if (!agree || left.dot(forward) != 0 || forward.isZero()) {
    return Status::Error(
        "body: rest: the hands do not lie flat as in a T-pose; expected fingers that point "
        "sideways, and the index finger in front of the little one");
  }
  Eigen::Matrix3f axes;  // rows: the canonical axes in source coordinates
  axes.row(0) = left;
  axes.row(1) = forward.cross(left);
  axes.row(2) = forward;
  spec.canonical_from_source = Quat(axes).normalized();
  return spec;
}

}  // namespace styled::rig
