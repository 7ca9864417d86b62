#include "sim/rigs/qtm_skeleton.h"

#include <limits>

namespace styled::rigs {
namespace {

using body::Quat;
using body::Vec3;

constexpr int kNone = -1;
// A segment at `joint`, or, for those that the canonical humanoid lacks, at `share` of the way from
// `joint` to `next`, with the rotation of `joint`.
struct Row {
  std::string_view name;
  int parent;
  int joint;
  int next = kNone;
  float share = 0;
};
constexpr std::array<Row, kQtmSegments> kRows{{
    {"Hips", -1, body::kHips},
    {"Spine", 0, body::kSpine},
    {"Spine1", 1, body::kChest},
    {"Spine2", 2, body::kChest, body::kNeck, 0.5F},
    {"Neck", 3, body::kNeck},
    {"Head", 4, body::kHead},
    {"LeftShoulder", 3, body::kLeftShoulder},
    {"LeftArm", 6, body::kLeftUpperArm},
    {"LeftForeArm", 7, body::kLeftLowerArm},
    {"LeftForeArmRoll", 8, body::kLeftLowerArm, body::kLeftHand, 0.5F},
    {"LeftHand", 9, body::kLeftHand},
    {"RightShoulder", 3, body::kRightShoulder},
    {"RightArm", 11, body::kRightUpperArm},
    {"RightForeArm", 12, body::kRightLowerArm},
    {"RightForeArmRoll", 13, body::kRightLowerArm, body::kRightHand, 0.5F},
    {"RightHand", 14, body::kRightHand},
    {"LeftUpLeg", 0, body::kLeftUpperLeg},
    {"LeftLeg", 16, body::kLeftLowerLeg},
    {"LeftFoot", 17, body::kLeftFoot},
    {"LeftToeBase", 18, body::kLeftToes},
    {"RightUpLeg", 0, body::kRightUpperLeg},
    {"RightLeg", 20, body::kRightLowerLeg},
    {"RightFoot", 21, body::kRightFoot},
    {"RightToeBase", 22, body::kRightToes},
}};

// The world rotation of a segment's frame in the T-pose: arms and legs have frames of their own.
Quat RestOf(std::size_t s) {
  const std::string_view name = kRows[s].name;
  const bool left = name.starts_with("Left");
  if (name.find("Arm") != name.npos || name.find("Hand") != name.npos) {
    return Quat(Eigen::AngleAxisf(left ? -1.57079633F : 1.57079633F, Vec3::UnitZ()));
  }
  if (name.find("Leg") != name.npos) return Quat(Eigen::AngleAxisf(3.14159265F, Vec3::UnitX()));
  return s == 0 ? Quat(Eigen::AngleAxisf(0.3F, Vec3::UnitY())) : Quat::Identity();
}

// From +Y up, facing +Z, to +Z up, facing -Y.
Quat ZUp() { return Quat(Eigen::AngleAxisf(1.57079633F, Vec3::UnitX())); }

struct World {
  std::array<Vec3, kQtmSegments> positions_m;
  std::array<Quat, kQtmSegments> rotations;
};

World WorldOf(const body::Pose& pose, bool z_up) {
  body::WorldPose canonical;
  body::ForwardKinematics(pose, canonical);
  const Quat turn = z_up ? ZUp() : Quat::Identity();
  World world;
  for (std::size_t s = 0; s < kQtmSegments; ++s) {
    const Row& row = kRows[s];
    const auto joint = static_cast<std::size_t>(row.joint);
    Vec3 at = canonical.positions_m[joint];
    if (row.next != kNone) {
      at += row.share * (canonical.positions_m[static_cast<std::size_t>(row.next)] - at);
    }
    world.positions_m[s] = turn * at;
    world.rotations[s] = (turn * canonical.rotations[joint] * RestOf(s)).normalized();
  }
  return world;
}

// Relative to the parent, millimetres.
void ToLocal(const World& world, std::size_t s, Vec3& position_mm, Quat& rotation) {
  position_mm = 1000 * world.positions_m[s];
  rotation = world.rotations[s];
  if (kRows[s].parent < 0) return;
  const auto parent = static_cast<std::size_t>(kRows[s].parent);
  const Quat back = world.rotations[parent].conjugate();
  position_mm = 1000 * (back * (world.positions_m[s] - world.positions_m[parent]));
  rotation = back * world.rotations[s];
}

}  // namespace

std::array<float, 3> ToQtm(const Vec3& point_m, bool z_up) {
  const Vec3 at = 1000 * (z_up ? Vec3(ZUp() * point_m) : point_m);
  return {at.x(), at.y(), at.z()};
}

qtm::SkeletonDescription DescribeQtmSkeleton(std::string_view name, std::uint32_t first_id,
                                             bool z_up, bool flat) {
  const World world = WorldOf(body::Pose(), z_up);
  qtm::SkeletonDescription out;
  out.name = name;
  out.global = flat;
  for (std::size_t s = 0; s < kQtmSegments; ++s) {
    Vec3 position_mm;
    Quat rotation;
    ToLocal(world, s, position_mm, rotation);
    if (flat) {
      position_mm = 1000 * world.positions_m[s];
      rotation = world.rotations[s];
    }
    out.segments.push_back({std::string(kRows[s].name),
                            first_id + static_cast<std::uint32_t>(s),
                            kRows[s].parent,
                            {position_mm.x(), position_mm.y(), position_mm.z()},
                            {rotation.x(), rotation.y(), rotation.z(), rotation.w()}});
  }
  return out;
}

void PlaceQtmSkeleton(const body::Pose& pose, std::uint32_t first_id, bool z_up,
                      qtm::SkeletonPose& out) {
  body::Pose whole = pose;
  for (Quat& rotation : whole.rotations) {
    if (!rotation.coeffs().allFinite()) rotation = Quat::Identity();
  }
  const World world = WorldOf(whole, z_up);
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  out.segment_count = kQtmSegments;
  for (std::size_t s = 0; s < kQtmSegments; ++s) {
    Vec3 p;
    Quat q;
    ToLocal(world, s, p, q);
    const auto joint = static_cast<std::size_t>(kRows[s].joint);
    if (!pose.rotations[joint].coeffs().allFinite() && kRows[s].next == kNone) {
      p = Vec3::Constant(kNan);
      q.coeffs().setConstant(kNan);
    }
    out.segments[s] = {first_id + static_cast<std::uint32_t>(s),
                       {p.x(), p.y(), p.z()},
                       {q.x(), q.y(), q.z(), q.w()}};
  }
}

}  // namespace styled::rigs
