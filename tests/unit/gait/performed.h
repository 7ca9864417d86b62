#pragma once

#include <string>
#include <vector>

#include "model/body/heading.h"
#include "model/gait/tracker.h"
#include "model/gait/velocity.h"
#include "model/synthetic/performer.h"

namespace styled::gait {

inline constexpr float kDegree = tuning::kTurn_rad / 360;

inline std::vector<body::Pose> Perform(const std::string& script, double seconds,
                                       double rate_hz = 60) {
  synthetic::Performer performer({.seed = 1, .script = synthetic::ParseScript(script).value()});
  std::vector<body::Pose> poses;
  for (int i = 0; i < static_cast<int>(seconds * rate_hz); ++i) {
    performer.Pose(i / rate_hz, poses.emplace_back());
  }
  return poses;
}

// A tracker with all that it is fed from: poses in, the phase out.
struct Follower {
  Tracker tracker;
  Velocity velocity;
  bool first = true;

  const Phase& Follow(const body::Pose& pose, float dt_s) {
    if (first) dt_s = 0;
    first = false;
    body::WorldPose world;
    body::ForwardKinematics(pose, world);
    velocity.Follow(pose.hips_position_m, dt_s);
    tracker.Follow(world, body::Heading_rad(world), velocity.mps(), dt_s);
    return tracker.phase();
  }
};

inline std::vector<Phase> PhasesOf(const std::vector<body::Pose>& poses, double rate_hz = 60) {
  Follower follower;
  std::vector<Phase> phases;
  for (const body::Pose& pose : poses) {
    phases.push_back(follower.Follow(pose, static_cast<float>(1 / rate_hz)));
  }
  return phases;
}

// The angle between two phases, rad, -pi .. pi.
inline float Between_rad(float a_rad, float b_rad) {
  const float between = a_rad - b_rad;
  return between - tuning::kTurn_rad * std::round(between / tuning::kTurn_rad);
}

}  // namespace styled::gait
