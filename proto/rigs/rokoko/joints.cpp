#include "proto/rigs/rokoko/joints.h"

namespace styled::rokoko {
namespace {

constexpr float kHalf = 0.70710678F;
using Turn = std::array<float, 4>;
constexpr Turn kUpright{0, 0, 1, 0};
constexpr Turn kLeftArm{-0.5F, -0.5F, 0.5F, -0.5F}, kRightArm{0.5F, -0.5F, 0.5F, 0.5F};
constexpr Turn kLeftThigh{0, kHalf, 0, kHalf}, kRightThigh{0, -kHalf, 0, kHalf};
constexpr Turn kLeftSole{0, kHalf, -kHalf, 0}, kRightSole{0, -kHalf, kHalf, 0};
constexpr Turn kLeftThumb{-0.561F, -0.701F, 0.430F, -0.092F};
constexpr Turn kRightThumb{0.561F, -0.701F, 0.430F, 0.092F};
constexpr Turn kLeftThumbEnd{-0.653F, -0.653F, 0.271F, -0.271F};
constexpr Turn kRightThumbEnd{0.653F, -0.653F, 0.271F, 0.271F};

}  // namespace

// The plug-ins state no rotation for tips and toe ends; they get that of the joint before them.
const std::array<JointRow, kJoints> kJointTable{{
    {"hip", -1, {0, 0, 0, 1}},
    {"spine", 0, kUpright},
    {"chest", 1, kUpright},
    {"neck", 2, kUpright},
    {"head", 3, kUpright},
    {"leftShoulder", 2, {0, 0, kHalf, -kHalf}},
    {"leftUpperArm", 5, kLeftArm},
    {"leftLowerArm", 6, kLeftArm},
    {"leftHand", 7, kLeftArm},
    {"rightShoulder", 2, {0, 0, kHalf, kHalf}},
    {"rightUpperArm", 9, kRightArm},
    {"rightLowerArm", 10, kRightArm},
    {"rightHand", 11, kRightArm},
    {"leftUpLeg", 0, kLeftThigh},
    {"leftLeg", 13, kLeftThigh},
    {"leftFoot", 14, kLeftSole},
    {"leftToe", 15, kLeftSole},
    {"leftToeEnd", 16, kLeftSole},
    {"rightUpLeg", 0, kRightThigh},
    {"rightLeg", 18, kRightThigh},
    {"rightFoot", 19, kRightSole},
    {"rightToe", 20, kRightSole},
    {"rightToeEnd", 21, kRightSole},
    {"leftThumbProximal", 8, kLeftThumb},
    {"leftThumbMedial", 23, kLeftThumbEnd},
    {"leftThumbDistal", 24, kLeftThumbEnd},
    {"leftThumbTip", 25, kLeftThumbEnd},
    {"leftIndexProximal", 8, kLeftArm},
    {"leftIndexMedial", 27, kLeftArm},
    {"leftIndexDistal", 28, kLeftArm},
    {"leftIndexTip", 29, kLeftArm},
    {"leftMiddleProximal", 8, kLeftArm},
    {"leftMiddleMedial", 31, kLeftArm},
    {"leftMiddleDistal", 32, kLeftArm},
    {"leftMiddleTip", 33, kLeftArm},
    {"leftRingProximal", 8, kLeftArm},
    {"leftRingMedial", 35, kLeftArm},
    {"leftRingDistal", 36, kLeftArm},
    {"leftRingTip", 37, kLeftArm},
    {"leftLittleProximal", 8, kLeftArm},
    {"leftLittleMedial", 39, kLeftArm},
    {"leftLittleDistal", 40, kLeftArm},
    {"leftLittleTip", 41, kLeftArm},
    {"rightThumbProximal", 12, kRightThumb},
    {"rightThumbMedial", 43, kRightThumbEnd},
    {"rightThumbDistal", 44, kRightThumbEnd},
    {"rightThumbTip", 45, kRightThumbEnd},
    {"rightIndexProximal", 12, kRightArm},
    {"rightIndexMedial", 47, kRightArm},
    {"rightIndexDistal", 48, kRightArm},
    {"rightIndexTip", 49, kRightArm},
    {"rightMiddleProximal", 12, kRightArm},
    {"rightMiddleMedial", 51, kRightArm},
    {"rightMiddleDistal", 52, kRightArm},
    {"rightMiddleTip", 53, kRightArm},
    {"rightRingProximal", 12, kRightArm},
    {"rightRingMedial", 55, kRightArm},
    {"rightRingDistal", 56, kRightArm},
    {"rightRingTip", 57, kRightArm},
    {"rightLittleProximal", 12, kRightArm},
    {"rightLittleMedial", 59, kRightArm},
    {"rightLittleDistal", 60, kRightArm},
    {"rightLittleTip", 61, kRightArm},
}};

int FindJoint(std::string_view name, int hint) noexcept {
  if (hint >= 0 && hint < kJoints && kJointTable[static_cast<std::size_t>(hint)].name == name) {
    return hint;
  }
  for (int joint = 0; joint < kJoints; ++joint) {
    if (kJointTable[static_cast<std::size_t>(joint)].name == name) return joint;
  }
  return -1;
}

}  // namespace styled::rokoko
