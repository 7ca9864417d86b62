#pragma once

#include <array>
#include <random>
#include <span>
#include <vector>

#include "model/devices/devices.h"
#include "model/devices/stance.h"

// A performer of any size who wears devices, each mounted anyhow, in a room in which they face
// anywhere: what the devices measure, and what the solver makes of it.
namespace styled::devices::testing {

inline constexpr std::int64_t kMs = 1'000'000;

class Worn {
 public:
  // `parts`: body::Joint. `heading`, `scale`: of the room and the performer.
  Worn(std::vector<int> parts, std::uint64_t seed, float heading = 0, float scale = 1)
      : parts_(std::move(parts)), heading_(heading), scale_(scale) {
    std::mt19937_64 random(seed);
    std::normal_distribution<float> normal;
    for (std::size_t i = 0; i < parts_.size(); ++i) {
      Quat turn(normal(random), normal(random), normal(random), normal(random));
      part_from_device_.push_back(turn.normalized());
      const Vec3 offset(normal(random), normal(random), normal(random));
      device_in_part_m_.emplace_back(seed == 0 ? Vec3(Vec3::Zero()) : Vec3(0.03F * offset));
      if (seed == 0) part_from_device_.back() = Quat::Identity();
    }
  }

  struct Reading {
    Vec3 position_m;
    Quat rotation;
  };
  Reading Read(std::size_t i, const body::WorldPose& world) const {
    const auto part = static_cast<std::size_t>(parts_[i]);
    const Quat room(Eigen::AngleAxisf(heading_, Vec3::UnitY()));
    return {
        scale_ * (room * (world.positions_m[part] + world.rotations[part] * device_in_part_m_[i])) +
            Vec3(0.4F, 0, -1.3F),
        room * world.rotations[part] * part_from_device_[i]};
  }
  // Passes the devices' measurements of a pose to the solver.
  void Measure(const body::Pose& pose, std::int64_t now_ns, Devices& devices) const {
    body::WorldPose world;
    body::ForwardKinematics(pose, world);
    for (std::size_t i = 0; i < parts_.size(); ++i) {
      const Reading reading = Read(i, world);
      devices.Add(body::Joint(parts_[i]), now_ns, reading.position_m, reading.rotation);
    }
  }
  std::vector<Seen> See(const body::Pose& pose) const {
    body::WorldPose world;
    body::ForwardKinematics(pose, world);
    std::vector<Seen> seen;
    for (std::size_t i = 0; i < parts_.size(); ++i) {
      const Reading reading = Read(i, world);
      seen.push_back({.position_m = reading.position_m,
                      .rotation = reading.rotation,
                      .has_rotation = true,
                      .at_joint = true,
                      .part = parts_[i]});
    }
    return seen;
  }
  // The stance of a T-pose above the origin, exactly.
  Stance TrueStance() const {
    return {.heading = heading_, .scale = scale_, .place_m = {0.4F, 0, -1.3F}};
  }
  // A pose of the solver, back in the performer's own space.
  body::Pose Back(body::Pose pose) const {
    const Quat room(Eigen::AngleAxisf(-heading_, Vec3::UnitY()));
    pose.hips_position_m = room * (pose.hips_position_m - Vec3(0.4F, 0, -1.3F) / scale_);
    pose.rotations[body::kHips] = room * pose.rotations[body::kHips];
    return pose;
  }

 private:
  std::vector<int> parts_;
  float heading_, scale_;
  std::vector<Quat> part_from_device_;
  std::vector<Vec3> device_in_part_m_;
};

}  // namespace styled::devices::testing
