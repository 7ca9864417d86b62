#pragma once

#include <array>
#include <cstdint>

#include "model/base/realtime.h"
#include "model/body/pose.h"
#include "model/devices/stance.h"
#include "model/rig/trackers.h"

namespace styled::devices {

// Makes poses of the canonical humanoid from devices that share one space and measure their own
// position and rotation: trackers of a VR system, its display and controllers. At most one per body
// part. Rotations are those of rig::Trackers, with one heading for all; here positions are added.
// Fixed memory, no allocation; one thread at a time. Pinned by tests/unit/devices/devices_test.cpp;
// the accuracy is measured by tests/unit/devices/clip_test.cpp.
//
//   hips       are at their device; without one, at the place that follows from the head's device
//   spine      leans so that the head is at its device, if neither spine nor chest has one
//   arms, legs reach for the device of hand or foot by two-bone IK if upper and lower part have
//              none; if one of both has one, the other points to the next joint
//   nothing    arms without any device hang, legs without any stand on the floor below the hips
class Devices {
 public:
  struct Options {
    std::int64_t stale_ns = 500'000'000;  // a device is lost after this long without a sample
    // Poses are computed for this long ago, so that there is a sample on either side.
    std::int64_t delay_ns = 10'000'000;
  };

  explicit Devices(const Options& options) noexcept;

  // Adds a measurement: right-handed axes, +Y up, metres, unit length. A value that was not
  // measured is NaN: a device may send position and rotation one after the other, or only one of
  // them. All `time_ns` are on one clock; a sample older than the last one of its part is dropped.
  STYLED_REALTIME void Add(body::Joint part, std::int64_t time_ns, const Vec3& position_m,
                           const Quat& rotation) noexcept;

  // Call while the performer stands in the T-pose described by `stance`, in the devices' space.
  // Calibrates every part with a live device, and drops the calibration of all others. The mounting
  // of a device, and its offset from the joint, is the remaining difference from a T-pose of the
  // performer's size. Bits as in rig::Trackers::Outcome.
  STYLED_REALTIME rig::Trackers::Outcome Reset(std::int64_t now_ns, const Stance& stance) noexcept;

  // Computes the pose at `now_ns` - delay, in the devices' space, but with lengths of the canonical
  // humanoid: divided by `scale()`. Returns false, with `pose` unchanged, if no calibrated part has
  // a live device that measures its rotation. While nothing is calibrated, writes the rest pose if
  // any such device is live. A part whose device is lost, and parts that depend on it, are NaN.
  STYLED_REALTIME bool Solve(std::int64_t now_ns, body::Pose& pose) noexcept;

  float scale() const noexcept { return scale_; }

 private:
  static constexpr std::uint32_t kSamples = 8;
  enum class State : std::uint8_t { kNone, kLive, kLost };
  // The positions of a part's device over time.
  struct Track {
    struct Sample {
      std::int64_t time_ns = 0;
      Vec3 position_m = Vec3::Zero();
    };
    std::array<Sample, kSamples> samples;  // a ring
    std::uint32_t taken = 0;
    bool calibrated = false;
    Vec3 joint_from_device = Vec3::Zero();  // in the part's frame, canonical metres

    const Sample& newest() const { return samples[(taken - 1) % kSamples]; }
  };

  bool IsLive(const Track& track, std::int64_t now_ns) const noexcept;
  static Vec3 PositionAt(const Track& track, std::int64_t time_ns) noexcept;
  bool Untracked(int part) const noexcept {
    return trackers_.source(part) == rig::Trackers::Source::kNone;
  }
  void FindPlaces(std::int64_t now_ns) noexcept;
  Vec3 JointAt(int part) const noexcept;
  void Inherit(int part) noexcept;
  void LeanSpine() noexcept;
  void PlaceHips(const Vec3& standing_m) noexcept;
  void PlaceLimb(int limb) noexcept;
  void ReachFor(int limb, const Vec3& root_m) noexcept;
  void HangLimb(int limb, const Vec3& root_m) noexcept;
  Vec3 Pole(int limb, const Vec3& wish_m) const noexcept;
  void Finish(body::Pose& pose) noexcept;

  Options options_;
  rig::Trackers trackers_;
  std::array<Track, body::kJointCount> tracks_;
  float heading_ = 0, scale_ = 1;

  // The current pose, in the performer's world: heading removed, canonical metres.
  std::array<State, body::kJointCount> places_{};
  std::array<Vec3, body::kJointCount> device_m_;
  std::array<Quat, body::kJointCount> world_;
  std::array<bool, body::kJointCount> lost_{};
  Vec3 hips_m_ = Vec3::Zero();
  bool hips_measured_ = false;
  std::array<Quat, body::kJointCount> held_;  // local rotations of the last pose that was not lost
};

}  // namespace styled::devices
