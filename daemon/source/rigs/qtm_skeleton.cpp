#include "daemon/source/rigs/qtm_skeleton.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "daemon/source/rigs/world_pose.h"

namespace styled::source {
namespace {

using rig::Quat;
using rig::Vec3;

Quat RotationOf(const qtm::Segment& segment) {
  const auto& r = segment.rotation;
  return {r[3], r[0], r[1], r[2]};
}
Vec3 PositionOf(const qtm::Segment& segment) {
  return {segment.position_mm[0], segment.position_mm[1], segment.position_mm[2]};
}

// A body's message has to be UTF-8; no rig's joint names need more than ASCII.
std::string AsciiName(std::string name) {
  std::ranges::replace_if(
      name, [](char c) { return c < ' ' || c > '~'; }, '_');
  return name;
}

}  // namespace

Quat YUpFrom(qtm::Axis up) {
  const std::array<Vec3, 6> axes{Vec3::UnitX(),        Vec3::UnitY(),        Vec3::UnitZ(),
                                 Vec3(-Vec3::UnitX()), Vec3(-Vec3::UnitY()), Vec3(-Vec3::UnitZ())};
  // Upside down, there is no shortest rotation; this one is about x.
  if (up == qtm::Axis::kMinusY) return {0, 1, 0, 0};
  return body::ShortestTurn(axes[static_cast<std::size_t>(up)], Vec3::UnitY()).normalized();
}

Result<QtmSkeleton> QtmSkeleton::Make(const qtm::SkeletonDescription& description, qtm::Axis up) {
  const auto refuse = [&description](const std::string& what) {
    return Status::Error("skeleton " + qtm::ToString(description.name) + ": " + what);
  };
  const auto& segments = description.segments;
  if (segments.empty()) return refuse("found no segments, expected one root at least");
  if (const std::size_t found = segments.size() + description.segments_left_out;
      found > qtm::kMaxSegments) {
    return refuse("found " + std::to_string(found) + " segments, expected at most " +
                  std::to_string(qtm::kMaxSegments));
  }
  QtmSkeleton made;
  made.y_up_ = YUpFrom(up);
  rig::Skeleton& skeleton = made.body_.skeleton;
  std::vector<Quat> rotations;  // as described
  for (const qtm::SegmentDescription& segment : segments) {
    const bool first = skeleton.names.empty();
    if ((segment.parent < 0) != first) return refuse("found several roots, expected one");
    std::string name = AsciiName(segment.name);
    if (std::ranges::find(skeleton.names, name) != skeleton.names.end() ||
        std::ranges::find(made.ids_, segment.id) != made.ids_.end()) {
      return refuse("segment " + name + ": its name, or its ID " + std::to_string(segment.id) +
                    ", is another's");
    }
    const auto& r = segment.rotation;
    const Quat rotation = Quat(Eigen::Quaterniond(r[3], r[0], r[1], r[2]).cast<float>());
    if (!IsRotation(rotation)) {
      return refuse("segment " + name + ": its T-pose has no valid rotation");
    }
    skeleton.names.push_back(std::move(name));
    skeleton.parents.push_back(segment.parent);
    const auto& p = segment.position_mm;
    skeleton.offsets.emplace_back(Eigen::Vector3d(p[0], p[1], p[2]).cast<float>());
    rotations.push_back(rotation.normalized());
    made.ids_.push_back(segment.id);
  }
  // Offsets from the parents in the parents' frames, and rotations in the world.
  if (description.global) {
    const std::vector<Vec3> positions = skeleton.offsets;
    OffsetsFromWorld(skeleton.parents, positions, rotations, skeleton.offsets);
  } else {
    for (std::size_t j = 1; j < rotations.size(); ++j) {
      rotations[j] = rotations[static_cast<std::size_t>(skeleton.parents[j])] * rotations[j];
    }
  }
  for (const Quat& rotation : rotations) {
    made.body_.rest.push_back((made.y_up_ * rotation).normalized());
  }
  skeleton.offsets.front() = made.y_up_ * skeleton.offsets.front();
  made.body_.metres_per_unit = 0.001F;
  return made;
}

const qtm::Segment* QtmSkeleton::Find(const qtm::SkeletonPose& segments,
                                      std::size_t joint) const noexcept {
  // Usually in the description's order.
  if (joint < segments.segment_count && segments.segments[joint].id == ids_[joint]) {
    return &segments.segments[joint];
  }
  for (std::size_t s = 0; s < segments.segment_count; ++s) {
    if (segments.segments[s].id == ids_[joint]) return &segments.segments[s];
  }
  return nullptr;
}

bool QtmSkeleton::Convert(const qtm::SkeletonPose& segments, rig::RigPose& pose) const noexcept {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  bool any = false;
  for (std::size_t j = 0; j < ids_.size(); ++j) {
    const qtm::Segment* segment = Find(segments, j);
    any = any || segment != nullptr;
    pose.rotations[j] = Quat(kNan, kNan, kNan, kNan);
    if (segment == nullptr || !IsRotation(RotationOf(*segment))) continue;
    const Quat rotation = RotationOf(*segment).normalized();
    if (j > 0) {
      pose.rotations[j] = rotation;
      continue;
    }
    const Vec3 position = PositionOf(*segment);
    if (!position.allFinite()) continue;
    pose.rotations[0] = y_up_ * rotation;
    pose.translations.front() = y_up_ * position;
  }
  return any;
}

}  // namespace styled::source
