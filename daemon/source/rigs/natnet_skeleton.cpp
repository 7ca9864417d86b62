#include "daemon/source/rigs/natnet_skeleton.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string_view>

#include "daemon/source/rigs/world_pose.h"
#include "proto/rigs/types.h"

namespace styled::source {
namespace {

using rig::Quat;
using rig::Vec3;

constexpr int kPatience = 10;  // frames

std::int32_t Masked(std::int32_t id) { return id & 0xFFFF; }

Vec3 YFromZ(const Vec3& v) { return {v.x(), v.z(), -v.y()}; }
Quat YFromZ(const Quat& q) { return {q.w(), q.x(), q.z(), -q.y()}; }
Vec3 ZFromY(const Vec3& v) { return {v.x(), -v.z(), v.y()}; }

Vec3 PositionOf(const natnet::Bone& bone) {
  return {bone.position_m[0], bone.position_m[1], bone.position_m[2]};
}
Quat RotationOf(const natnet::Bone& bone) {
  const auto& r = bone.rotation;
  return {r[3], r[0], r[1], r[2]};
}

Quat Nan() {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  return {kNan, kNan, kNan, kNan};
}

// Sorts the bones so that parents precede their children; returns indices into the description.
// Incomplete if there is a second root, an unknown parent or a cycle.
std::vector<std::size_t> SortBones(const natnet::SkeletonDescription& description,
                                   std::vector<int>& parents) {
  std::vector<std::size_t> order;
  std::vector<bool> placed(description.bone_count, false);
  for (bool grew = true; grew && order.size() < description.bone_count;) {
    grew = false;
    for (std::size_t b = 0; b < description.bone_count; ++b) {
      if (placed[b]) continue;
      const auto& bone = description.bones[b];
      int parent = -1;
      if (bone.parent > 0) {
        const auto found = std::ranges::find_if(order, [&](std::size_t other) {
          return Masked(description.bones[other].id) == Masked(bone.parent);
        });
        if (found == order.end()) continue;
        parent = static_cast<int>(found - order.begin());
      } else if (!order.empty()) {
        continue;  // a second root
      }
      order.push_back(b);
      parents.push_back(parent);
      placed[b] = grew = true;
    }
  }
  return order;
}

// The bone's name without prefix. Motive may put the skeleton's name and '_' or ':' before every
// bone's name, and give the root the skeleton's name.
std::string NameOf(const natnet::SkeletonDescription& description,
                   const natnet::BoneDescription& bone) {
  const auto prefixed = [&](std::string_view name) {
    const std::size_t size = description.name.size();
    return size > 0 && name.size() > size + 1 && name.starts_with(description.name) &&
           (name[size] == '_' || name[size] == ':');
  };
  if (bone.parent <= 0 && bone.name == description.name) return "Hip";
  const auto begin = description.bones.begin();
  const bool all =
      std::all_of(begin, begin + static_cast<std::ptrdiff_t>(description.bone_count),
                  [&](const auto& other) { return other.parent <= 0 || prefixed(other.name); });
  if (!all || !prefixed(bone.name)) return std::string(bone.name);
  return std::string(bone.name.substr(description.name.size() + 1));
}

// Whether the offsets are +Z up: a body in the T-pose is tall and wide, but not deep.
bool IsZUp(const rig::Skeleton& skeleton) {
  Vec3 lowest = Vec3::Zero(), highest = Vec3::Zero();
  std::vector<Vec3> positions(skeleton.offsets.size(), Vec3::Zero());
  for (std::size_t j = 1; j < positions.size(); ++j) {
    positions[j] = positions[static_cast<std::size_t>(skeleton.parents[j])] + skeleton.offsets[j];
    lowest = lowest.cwiseMin(positions[j]);
    highest = highest.cwiseMax(positions[j]);
  }
  const Vec3 extent = highest - lowest;
  return extent.z() > extent.y();
}

}  // namespace

Result<NatNetSkeleton> NatNetSkeleton::Make(const natnet::SkeletonDescription& description) {
  NatNetSkeleton made;
  rig::Skeleton& skeleton = made.body_.skeleton;
  const auto order = SortBones(description, skeleton.parents);
  if (order.empty() || order.size() < description.bone_count) {
    return Status::Error("skeleton " + std::string(description.name) + ": " +
                         std::to_string(description.bone_count - order.size()) + " of " +
                         std::to_string(description.bone_count) +
                         " bones are not below one root bone");
  }
  for (const std::size_t b : order) {
    const auto& bone = description.bones[b];
    std::string name = NameOf(description, bone);
    // Text that is not UTF-8 would make the whole body unreadable; no rig's joint names need more
    // than ASCII.
    std::ranges::replace_if(
        name, [](char c) { return c < ' ' || c > '~'; }, '_');
    skeleton.names.push_back(std::move(name));
    skeleton.offsets.emplace_back(bone.offset_m[0], bone.offset_m[1], bone.offset_m[2]);
    made.ids_.push_back(Masked(bone.id));
    made.places_.push_back(b);
  }
  if (IsZUp(skeleton)) {
    for (Vec3& offset : skeleton.offsets) offset = YFromZ(offset);
  }
  made.body_.metres_per_unit = 1;
  made.body_.dialect = rigs::kNatNet.dialect;
  made.world_.resize(order.size());
  return made;
}

const natnet::Bone* NatNetSkeleton::Find(const natnet::Skeleton& bones, std::size_t j,
                                         bool flags) const noexcept {
  const auto usable = [flags](const natnet::Bone& bone) {
    return (bone.tracked || !flags) && IsRotation(RotationOf(bone)) && PositionOf(bone).allFinite();
  };
  // Usually the bones are in the description's order.
  const std::size_t place = places_[j];
  if (place < bones.bone_count && bones.bones[place].description_id() == ids_[j]) {
    return usable(bones.bones[place]) ? &bones.bones[place] : nullptr;
  }
  for (std::size_t b = 0; b < bones.bone_count; ++b) {
    if (bones.bones[b].description_id() != ids_[j]) continue;
    return usable(bones.bones[b]) ? &bones.bones[b] : nullptr;
  }
  return nullptr;
}

void NatNetSkeleton::Convert(const natnet::Skeleton& bones, NatNetConvention convention, bool flags,
                             rig::RigPose& pose) noexcept {
  for (std::size_t j = 0; j < ids_.size(); ++j) {
    const natnet::Bone* bone = Find(bones, j, flags);
    world_[j] = bone != nullptr ? RotationOf(*bone).normalized() : Nan();
    if (convention.z_up) world_[j] = YFromZ(world_[j]);
    if (j == 0 && bone != nullptr) {
      const Vec3 place = PositionOf(*bone);
      pose.translations.front() = convention.z_up ? YFromZ(place) : place;
    }
  }
  if (convention.local) {
    std::ranges::copy(world_, pose.rotations.begin());
  } else {
    LocalFromWorld(body_.skeleton.parents, world_, pose);
  }
}

void ConvertRigidBody(const natnet::Bone& body, NatNetConvention convention, Vec3& position,
                      Quat& rotation) noexcept {
  position = convention.z_up ? YFromZ(PositionOf(body)) : PositionOf(body);
  rotation = convention.z_up ? YFromZ(RotationOf(body)) : RotationOf(body);
}

void NatNetSkeleton::AddMisfits(const natnet::Skeleton& bones, bool flags,
                                std::array<float, 4>& misfits) const noexcept {
  // Under the right convention the bone lies at its described offset: in the parent's frame if
  // positions are global, as sent if they are local.
  for (std::size_t j = 1; j < ids_.size(); ++j) {
    const natnet::Bone* bone = Find(bones, j, flags);
    const natnet::Bone* parent =
        Find(bones, static_cast<std::size_t>(body_.skeleton.parents[j]), flags);
    if (bone == nullptr || parent == nullptr) continue;
    const Vec3 local = PositionOf(*bone);
    const Vec3 global =
        RotationOf(*parent).normalized().conjugate() * (local - PositionOf(*parent));
    const Vec3& y_up = body_.skeleton.offsets[j];
    const Vec3 z_up = ZFromY(y_up);
    misfits[0] += (global - y_up).norm();
    misfits[1] += (global - z_up).norm();
    misfits[2] += (local - y_up).norm();
    misfits[3] += (local - z_up).norm();
  }
}

NatNetConventionFinder::NatNetConventionFinder(const std::string& coordinates,
                                               const std::string& up) {
  int count = 0;
  for (std::size_t i = 0; i < allowed_.size(); ++i) {
    const bool local = (i & 2U) != 0, z_up = (i & 1U) != 0;
    allowed_[i] = coordinates != (local ? "global" : "local") && up != (z_up ? "y" : "z");
    if (!allowed_[i]) continue;
    if (count++ == 0) current_ = i;
  }
  known_ = count == 1;
}

bool NatNetConventionFinder::Evaluate(const std::array<float, 4>& misfits) noexcept {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  std::size_t best = 0;
  float least = kInfinity, second = kInfinity;
  for (std::size_t i = 0; i < misfits.size(); ++i) {
    if (!allowed_[i]) continue;
    if (misfits[i] < least) {
      second = least;
      least = misfits[i];
      best = i;
    } else {
      second = std::min(second, misfits[i]);
    }
  }
  // Conclusive: the right convention misses by millimetres, a wrong one by the size of a body.
  const bool tells = std::isfinite(second) && least < 0.5F * second;
  if (!tells || (known_ && best == current_)) {
    if (tells) others_ = 0;
    return false;
  }
  others_ = best == other_ ? others_ + 1 : 1;
  other_ = best;
  if (known_ && others_ < kPatience) return false;
  current_ = best;
  known_ = true;
  others_ = 0;
  return true;
}

}  // namespace styled::source
