#include "clients/stylemon/figure.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "model/rig/dialects.h"

namespace styled::stylemon {
namespace {

using client::Transform;
using Eigen::Vector3f;

constexpr float kHeadroom = 1.22F;  // picture height over figure height
constexpr float kHumanHeight_m = 1.75F;
constexpr float kMarkEvery = 0.3F;  // floor marks, in figure heights

Ink InkOf(int canonical) {
  if (canonical >= body::kLeftShoulder && canonical <= body::kLeftHand) return Ink::kLeft;
  if (canonical >= body::kLeftUpperLeg && canonical <= body::kLeftToes) return Ink::kLeft;
  if (canonical >= body::kRightShoulder && canonical <= body::kRightHand) return Ink::kRight;
  if (canonical >= body::kRightUpperLeg) return Ink::kRight;
  return Ink::kCentre;
}

// Length of the bones from `joint` up to `ancestor`; 0 if either is missing.
float ChainLength(const v1::Body& body, int joint, int ancestor) {
  float length = 0;
  if (joint < 0 || ancestor < 0) return 0;
  for (; joint != ancestor; joint = body.parents(joint)) {
    if (joint <= 0) return 0;
    length += Eigen::Map<const Vector3f>(body.offsets().data() + 3 * joint).norm();
  }
  return length;
}

// Maps a point of the world to the picture.
struct Projection {
  Vector3f x_axis;
  Vector3f hips;
  float scale, middle, floor_y, floor;

  float X(const Vector3f& point) const { return middle + scale * x_axis.dot(point - hips); }
  float Y(const Vector3f& point) const { return floor_y - scale * (point.y() - floor); }
};

void DrawFloor(const Pose& pose, const Projection& view, const DotRect& area, Canvas& canvas) {
  const auto left = static_cast<float>(area.left);
  const auto right = static_cast<float>(area.left + area.width - 1);
  canvas.Line(left, view.floor_y, right, view.floor_y, Ink::kFloor, area);
  const float every = kMarkEvery * pose.height * view.scale;
  if (every < 4) return;
  const float near_middle = view.middle - std::fmod(pose.travel * view.scale, every);
  const float first = near_middle - every * std::ceil((near_middle - left) / every);
  if (!std::isfinite(first)) return;
  const int marks = static_cast<int>((right - first) / every) + 1;
  for (int mark = 0; mark < marks; ++mark) {
    const float x = first + every * static_cast<float>(mark);
    canvas.Line(x, view.floor_y, x, view.floor_y + 2, Ink::kFloor, area);
  }
}

void DrawContact(const Pose& pose, int foot, int toes, const Projection& view, const DotRect& area,
                 Canvas& canvas) {
  if (foot < 0) return;
  const float heel_x = view.X((*pose.joints)[foot].position);
  const float toes_x = toes < 0 ? heel_x : view.X((*pose.joints)[toes].position);
  const float begin = std::min(heel_x, toes_x) - 1, end = std::max(heel_x, toes_x) + 1;
  for (const float y : {view.floor_y, view.floor_y + 1}) {
    canvas.Line(begin, y, end, y, Ink::kContact, area);
  }
}

void DrawHead(const Pose& pose, const Projection& view, const DotRect& area, Canvas& canvas) {
  const int head = pose.anatomy->joint[body::kHead];
  if (head < 0) return;
  const int neck = pose.anatomy->parents[head];
  const Vector3f base = (*pose.joints)[head].position;
  const Vector3f below =
      neck < 0 ? Vector3f(base - Vector3f::UnitY()) : (*pose.joints)[neck].position;
  const Vector3f centre = base + 0.055F * pose.height * (base - below).stableNormalized();
  canvas.Circle(view.X(centre), view.Y(centre), 0.058F * pose.height * view.scale, Ink::kCentre,
                area);
}

void DrawBones(const Pose& pose, Ink ink, const Projection& view, const DotRect& area,
               Canvas& canvas) {
  const Anatomy& anatomy = *pose.anatomy;
  const int head = anatomy.joint[body::kHead];
  for (std::size_t joint = 1; joint < anatomy.parents.size(); ++joint) {
    const int parent = anatomy.parents[joint];
    if (anatomy.inks[joint] != ink || (head >= 0 && parent == head)) continue;
    const Vector3f& from = (*pose.joints)[parent].position;
    const Vector3f& to = (*pose.joints)[joint].position;
    canvas.Line(view.X(from), view.Y(from), view.X(to), view.Y(to), ink, area);
  }
}

}  // namespace

Anatomy Analyse(const v1::Body& body) {
  const int joints = body.names_size();
  rig::Skeleton skeleton;
  for (int joint = 0; joint < joints; ++joint) {
    skeleton.names.push_back(body.names(joint));
    skeleton.parents.push_back(body.parents(joint));
    skeleton.offsets.emplace_back(Eigen::Map<const Vector3f>(body.offsets().data() + 3 * joint));
  }
  Anatomy anatomy;
  anatomy.parents = skeleton.parents;
  anatomy.metres_per_unit = body.metres_per_unit();
  anatomy.joint = rig::MapJointNames(skeleton);
  std::vector<int> canonical(static_cast<std::size_t>(joints), -1);
  for (int c = 0; c < body::kJointCount; ++c) {
    if (anatomy.joint[c] >= 0) canonical[anatomy.joint[c]] = c;
  }
  anatomy.inks.assign(static_cast<std::size_t>(joints), Ink::kCentre);
  for (int joint = 0; joint < joints; ++joint) {  // fingers and twist joints belong to their limb
    const int parent = body.parents(joint);
    if (canonical[joint] < 0 && parent >= 0) canonical[joint] = canonical[parent];
    anatomy.inks[joint] = InkOf(canonical[joint]);
  }
  const int hips = anatomy.joint[body::kHips];
  const float leg = std::max(ChainLength(body, anatomy.joint[body::kLeftFoot], hips),
                             ChainLength(body, anatomy.joint[body::kRightFoot], hips));
  const float trunk = ChainLength(body, anatomy.joint[body::kHead], hips);
  // Adds the sole and the top of the head.
  if (leg > 0 && trunk > 0) anatomy.height = 1.14F * (leg + trunk);
  return anatomy;
}

bool Facing(const Anatomy& anatomy, const std::vector<Transform>& joints, float& yaw_rad) {
  Vector3f left = Vector3f::Zero();
  const auto add = [&](int canonical_left, int canonical_right) {
    const int l = anatomy.joint[canonical_left], r = anatomy.joint[canonical_right];
    if (l >= 0 && r >= 0) left += (joints[l].position - joints[r].position).stableNormalized();
  };
  add(body::kLeftUpperLeg, body::kRightUpperLeg);
  add(body::kLeftUpperArm, body::kRightUpperArm);
  const Vector3f forward = left.cross(Vector3f::UnitY());
  if (forward.norm() < 0.1F) return false;
  yaw_rad = std::atan2(forward.x(), forward.z());
  return true;
}

float Lowest(const std::vector<Transform>& joints) {
  float lowest = joints.empty() ? 0.0F : joints[0].position.y();
  for (const Transform& joint : joints) lowest = std::min(lowest, joint.position.y());
  return lowest;
}

float PictureHeight(const Anatomy& anatomy, float seen) {
  const float metres = anatomy.height * anatomy.metres_per_unit;
  if (metres > 0.6F && metres < 2.6F)
    return std::max(kHumanHeight_m, metres) / anatomy.metres_per_unit;
  if (anatomy.height > 0) return anatomy.height;
  return seen > 0 ? seen : 1.0F;
}

Vector3f PictureX(Side side, float yaw_rad) {
  const float sine = std::sin(yaw_rad), cosine = std::cos(yaw_rad);
  return side == Side::kSide ? Vector3f(sine, 0, cosine) : Vector3f(cosine, 0, -sine);
}

void Draw(const Pose& pose, const DotRect& area, Canvas& canvas) {
  if (pose.joints->empty() || !(pose.height > 0) || area.width < 4 || area.height < 8) return;
  const auto high = static_cast<float>(area.height - 3), wide = static_cast<float>(area.width);
  Projection view;
  view.x_axis = PictureX(pose.side, pose.yaw_rad);
  const int hips = std::max(0, pose.anatomy->joint[body::kHips]);
  view.hips = (*pose.joints)[hips].position;
  view.scale = std::min(high / (kHeadroom * pose.height), wide / (1.05F * pose.height));
  view.middle = static_cast<float>(area.left) + 0.5F * (wide - 1);
  view.floor_y = static_cast<float>(area.top) + high;
  view.floor = pose.floor;

  DrawFloor(pose, view, area, canvas);
  const std::array<int, body::kJointCount>& joint = pose.anatomy->joint;
  if ((pose.contacts & 1U) != 0) {
    DrawContact(pose, joint[body::kLeftFoot], joint[body::kLeftToes], view, area, canvas);
  }
  if ((pose.contacts & 2U) != 0) {
    DrawContact(pose, joint[body::kRightFoot], joint[body::kRightToes], view, area, canvas);
  }
  // Draw far to near: seen from the figure's right, the left limbs are behind.
  DrawBones(pose, Ink::kLeft, view, area, canvas);
  DrawBones(pose, Ink::kCentre, view, area, canvas);
  DrawHead(pose, view, area, canvas);
  DrawBones(pose, Ink::kRight, view, area, canvas);
}

}  // namespace styled::stylemon
