#pragma once

#include <array>
#include <cstdint>

#include "model/base/realtime.h"
#include "model/body/pose.h"

namespace styled::rig {

using body::Quat;
using body::Vec3;

// Makes poses of the canonical humanoid from orientation trackers, at most one per body part. The
// sensors know the vertical, but neither their heading nor how they are mounted, and they send at
// any time. They measure no positions: the place of the hips follows from the standing foot. Fixed
// memory, no allocation; one thread at a time.
//
// A sensor measures   world_from_sensor = Y(heading) * world_from_part * part_from_sensor
//
// with two unknowns: Y(heading), a rotation about the vertical that drifts, and the mounting
// part_from_sensor. One known pose of the performer gives three equations for these four numbers. A
// full reset gets the fourth from the direction in which the sensor is assumed to point (Facing
// below), and is exact if it does. A mounting reset after it measures that direction instead, from
// the axis of a known movement; later full resets use the measured one. The idea and the facings
// are SlimeVR's (TrackerResetsHandler.kt and TrackerPosition.kt of its server); the equations are
// our own. Pinned by tests/unit/rig/trackers_test.cpp.
class Trackers {
 public:
  // The performer's pose in a full reset: upright, looking along +Z, arms level or hanging.
  enum class Stance : std::uint8_t { kTPose, kNPose };
  struct Options {
    Stance stance = Stance::kTPose;
    std::int64_t stale_ns = 300'000'000;  // a part is held after this long without a sample
    // Poses are computed for this long ago, so that there is a sample on either side: about one
    // period of the sensors. If the later sample is missing, the pose is extrapolated by at most
    // kReach_ns.
    std::int64_t delay_ns = 10'000'000;
  };
  // Bits 1 << body::Joint: the parts that were reset, and those with a live tracker that were not.
  struct Outcome {
    std::uint32_t done = 0, left = 0;
  };

  explicit Trackers(const Options& options) noexcept;

  // Adds a measurement: right-handed axes, +Y up, unit length. All `time_ns` are on one clock. A
  // sample older than the last one of its part is dropped; one of the same time replaces it.
  STYLED_REALTIME void Add(body::Joint part, std::int64_t time_ns,
                           const Quat& world_from_sensor) noexcept;

  // Call while the performer stands in `stance`. Calibrates every part with a live tracker, drops
  // the calibration of all others, and places the performer above the origin.
  STYLED_REALTIME Outcome ResetFull(std::int64_t now_ns) noexcept;
  // The same for sensors that share one world, in which the performer faces `heading` (about +Y,
  // from +Z to the left, radians). The sensors' directions do not matter then.
  STYLED_REALTIME Outcome ResetFull(std::int64_t now_ns, float heading) noexcept;
  // Call while the performer stands upright and looks along +Z. Corrects the headings of all
  // calibrated parts, nothing else.
  STYLED_REALTIME Outcome ResetYaw(std::int64_t now_ns) noexcept;
  // Call while the performer stands like a skier and looks along +Z: bent forward at the hips,
  // knees bent, heels lifted; the arms hang if they were level in the full reset, and are stretched
  // forward if they hung. Parts that turned by less than 15 degrees since the full reset, or about
  // an axis steeper than 30 degrees, are left unchanged.
  STYLED_REALTIME Outcome ResetMounting(std::int64_t now_ns) noexcept;

  // Computes the pose at `now_ns` - delay. Returns false, with `pose` unchanged, if no calibrated
  // part has a live tracker. While no part is calibrated at all, gives the rest pose if any tracker
  // is live. A stale part keeps its local rotation inside this class and is NaN in `pose`. A part
  // without a tracker inherits its parent's rotation; the spine between hips and chest, and the
  // neck between chest and head, get half. Hips without a tracker get the rotation of the spine,
  // else the heading of the chest, else of the head.
  //
  // Position, metres: the lowest of both heels and balls of the feet is on the floor, y = 0. One of
  // these points keeps its place until another is 5 mm lower, which then keeps its own. Walking
  // covers its distance within 5 to 8 %; running covers less, because no foot shows the flight
  // phase.
  STYLED_REALTIME bool Solve(std::int64_t now_ns, body::Pose& pose) noexcept;

  // The source of a part's rotation in the last pose.
  enum class Source : std::uint8_t { kNone, kLive, kStale };
  Source source(int part) const noexcept { return sources_[part]; }
  // The parts' rotations of the last pose, in the performer's world; stale parts with their held
  // rotation.
  const std::array<Quat, body::kJointCount>& world() const noexcept { return world_; }

  // The direction in which a sensor points in a full reset if it is mounted as usual: a heading
  // about the vertical, from the performer's +Z to the left, radians. It is the heading of the
  // sensor's face (its +Z), by SlimeVR's default mountings. On level arms it is that of the
  // sensor's top (its +Y), which points to the shoulder, so the sensor may sit anywhere around the
  // arm.
  static float Facing(body::Joint part, Stance stance) noexcept;

 private:
  struct Sample {
    std::int64_t time_ns = 0;
    Quat rotation = Quat::Identity();
  };
  struct Tracker {
    static constexpr std::uint32_t kSamples = 8;
    std::array<Sample, kSamples> samples;  // a ring
    std::uint32_t taken = 0;               // samples so far; the newest is number taken - 1
    bool calibrated = false;
    float facing = 0;   // as Facing()
    float heading = 0;  // from the performer's world to the sensors', about +Y
    Quat sensor_from_part = Quat::Identity();
    Quat at_reset = Quat::Identity();  // world_from_sensor at the full reset, with today's heading

    const Sample& newest() const { return samples[(taken - 1) % kSamples]; }
  };
  // The longest extrapolation. Beyond it, a rotation that stops is the better guess.
  static constexpr std::int64_t kReach_ns = 5'000'000;

  static Quat RotationAt(const Tracker& tracker, std::int64_t time_ns) noexcept;
  bool IsLevel(int part) const noexcept;
  float HeadingOfSensor(int part, const Quat& world_from_sensor) const noexcept;
  bool IsLive(const Tracker& tracker, std::int64_t now_ns) const noexcept;
  template <typename HeadingOfPart>
  Outcome ResetEach(std::int64_t now_ns, const HeadingOfPart& heading_of) noexcept;
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
  // The standing point (index of PointOf, -1: none yet), and its place on the floor.
  int stands_ = -1;
  float place_x_m_ = 0, place_z_m_ = 0;
};

}  // namespace styled::rig
