#pragma once

#include <array>

#include "model/body/humanoid.h"

namespace styled::rig {

// World rotations (source axes) of a dialect's joints in T-pose, by canonical joint.
struct RestRow {
  float x, y, z, w;
};
using RestTable = std::array<RestRow, body::kJointCount>;

// Bandai-Namco's BVH files: the result of RestBySwing for the first frame of
// dataset-2_raise-up-right-hand_normal_001.bvh. tests/unit/rig/dialects_test.cpp computes it again.
inline constexpr RestTable kBandaiNamcoRest = {{
    {-0.000000F, -0.000000F, 0.707107F, 0.707107F},   // hips
    {0.512038F, 0.489411F, 0.510294F, 0.487744F},     // spine
    {0.499975F, 0.500025F, 0.500025F, 0.499975F},     // chest
    {0.520913F, 0.457580F, 0.539092F, 0.478174F},     // neck
    {0.546829F, 0.427254F, 0.555652F, 0.457912F},     // head
    {-0.001472F, -0.000000F, 0.000000F, 0.999999F},   // leftShoulder
    {0.265371F, 0.000000F, -0.000000F, 0.964146F},    // leftUpperArm
    {0.344529F, 0.000000F, 0.000000F, 0.938776F},     // leftLowerArm
    {0.390213F, -0.060501F, 0.016442F, 0.918588F},    // leftHand
    {0.999945F, -0.000001F, -0.000000F, 0.010520F},   // rightShoulder
    {-0.959961F, 0.000006F, 0.000002F, 0.280134F},    // rightUpperArm
    {-0.929681F, -0.000002F, -0.000001F, 0.368366F},  // rightLowerArm
    {-0.909587F, 0.047108F, 0.032263F, 0.411571F},    // rightHand
    {-0.042675F, 0.042675F, -0.705818F, 0.705818F},   // leftUpperLeg
    {-0.041326F, 0.041325F, -0.705898F, 0.705898F},   // leftLowerLeg
    {-0.295058F, -0.307165F, -0.636907F, 0.642605F},  // leftFoot
    {-0.383796F, -0.396598F, -0.587716F, 0.591609F},  // leftToes
    {0.703947F, 0.704056F, 0.066552F, 0.065832F},     // rightUpperLeg
    {0.704071F, 0.704071F, 0.065457F, 0.065457F},     // rightLowerLeg
    {0.647111F, 0.631727F, -0.317681F, 0.285039F},    // rightFoot
    {0.586384F, 0.576773F, -0.418852F, 0.384773F},    // rightToes
}};

// Rokoko Studio: from its Unity helper, mirrored through x = 0 to be right-handed.
inline constexpr float kHalf = 0.70710678F;
inline constexpr RestTable kRokokoRest = {{
    {0, 0, 0, 1},               // hips
    {0, 0, 1, 0},               // spine
    {0, 0, 1, 0},               // chest
    {0, 0, 1, 0},               // neck
    {0, 0, 1, 0},               // head
    {0, 0, kHalf, kHalf},       // leftShoulder
    {0.5F, -0.5F, 0.5F, 0.5F},  // leftUpperArm
    {0.5F, -0.5F, 0.5F, 0.5F},  // leftLowerArm
    {0.5F, -0.5F, 0.5F, 0.5F},  // leftHand
    {0, 0, -kHalf, kHalf},      // rightShoulder
    {0.5F, 0.5F, -0.5F, 0.5F},  // rightUpperArm
    {0.5F, 0.5F, -0.5F, 0.5F},  // rightLowerArm
    {0.5F, 0.5F, -0.5F, 0.5F},  // rightHand
    {0, -kHalf, 0, kHalf},      // leftUpperLeg
    {0, -kHalf, 0, kHalf},      // leftLowerLeg
    {0, -kHalf, kHalf, 0},      // leftFoot
    {0, -kHalf, kHalf, 0},      // leftToes
    {0, kHalf, 0, kHalf},       // rightUpperLeg
    {0, kHalf, 0, kHalf},       // rightLowerLeg
    {0, kHalf, -kHalf, 0},      // rightFoot
    {0, kHalf, -kHalf, 0},      // rightToes
}};

// Thumbs stand away from the hand there: the first joint, and the two after it. From Rokoko's
// plug-ins, as proto/rigs/rokoko/joints.cpp has them, mirrored.
struct ThumbRest {
  RestRow first, others;
};
inline constexpr ThumbRest kRokokoLeftThumb{{0.561F, -0.701F, 0.430F, 0.092F},
                                            {0.653F, -0.653F, 0.271F, 0.271F}};
inline constexpr ThumbRest kRokokoRightThumb{{0.561F, 0.701F, -0.430F, 0.092F},
                                             {0.653F, 0.653F, -0.271F, 0.271F}};

}  // namespace styled::rig
