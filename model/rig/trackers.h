#pragma once

#include <array>
#include <cstdint>

#include "model/base/realtime.h"
#include "model/body/pose.h"

namespace styled::rig {

using body::Quat;
using body::Vec3;

// Makes poses of the canonical humanoid out of orientation trackers worn on some of its parts, one
// a part at most: sensors that know where up is, but neither which way they look nor how they are
// strapped on, and that send when they like. No positions come in: the hips' place follows from
// the foot that stands. Fixed memory, no allocation; one thread.
//
// What a sensor says is   world_from_sensor = Y(heading) * world_from_part * part_from_sensor
// with two unknowns: Y(heading), a turn about the vertical that drifts, and how it is worn. One
// known pose of the performer gives three equations for these four numbers. So a full reset takes
// the fourth from where the sensor is thought to point (Facing below), and is exact where it does;
// a mounting reset after it measures that instead, from the axis of a known movement, and full
// resets from then on use what it found. The idea, and the facings, are SlimeVR's (its server's
// TrackerResetsHandler.kt, TrackerPosition.kt); the equations are ours. Pinned by
// tests/unit/rig/trackers_test.cpp.
class Trackers {
 public:
  // How the performer stands in a full reset: upright, looking along +Z, arms level or hanging.
  enum class Stance : std::uint8_t { kTPose, kNPose };
  struct Options {
    Stance stance = Stance::kTPose;
    std::int64_t stale_ns = 300'000'000;  // silence after which a part is held
    // Poses are of so long ago, so that there is a sample on either side of them: about a period.
    // A sample that comes later than that is anticipated, by at most kReach_ns.
    std::int64_t delay_ns = 10'000'000;
  };
  // Bits 1 << body::Joint: parts that were reset, and parts with a live tracker that were not.
  struct Outcome {
    std::uint32_t done = 0, left = 0;
  };

  explicit Trackers(const Options& options) noexcept;

  // A measurement: right-handed, +Y up, of unit length. `time_ns` on one clock for all; one that is
  // older than the last of its part is dropped, one of the same time takes its place.
  STYLED_REALTIME void Take(body::Joint part, std::int64_t time_ns,
                            const Quat& world_from_sensor) noexcept;

  // The performer stands as `stance` says: all parts with a live tracker are calibrated anew, those
  // without forgotten, and the performer is put above the origin.
  STYLED_REALTIME Outcome ResetFull(std::int64_t now_ns) noexcept;
  // The performer looks along +Z, upright: headings alone, of all calibrated parts.
  STYLED_REALTIME Outcome ResetYaw(std::int64_t now_ns) noexcept;
  // The performer stands like a skier, still looking along +Z: bent forward at the hips, knees
  // bent, heels lifted; arms hanging if they were level in the full reset, stretched forward if
  // they hung. Parts that turned by less than 15 degrees since the full reset, or about an axis
  // steeper than 30 degrees, are left as they are.
  STYLED_REALTIME Outcome ResetMounting(std::int64_t now_ns) noexcept;

  // The pose of `now_ns` - delay. False, and `pose` untouched, where no calibrated part has a live
  // tracker; as long as none is calibrated, the rest pose where any tracker is live. A stale part
  // keeps its rotation to its parent inside, and is NaN in `pose`. A part without a tracker
  // inherits its parent's; the spine between hips and chest, and the neck between chest and head,
  // take half. Hips without one take the spine's, else the chest's or head's heading.
  //
  // Position, metres: the lowest of both heels and balls of the feet is on the floor, y = 0. One of
  // them keeps its place until another is 5 mm lower: that one then stays where it is. So walking
  // covers its ground within 5 to 8 %; running, whose flight no foot shows, falls short of it.
  STYLED_REALTIME bool Solve(std::int64_t now_ns, body::Pose& pose) noexcept;

  // Where a sensor points as it is usually worn, in the full reset: headings about the vertical
  // from the performer's +Z to the left, radians. Of its face (its +Z), by SlimeVR's default
  // mountings; of its top (its +Y), towards the shoulder, on arms that are level: so it does not
  // matter where around the arm it sits.
  static float Facing(body::Joint part, Stance stance) noexcept;

 private:
  struct Sample {
    std::int64_t time_ns = 0;
    Quat rotation = Quat::Identity();
  };
  struct Tracker {
    static constexpr std::uint32_t kSamples = 8;
    std::array<Sample, kSamples> samples;  // a ring
    std::uint32_t taken = 0;               // so many were taken; the newest is taken - 1
    bool calibrated = false;
    float facing = 0;   // as Facing()
    float heading = 0;  // sensors' world from the performer's, about +Y
    Quat sensor_from_part = Quat::Identity();
    Quat at_reset = Quat::Identity();  // world_from_sensor then, of today's heading

    const Sample& newest() const { return samples[(taken - 1) % kSamples]; }
  };
  // How a part's rotation comes about in this pose.
  enum class Source : std::uint8_t { kNone, kLive, kStale };

  // Further ahead a turn that goes on is a worse guess than one that stops.
  static constexpr std::int64_t kReach_ns = 5'000'000;

  static Quat RotationAt(const Tracker& tracker, std::int64_t time_ns) noexcept;
  bool IsLevel(int part) const noexcept;
  float HeadingOfSensor(int part, const Quat& world_from_sensor) const noexcept;
  bool IsLive(const Tracker& tracker, std::int64_t now_ns) const noexcept;
  Quat RestOf(int part) const noexcept;
  void Calibrate(int part, float heading) noexcept;
  bool RestBeforeReset(std::int64_t now_ns, body::Pose& pose) const noexcept;
  void FindWorld(std::int64_t now_ns) noexcept;
  void FindHips() noexcept;
  Quat Between(int part, int beyond) const noexcept;
  Vec3 Stand(const body::WorldPose& at_origin) noexcept;

  Options options_;
  std::array<Tracker, body::kJointCount> trackers_;
  std::array<Source, body::kJointCount> sources_{};
  std::array<Quat, body::kJointCount> world_;  // of the parts, in the performer's world
  std::array<Quat, body::kJointCount> local_;  // of the last pose
  // Which of the points that can carry the weight stands, and where.
  int stands_ = -1;
  float place_x_m_ = 0, place_z_m_ = 0;
};

}  // namespace styled::rig
