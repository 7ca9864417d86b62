#pragma once

#include <cmath>
#include <numbers>
#include <vector>

#include "model/body/heading.h"

namespace styled::judge {

inline constexpr double kRate_hz = 60;
inline constexpr float kStrides_hz = 0.9F;  // of both legs: 108 steps a minute
inline constexpr float kSwing_rad = 0.4F, kKnee_rad = 0.35F, kArm_rad = 0.5F;

// Six seconds of straight legs that swing against each other, bent at the knees by a constant,
// walking towards `yaw_rad`; the hips rise and fall by 2 cm twice a stride.
inline std::vector<body::Pose> Walk(float yaw_rad, float strides_hz = kStrides_hz,
                                    float speed_mps = 1.3F) {
  std::vector<body::Pose> poses;
  for (int i = 0; i < 360; ++i) {
    const float time_s = static_cast<float>(i / kRate_hz);
    const float phase = 2 * std::numbers::pi_v<float> * strides_hz * time_s;
    body::Pose pose;
    pose.hips_position_m =
        body::Yaw(yaw_rad) * body::Vec3(0, 0.9F + 0.02F * std::sin(2 * phase), speed_mps * time_s);
    pose.rotations[body::kHips] = body::Yaw(yaw_rad);
    const float swing = kSwing_rad * std::sin(phase);
    pose.rotations[body::kLeftUpperLeg] = body::Exp(body::Vec3(-swing, 0, 0));
    pose.rotations[body::kRightUpperLeg] = body::Exp(body::Vec3(swing, 0, 0));
    for (const int knee : {body::kLeftLowerLeg, body::kRightLowerLeg}) {
      pose.rotations[static_cast<std::size_t>(knee)] = body::Exp(body::Vec3(kKnee_rad, 0, 0));
    }
    const body::Quat down = body::Exp(body::Vec3(0, 0, -std::numbers::pi_v<float> / 2));
    const float arm = kArm_rad * std::sin(phase);
    pose.rotations[body::kLeftUpperArm] = body::Exp(body::Vec3(arm, 0, 0)) * down;
    pose.rotations[body::kRightUpperArm] = body::Exp(body::Vec3(-arm, 0, 0)) * down.conjugate();
    poses.push_back(pose);
  }
  return poses;
}

}  // namespace styled::judge
