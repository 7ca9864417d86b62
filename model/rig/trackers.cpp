#include "model/rig/trackers.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace styled::rig {
namespace {

using body::kJointCount;

constexpr float kPi = std::numbers::pi_v<float>;
constexpr float kSmallestTurn_rad = kPi / 12;
constexpr float kSteepestAxis = 0.5F;  // sine of the axis's elevation
constexpr float kFlat = 0.966F;        // a sensor axis this close to vertical has no heading
constexpr float kHandover_m = 0.005F;
constexpr float kFarthest_rad = 0.05F;  // limit of the extrapolation, for sensors that jump

constexpr std::uint32_t Bit(int part) { return 1U << static_cast<unsigned>(part); }

Quat Turn(float heading) noexcept { return Quat(Eigen::AngleAxisf(heading, Vec3::UnitY())); }

// Heading of a vector: from +Z towards the left (+X).
float HeadingOf(const Vec3& v) noexcept { return std::atan2(v.x(), v.z()); }

// The rotation about the vertical after which the shortest rotation remains.
float TwistOf(const Quat& q) noexcept { return 2 * std::atan2(q.y(), q.w()); }

bool IsOfArm(int part) noexcept { return part >= body::kLeftShoulder && part <= body::kRightHand; }

// The axis about which a part turns from the stance into the skier's pose, in the performer's
// world.
Vec3 SkiAxis(int part, Trackers::Stance stance) noexcept {
  if (IsOfArm(part)) {
    if (stance == Trackers::Stance::kNPose) return {-1, 0, 0};
    return {0, 0, part <= body::kLeftHand ? -1.0F : 1.0F};
  }
  const bool thigh = part == body::kLeftUpperLeg || part == body::kRightUpperLeg;
  return {thigh ? -1.0F : 1.0F, 0, 0};
}

// The points of the soles that can carry the body, in the frames of their joints: the heels, behind
// and below the ankles, and the balls of the feet, below the toe joints by the height of these at
// rest.
struct Point {
  int joint;
  Vec3 offset_m;
};
constexpr int kPoints = 4;
Point PointOf(int k) noexcept {
  const bool left = k < 2;
  if (k % 2 == 0) return {left ? body::kLeftFoot : body::kRightFoot, {0, -0.09F, -0.03F}};
  return {left ? body::kLeftToes : body::kRightToes, {0, -0.02F, 0}};
}

}  // namespace

Trackers::Trackers(const Options& options) noexcept : options_(options) {
  world_.fill(Quat::Identity());
  local_.fill(Quat::Identity());
  for (int part = 0; part < kJointCount; ++part) {
    trackers_[part].facing = Facing(body::Joint(part), options_.stance);
  }
}

float Trackers::Facing(body::Joint part, Stance stance) noexcept {
  const float side =
      part <= body::kLeftHand || (part >= body::kLeftUpperLeg && part <= body::kLeftToes) ? 1 : -1;
  if (stance == Stance::kTPose && IsOfArm(part)) return -side * kPi / 2;
  switch (part) {
    case body::kLeftLowerArm:
    case body::kLeftHand:
    case body::kRightLowerArm:
    case body::kRightHand:
      return side * kPi / 2;
    case body::kLeftUpperArm:
    case body::kRightUpperArm:
    case body::kLeftLowerLeg:
    case body::kRightLowerLeg:
      return side * kPi / 4;
    default:
      return 0;
  }
}

// If the sensor's axis is close to vertical, its heading is that of the sensor tilted back by the
// shortest rotation: a sensor on an instep has its top towards the shin.
float Trackers::HeadingOfSensor(int part, const Quat& world_from_sensor) const noexcept {
  const Vec3 axis = world_from_sensor * (IsLevel(part) ? Vec3(0, 1, 0) : Vec3(0, 0, 1));
  return std::abs(axis.y()) < kFlat ? HeadingOf(axis) : TwistOf(world_from_sensor);
}

bool Trackers::IsLevel(int part) const noexcept {
  return options_.stance == Stance::kTPose && IsOfArm(part);
}

void Trackers::Add(body::Joint part, std::int64_t time_ns, const Quat& world_from_sensor) noexcept {
  Tracker& tracker = trackers_[part];
  if (tracker.taken > 0 && time_ns < tracker.newest().time_ns) return;
  if (tracker.taken == 0 || time_ns > tracker.newest().time_ns) ++tracker.taken;
  tracker.samples[(tracker.taken - 1) % Tracker::kSamples] = {time_ns, world_from_sensor};
}

bool Trackers::IsLive(const Tracker& tracker, std::int64_t now_ns) const noexcept {
  return tracker.taken > 0 && now_ns - tracker.newest().time_ns <= options_.stale_ns;
}

Quat Trackers::RestOf(int part) const noexcept {
  if (options_.stance == Stance::kTPose || !IsOfArm(part) || part == body::kLeftShoulder ||
      part == body::kRightShoulder) {
    return Quat::Identity();
  }
  const float down = part <= body::kLeftHand ? -kPi / 2 : kPi / 2;
  return Quat(Eigen::AngleAxisf(down, Vec3::UnitZ()));
}

// Solves at_reset = Y(heading) * rest * part_from_sensor for part_from_sensor.
void Trackers::Calibrate(int part, float heading) noexcept {
  Tracker& tracker = trackers_[part];
  tracker.heading = heading;
  const Quat world_from_sensor = Turn(-heading) * tracker.at_reset;
  tracker.sensor_from_part = (world_from_sensor.conjugate() * RestOf(part)).normalized();
  tracker.calibrated = true;
}

template <typename HeadingOfPart>
Trackers::Outcome Trackers::ResetEach(std::int64_t now_ns,
                                      const HeadingOfPart& heading_of) noexcept {
  Outcome outcome;
  for (int part = 0; part < kJointCount; ++part) {
    Tracker& tracker = trackers_[part];
    tracker.calibrated = false;
    if (!IsLive(tracker, now_ns)) continue;
    tracker.at_reset = tracker.newest().rotation;
    Calibrate(part, heading_of(part));
    outcome.done |= Bit(part);
  }
  local_.fill(Quat::Identity());
  stands_ = -1;
  return outcome;
}

Trackers::Outcome Trackers::ResetFull(std::int64_t now_ns) noexcept {
  return ResetEach(now_ns, [this](int part) {
    const Tracker& tracker = trackers_[part];
    return HeadingOfSensor(part, tracker.at_reset) - tracker.facing;
  });
}

Trackers::Outcome Trackers::ResetFull(std::int64_t now_ns, float heading) noexcept {
  return ResetEach(now_ns, [heading](int) { return heading; });
}

Trackers::Outcome Trackers::ResetYaw(std::int64_t now_ns) noexcept {
  Outcome outcome;
  for (int part = 0; part < kJointCount; ++part) {
    Tracker& tracker = trackers_[part];
    if (!IsLive(tracker, now_ns)) continue;
    if (!tracker.calibrated) {
      outcome.left |= Bit(part);
      continue;
    }
    const float drift =
        TwistOf(Turn(-tracker.heading) * tracker.newest().rotation * tracker.sensor_from_part);
    tracker.heading = std::remainder(tracker.heading + drift, 2 * kPi);
    tracker.at_reset = Turn(drift) * tracker.at_reset;
    outcome.done |= Bit(part);
  }
  return outcome;
}

// The axis of the rotation since the full reset, in the sensors' world, is the performer's axis
// turned by the heading. The difference of the two axes' headings is therefore the heading.
Trackers::Outcome Trackers::ResetMounting(std::int64_t now_ns) noexcept {
  Outcome outcome;
  for (int part = 0; part < kJointCount; ++part) {
    Tracker& tracker = trackers_[part];
    if (!IsLive(tracker, now_ns)) continue;
    const Vec3 turn = body::Log(tracker.newest().rotation * tracker.at_reset.conjugate());
    const float angle = turn.norm();
    if (!tracker.calibrated || angle < kSmallestTurn_rad ||
        std::abs(turn.y()) > kSteepestAxis * angle) {
      outcome.left |= Bit(part);
      continue;
    }
    const float heading = HeadingOf(turn) - HeadingOf(SkiAxis(part, options_.stance));
    tracker.facing = std::remainder(HeadingOfSensor(part, tracker.at_reset) - heading, 2 * kPi);
    Calibrate(part, std::remainder(heading, 2 * kPi));
    outcome.done |= Bit(part);
  }
  return outcome;
}

bool Trackers::Solve(std::int64_t now_ns, body::Pose& pose) noexcept {
  FindWorld(now_ns);
  if (std::ranges::find(sources_, Source::kLive) == sources_.end()) {
    return RestBeforeReset(now_ns, pose);
  }
  FindHips();
  for (int part = 1; part < kJointCount; ++part) {
    const Quat& parent = world_[body::kHumanoid[part].parent];
    if (sources_[part] == Source::kStale) {
      world_[part] = parent * local_[part];
    } else if (sources_[part] == Source::kNone) {
      world_[part] = part == body::kSpine  ? Between(part, body::kChest)
                     : part == body::kNeck ? Between(part, body::kHead)
                                           : parent;
    }
    local_[part] = (parent.conjugate() * world_[part]).normalized();
  }
  local_[body::kHips] = world_[body::kHips];

  body::Pose at_origin;
  at_origin.hips_position_m.setZero();
  at_origin.rotations = local_;
  body::WorldPose points;
  body::ForwardKinematics(at_origin, points);
  pose.hips_position_m = Stand(points);
  pose.rotations = local_;
  for (int part = 0; part < kJointCount; ++part) {
    if (sources_[part] != Source::kStale) continue;
    pose.rotations[part].coeffs().setConstant(std::numeric_limits<float>::quiet_NaN());
  }
  return true;
}

bool Trackers::RestBeforeReset(std::int64_t now_ns, body::Pose& pose) const noexcept {
  if (std::ranges::find(sources_, Source::kStale) != sources_.end()) return false;
  if (std::ranges::none_of(trackers_, [&](const Tracker& t) { return IsLive(t, now_ns); })) {
    return false;
  }
  pose = body::Pose();
  return true;
}

// Finds the world rotations of the parts whose trackers are live.
void Trackers::FindWorld(std::int64_t now_ns) noexcept {
  const std::int64_t time_ns = now_ns - options_.delay_ns;
  for (int part = 0; part < kJointCount; ++part) {
    const Tracker& tracker = trackers_[part];
    sources_[part] = Source::kNone;
    if (!tracker.calibrated) continue;
    sources_[part] = IsLive(tracker, now_ns) ? Source::kLive : Source::kStale;
    if (sources_[part] == Source::kStale) continue;
    world_[part] =
        (Turn(-tracker.heading) * RotationAt(tracker, time_ns) * tracker.sensor_from_part)
            .normalized();
  }
}

Quat Trackers::RotationAt(const Tracker& tracker, std::int64_t time_ns) noexcept {
  const auto sample = [&tracker](std::uint32_t i) -> const Sample& {
    return tracker.samples[i % Tracker::kSamples];
  };
  const std::uint32_t oldest = tracker.taken - std::min(tracker.taken, Tracker::kSamples);
  // Find the newest sample that is not later than the time, and the one after it.
  std::uint32_t i = tracker.taken - 1;
  while (i > oldest && sample(i).time_ns > time_ns) --i;
  const Sample& a = sample(i);
  if (time_ns <= a.time_ns) return a.rotation;
  if (i + 1 < tracker.taken) {
    const Sample& b = sample(i + 1);
    const auto share =
        static_cast<double>(time_ns - a.time_ns) / static_cast<double>(b.time_ns - a.time_ns);
    return a.rotation.slerp(static_cast<float>(share), b.rotation);
  }
  // The next sample is late: extrapolate the rotation over the last samples. Two samples that
  // arrived in one burst do not show a velocity, so the base is at least kReach_ns long.
  std::uint32_t k = i;
  while (k > oldest && a.time_ns - sample(k).time_ns < kReach_ns) --k;
  const std::int64_t base_ns = a.time_ns - sample(k).time_ns;
  if (base_ns < kReach_ns || base_ns > 10 * kReach_ns) return a.rotation;
  const auto share =
      static_cast<double>(std::min(time_ns - a.time_ns, kReach_ns)) / static_cast<double>(base_ns);
  const Vec3 turn =
      static_cast<float>(share) * body::Log(a.rotation * sample(k).rotation.conjugate());
  const float angle = turn.norm();
  return body::Exp(angle > kFarthest_rad ? Vec3(turn * (kFarthest_rad / angle)) : turn) *
         a.rotation;
}

void Trackers::FindHips() noexcept {
  Quat& hips = world_[body::kHips];
  if (sources_[body::kHips] == Source::kLive) return;
  hips = local_[body::kHips];
  if (sources_[body::kHips] == Source::kStale) return;
  for (const int above : {body::kSpine, body::kChest, body::kHead}) {
    if (sources_[above] == Source::kNone) continue;
    if (sources_[above] == Source::kStale) return;
    hips = above == body::kSpine ? world_[above] : Turn(TwistOf(world_[above]));
    return;
  }
}

// Half the rotation from the parent to the part beyond.
Quat Trackers::Between(int part, int beyond) const noexcept {
  const Quat& parent = world_[body::kHumanoid[part].parent];
  if (sources_[beyond] == Source::kNone) return parent;
  if (sources_[beyond] == Source::kStale) return parent * local_[part];
  return parent.slerp(0.5F, world_[beyond]);
}

Vec3 Trackers::Stand(const body::WorldPose& at_origin) noexcept {
  std::array<Vec3, kPoints> points;
  int lowest = 0;
  for (int k = 0; k < kPoints; ++k) {
    const Point point = PointOf(k);
    points[k] =
        at_origin.positions_m[point.joint] + at_origin.rotations[point.joint] * point.offset_m;
    if (points[k].y() < points[lowest].y()) lowest = k;
  }
  // The height follows the lowest point, the place the standing one. Found separately, neither
  // jumps when the weight passes to another point.
  Vec3 hips(0, -points[lowest].y(), 0);
  if (stands_ >= 0) {
    hips.x() = place_x_m_ - points[stands_].x();
    hips.z() = place_z_m_ - points[stands_].z();
  }
  if (stands_ < 0 || points[lowest].y() < points[stands_].y() - kHandover_m) {
    stands_ = lowest;
    place_x_m_ = hips.x() + points[lowest].x();
    place_z_m_ = hips.z() + points[lowest].z();
  }
  return hips;
}

}  // namespace styled::rig
