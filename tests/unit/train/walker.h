#pragma once

#include <cmath>

#include "model/body/heading.h"
#include "model/train/dataset.h"

namespace styled::train {

// The canonical humanoid with its hands by its sides.
inline body::Pose HandsDown() {
  body::Pose pose;
  pose.rotations[body::kLeftUpperArm] = body::Exp(body::Vec3(0, 0, -1.4F));
  pose.rotations[body::kRightUpperArm] = body::Exp(body::Vec3(0, 0, 1.4F));
  return pose;
}

// A figure that walks along a curve, swinging arms and legs: every joint moves, the heading turns.
inline TrainingClip Walker(int frames, float phase = 0.0F) {
  TrainingClip clip;
  const erd::FeatureParameters parameters;
  erd::FeatureState state;
  erd::Features features;
  for (int t = 0; t < frames; ++t) {
    const float time_s = static_cast<float>(t) / 30.0F;
    body::Pose pose;
    pose.hips_position_m += body::Vec3(std::sin(time_s), 0.03F * std::sin(9.0F * time_s), time_s);
    for (int joint = 0; joint < body::kJointCount; ++joint) {
      const float swing = 0.4F * std::sin(4.0F * time_s + static_cast<float>(joint) + phase);
      pose.rotations[joint] = body::Exp(body::Vec3(swing, 0.3F * swing, -0.2F * swing));
    }
    pose.rotations[body::kHips] = body::Yaw(0.7F * time_s) * pose.rotations[body::kHips];
    clip.poses.push_back(pose);
    erd::ComputeFeatures(pose, parameters, state, features);
    clip.heading_cos.push_back(state.heading_cos);
    clip.heading_sin.push_back(state.heading_sin);
  }
  return clip;
}

}  // namespace styled::train
