#pragma once

#include <array>
#include <string_view>

// The joints of Rokoko Studio's actors, and the T-pose to which its poses refer. Names and
// reference rotations are facts of Rokoko's own plug-ins for Unity and Blender.
namespace styled::rokoko {

// Body (23), then the fingers of the left hand (20) and of the right: thumb, index, middle, ring,
// little, each proximal, medial, distal, tip. Parents precede their children.
inline constexpr int kBodyJoints = 23;
inline constexpr int kFingerJoints = 20;  // of one hand
inline constexpr int kJoints = kBodyJoints + 2 * kFingerJoints;

struct JointRow {
  std::string_view name;
  int parent;  // -1: the root
  // World rotation in the T-pose, facing +Z, as on the wire (left-handed); x, y, z, w.
  std::array<float, 4> t_pose;
};
extern const std::array<JointRow, kJoints> kJointTable;

inline constexpr int kHip = 0, kSpine = 1, kChest = 2, kNeck = 3, kHead = 4;
inline constexpr int kLeftShoulder = 5, kLeftHand = 8, kRightShoulder = 9, kRightHand = 12;
inline constexpr int kLeftUpLeg = 13, kLeftToe = 16, kRightUpLeg = 18, kRightToe = 21;

// The joint of that name, or -1. Tries `hint` first, because senders keep an order.
int FindJoint(std::string_view name, int hint) noexcept;

}  // namespace styled::rokoko
