#include "model/rig/mirror.h"

#include <algorithm>
#include <cmath>

#include "model/body/humanoid.h"
#include "model/rig/axes.h"

namespace styled::rig {
namespace {

// On a body of the canonical size, relative to the parent. The sides of measured bodies differ: a
// shoulder of Xia's clips is 17 mm from the other one's reflection. Joints of one parent may be as
// near to each other (a face, locks of hair), so that the nearest is taken first.
constexpr float kSamePlace_m = 0.03F;
// Left of the skeleton's axes, and the hips' way from joint 0: what is smaller is rounding.
constexpr float kRounding = 1e-5F;

int TailPair(int tail) {
  if (tail == kTailJaw) return tail;
  if (tail >= kTailLeftEye) return tail == kTailLeftEye ? kTailRightEye : kTailLeftEye;
  return tail < kTailRightThumb ? tail + kTailRightThumb : tail - kTailRightThumb;
}

bool IsAncestor(const Skeleton& skeleton, int above, int joint) {
  int up = joint;
  do up = skeleton.parents[static_cast<std::size_t>(up)];
  while (up >= 0 && up != above);
  return up >= 0;
}

Quat RestOf(const Binding& binding, int joint) {
  return joint < 0 ? Quat::Identity()
                   : binding.spec().rest_rotations[static_cast<std::size_t>(joint)];
}

// From the parent to the joint in the T-pose, in source axes.
Vec3 RestOffset(const Binding& binding, int joint) {
  const auto j = static_cast<std::size_t>(joint);
  return RestOf(binding, binding.skeleton().parents[j]) * binding.skeleton().offsets[j];
}

}  // namespace

MirrorMap::MirrorMap(const Binding& binding, const TailMap& tail) {
  const BindingSpec& spec = binding.spec();
  const auto count = static_cast<std::size_t>(binding.skeleton().joint_count());
  left_ = spec.canonical_from_source.conjugate() * Vec3::UnitX();
  // A body's axes are mostly its coordinate axes: then a reflection only changes signs.
  if ((left_ - NearestAxis(left_)).norm() < kRounding) left_ = NearestAxis(left_);

  pair_.assign(count, -1);
  const auto pair = [this](int joint, int other) {
    if (joint >= 0 && other >= 0) pair_[static_cast<std::size_t>(joint)] = other;
  };
  for (int c = 0; c < body::kJointCount; ++c) {
    pair(spec.source_joint[static_cast<std::size_t>(c)],
         spec.source_joint[static_cast<std::size_t>(body::MirrorJoint(c))]);
  }
  const TailMap own = Tail::Make(binding, tail).map();
  for (int t = 0; t < kTailCount; ++t) {
    pair(own[static_cast<std::size_t>(t)], own[static_cast<std::size_t>(TailPair(t))]);
  }
  if (pair_[0] < 0) pair_[0] = 0;
  PairAbove(binding.skeleton());
  PairByPlace(binding);

  for (int joint = 0; joint < binding.skeleton().joint_count(); ++joint)
    links_.push_back(LinkOf(binding, joint));

  bool in_plane = true;
  for (int up = spec.source_joint[body::kHips]; up > 0;
       up = binding.skeleton().parents[static_cast<std::size_t>(up)]) {
    const auto j = static_cast<std::size_t>(up);
    to_hips_.emplace_back(j, binding.skeleton().offsets[j]);
    const float aside_m = std::abs(binding.scale() * RestOffset(binding, up).dot(left_));
    in_plane = in_plane && pair_[j] == up && aside_m < kRounding;
  }
  if (in_plane) to_hips_.clear();
  std::reverse(to_hips_.begin(), to_hips_.end());
}

// Of a pair whose ways up have as many joints without a pair: those. Helper joints often lie at the
// place of their parent, where their place says nothing.
void MirrorMap::PairAbove(const Skeleton& skeleton) {
  const auto unpaired_above = [&](int joint) {
    std::vector<int> way;
    for (int up = skeleton.parents[static_cast<std::size_t>(joint)]; up >= 0 && pair(up) < 0;
         up = skeleton.parents[static_cast<std::size_t>(up)]) {
      way.push_back(up);
    }
    return way;
  };
  for (int joint = 0; joint < skeleton.joint_count(); ++joint) {
    if (pair(joint) <= joint) continue;  // none, on the middle line, or done with its pair
    std::vector<int> here = unpaired_above(joint), there = unpaired_above(pair(joint));
    while (!here.empty() && !there.empty() && here.back() == there.back()) {
      here.pop_back();
      there.pop_back();
    }
    if (here.size() != there.size()) continue;
    for (std::size_t i = 0; i < here.size(); ++i) {
      pair_[static_cast<std::size_t>(here[i])] = there[i];
      pair_[static_cast<std::size_t>(there[i])] = here[i];
    }
  }
}

// Parents come before their children, so each pair's children are paired after the pair itself.
void MirrorMap::PairByPlace(const Binding& binding) {
  const Skeleton& skeleton = binding.skeleton();
  const auto unpaired_below = [&](int parent) {
    std::vector<int> children;
    for (int j = parent + 1; j < skeleton.joint_count(); ++j) {
      const auto at = static_cast<std::size_t>(j);
      if (skeleton.parents[at] == parent && pair_[at] < 0) children.push_back(j);
    }
    return children;
  };
  for (int parent = 0; parent < skeleton.joint_count(); ++parent) {
    const int other = pair_[static_cast<std::size_t>(parent)];
    if (other < parent) continue;  // none, or done with its pair
    struct Candidate {
      float apart_m;
      int joint, pair;
    };
    std::vector<Candidate> candidates;
    const std::vector<int> there = unpaired_below(other);
    for (const int joint : unpaired_below(parent)) {
      const Vec3 reflected = Reflected(RestOffset(binding, joint));
      for (const int k : there) {
        const float apart_m = binding.scale() * (reflected - RestOffset(binding, k)).norm();
        if (apart_m <= kSamePlace_m) candidates.push_back({apart_m, joint, k});
      }
    }
    std::stable_sort(candidates.begin(), candidates.end(),
                     [](const Candidate& a, const Candidate& b) { return a.apart_m < b.apart_m; });
    for (const Candidate& c : candidates) {
      int& one = pair_[static_cast<std::size_t>(c.joint)];
      int& two = pair_[static_cast<std::size_t>(c.pair)];
      if (one >= 0 || two >= 0) continue;
      one = c.pair;
      two = c.joint;
    }
  }
}

MirrorMap::Link MirrorMap::LinkOf(const Binding& binding, int joint) {
  const Skeleton& skeleton = binding.skeleton();
  const auto up = [&skeleton](int of) { return skeleton.parents[static_cast<std::size_t>(of)]; };
  Link link;
  link.from = pair(joint);
  if (link.from < 0) {
    link.before = RestOf(binding, up(joint)).conjugate() * RestOf(binding, joint);
    return link;
  }
  // The nearest joint above whose pair is above the pair; -1: the world.
  int top = up(joint);
  while (top >= 0 && (pair(top) < 0 || !IsAncestor(skeleton, pair(top), link.from))) top = up(top);
  const int top_from = top < 0 ? -1 : pair(top);
  const Quat half_turn(0, left_.x(), left_.y(), left_.z());
  link.before = RestOf(binding, top).conjugate() * half_turn * RestOf(binding, top_from);
  link.after =
      RestOf(binding, link.from).conjugate() * half_turn.conjugate() * RestOf(binding, joint);
  link.above_from = PathBelow(skeleton, top_from, link.from);
  link.above = PathBelow(skeleton, top, joint);
  return link;
}

// Appends the joints between `top` and `joint`, both left out.
MirrorMap::Range MirrorMap::PathBelow(const Skeleton& skeleton, int top, int joint) {
  Range range{between_.size(), between_.size()};
  for (int up = skeleton.parents[static_cast<std::size_t>(joint)]; up != top;
       up = skeleton.parents[static_cast<std::size_t>(up)]) {
    between_.push_back(up);
  }
  range.last = between_.size();
  std::reverse(between_.begin() + static_cast<std::ptrdiff_t>(range.first), between_.end());
  return range;
}

void MirrorMap::Apply(const RigPose& pose, RigPose& mirrored) const noexcept {
  for (std::size_t j = 0; j < links_.size(); ++j) {
    const Link& link = links_[j];
    if (link.from < 0) {
      mirrored.rotations[j] = link.before;
      continue;
    }
    Quat turn = link.before;
    for (std::size_t i = link.above_from.first; i < link.above_from.last; ++i) {
      turn = turn * pose.rotations[static_cast<std::size_t>(between_[i])];
    }
    turn = turn * pose.rotations[static_cast<std::size_t>(link.from)] * link.after;
    for (std::size_t i = link.above.first; i < link.above.last; ++i) {
      turn = mirrored.rotations[static_cast<std::size_t>(between_[i])].conjugate() * turn;
    }
    mirrored.rotations[j] = turn;
  }
  mirrored.translations[0] = Reflected(pose.translations[0]);
  if (to_hips_.empty()) return;
  mirrored.translations[0] += Reflected(ToHips(pose)) - ToHips(mirrored);
}

// From joint 0 to the hips, in the skeleton's axes.
Vec3 MirrorMap::ToHips(const RigPose& pose) const noexcept {
  Vec3 way = Vec3::Zero();
  Quat above = pose.rotations[0];
  for (const auto& [joint, offset] : to_hips_) {
    way += above * offset;
    above = above * pose.rotations[joint];
  }
  return way;
}

Vec3 MirrorMap::Reflected(const Vec3& position) const noexcept {
  return position - 2 * left_.dot(position) * left_;
}

// An axis of rotation turns by half a turn about the left axis.
Quat MirrorMap::Reflected(const Quat& rotation) const noexcept {
  Quat reflected = rotation;
  reflected.vec() = 2 * left_.dot(rotation.vec()) * left_ - rotation.vec();
  return reflected;
}

}  // namespace styled::rig
