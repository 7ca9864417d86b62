#include "model/rig/tail.h"

#include <algorithm>
#include <optional>

namespace styled::rig {
namespace {

// The joints from `joint` up to `above`, both left out, parents first; empty if `above` is not
// above it.
std::optional<std::vector<int>> PathBelow(const Skeleton& skeleton, int above, int joint) {
  std::vector<int> path;
  for (int up = skeleton.parents[static_cast<std::size_t>(joint)]; up != above;
       up = skeleton.parents[static_cast<std::size_t>(up)]) {
    if (up < 0) return std::nullopt;
    path.push_back(up);
  }
  std::reverse(path.begin(), path.end());
  return path;
}

}  // namespace

const std::array<std::string_view, kTailCount> kTailNames = {
    "leftThumbMetacarpal",
    "leftThumbProximal",
    "leftThumbDistal",
    "leftIndexProximal",
    "leftIndexIntermediate",
    "leftIndexDistal",
    "leftMiddleProximal",
    "leftMiddleIntermediate",
    "leftMiddleDistal",
    "leftRingProximal",
    "leftRingIntermediate",
    "leftRingDistal",
    "leftLittleProximal",
    "leftLittleIntermediate",
    "leftLittleDistal",
    "rightThumbMetacarpal",
    "rightThumbProximal",
    "rightThumbDistal",
    "rightIndexProximal",
    "rightIndexIntermediate",
    "rightIndexDistal",
    "rightMiddleProximal",
    "rightMiddleIntermediate",
    "rightMiddleDistal",
    "rightRingProximal",
    "rightRingIntermediate",
    "rightRingDistal",
    "rightLittleProximal",
    "rightLittleIntermediate",
    "rightLittleDistal",
    "leftEye",
    "rightEye",
    "jaw",
};

TailMap Both(const TailMap& map, const TailMap& other) {
  TailMap both = map;
  for (std::size_t joint = 0; joint < both.size(); ++joint) {
    if (other[joint] < 0) both[joint] = -1;
  }
  return both;
}

Tail Tail::Make(const Binding& binding, const TailMap& map) {
  return Make(binding.spec(), binding.scale(), map);
}

Tail Tail::Make(const BindingSpec& spec, float scale, const TailMap& map) {
  Tail tail;
  const Skeleton& skeleton = spec.skeleton;
  std::array<int, kTailCount> place{};  // in joints_
  for (int t = 0; t < kTailCount; ++t) {
    const int source = map[static_cast<std::size_t>(t)];
    if (source <= 0 || source >= skeleton.joint_count()) continue;
    const auto* const end = spec.source_joint.end();
    if (std::find(spec.source_joint.begin(), end, source) != end) continue;
    int before = TailBefore(t);
    while (before >= 0 && tail.map_[static_cast<std::size_t>(before)] < 0)
      before = TailBefore(before);
    const int above = before >= 0 ? tail.map_[static_cast<std::size_t>(before)]
                                  : spec.source_joint[static_cast<std::size_t>(TailAnchor(t))];
    if (above < 0) continue;
    const auto path = PathBelow(skeleton, above, source);
    if (!path) continue;

    const auto rest = [&](int joint) {
      return spec.rest_rotations[static_cast<std::size_t>(joint)];
    };
    Vec3 offset = Vec3::Zero();
    int from = above;
    for (std::size_t i = 0; i <= path->size(); ++i) {
      const int to = i < path->size() ? (*path)[i] : source;
      offset += rest(from) * skeleton.offsets[static_cast<std::size_t>(to)];
      from = to;
    }
    place[static_cast<std::size_t>(t)] = static_cast<int>(tail.joints_.size());
    tail.map_[static_cast<std::size_t>(t)] = source;
    tail.joints_.push_back(
        {t,
         before < 0 ? TailAnchor(t) : body::kJointCount + place[static_cast<std::size_t>(before)],
         scale * (spec.canonical_from_source * offset)});
    Link link;
    link.joint = source;
    link.first = tail.between_.size();
    tail.between_.insert(tail.between_.end(), path->begin(), path->end());
    link.last = tail.between_.size();
    // change of the parent * tail = change of the joint, each world * conj(rest) in canonical axes.
    link.before = rest(above).conjugate() * spec.canonical_from_source.conjugate();
    link.after = spec.canonical_from_source * rest(source);
    tail.links_.push_back(link);
  }
  return tail;
}

Quat Tail::Between(const Link& link, std::span<const Quat> pose) const noexcept {
  Quat turn = Quat::Identity();
  for (std::size_t i = link.first; i < link.last; ++i) {
    turn = turn * pose[static_cast<std::size_t>(between_[i])];
  }
  return turn;
}

void Tail::Read(std::span<const Quat> pose, std::span<Quat> tail) const noexcept {
  for (std::size_t i = 0; i < links_.size(); ++i) {
    const Link& link = links_[i];
    const Quat turn = Between(link, pose) * pose[static_cast<std::size_t>(link.joint)];
    Quat read = (link.before.conjugate() * turn * link.after.conjugate()).normalized();
    if (read.dot(tail[i]) < 0) read.coeffs() = -read.coeffs();
    tail[i] = read;
  }
}

void Tail::Write(std::span<const Quat> tail, std::span<Quat> pose) const noexcept {
  for (std::size_t i = 0; i < links_.size(); ++i) Write(i, tail[i], pose);
}

void Tail::Write(std::size_t place, const Quat& turn, std::span<Quat> pose) const noexcept {
  const Link& link = links_[place];
  pose[static_cast<std::size_t>(link.joint)] =
      (Between(link, pose).conjugate() * (link.before * turn * link.after)).normalized();
}

}  // namespace styled::rig
