#pragma once

#include <cmath>

#include "model/clip/clip.h"

namespace styled::clip {

using rig::Quat;
using rig::Vec3;

// A smooth motion defined at every instant: a root on a curve, and a swinging joint.
inline rig::RigPose At(double t_s) {
  rig::RigPose pose;
  const auto f = [](double value) { return static_cast<float>(value); };
  pose.translations = {
      Vec3(f(150 * t_s), f(90 + 3 * std::sin(12 * t_s)), f(20 * std::cos(3 * t_s))),
      Vec3(0.1F, 17.3F, 0.7F)};
  pose.rotations = {
      Quat(Eigen::AngleAxisf(f(2.5 * t_s), Vec3::UnitY())),
      Quat(Eigen::AngleAxisf(f(0.8 * std::sin(7 * t_s)), Vec3(1, 2, -1).normalized()))};
  return pose;
}

inline Clip Waving(double rate_hz, int frames) {
  Clip clip;
  clip.skeleton.names = {"root", "joint"};
  clip.skeleton.parents = {-1, 0};
  clip.skeleton.offsets = {Vec3::Zero(), Vec3(0.1F, 17.3F, 0.7F)};
  clip.channels = {"XYZzxy", "zxy"};
  clip.end_sites = {{}, {Vec3(1, 2, 3)}};
  clip.rate_hz = rate_hz;
  for (int frame = 0; frame < frames; ++frame) clip.frames.push_back(At(frame / rate_hz));
  return clip;
}

}  // namespace styled::clip
