#include "model/devices/devices.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "model/devices/limb.h"

namespace styled::devices {
namespace {

using body::kHumanoid;
using body::kJointCount;
using body::Offset;
using Source = rig::Trackers::Source;

// The head's joint moves with the spine's bend, and the neck with both: three rounds leave less
// than a millimetre.
constexpr int kLeanRounds = 3;
// An arm without a device: nearly straight down, the elbow a little bent.
constexpr float kHang_rad = 1.35F, kElbow_rad = 0.25F;

// The hand's influence on the elbow's direction, relative to 1 for the chest. Real clips, six
// devices, 0, 1 and 2: 13.7, 9.3 and 7.8 degrees mean error of a walk, 18.0, 15.0 and 13.9 of a
// dance.
constexpr float kHandTellsElbow = 2;

Quat Turn(float heading) noexcept { return Quat(Eigen::AngleAxisf(heading, Vec3::UnitY())); }

bool IsArm(int limb) noexcept { return limb < 2; }
bool IsLeft(int limb) noexcept { return limb % 2 == 0; }

}  // namespace

Devices::Devices(const Options& options) noexcept
    : options_(options), trackers_({.stale_ns = options.stale_ns, .delay_ns = options.delay_ns}) {
  world_.fill(Quat::Identity());
  held_.fill(Quat::Identity());
  device_m_.fill(Vec3::Zero());
}

void Devices::Add(body::Joint part, std::int64_t time_ns, const Vec3& position_m,
                  const Quat& rotation) noexcept {
  if (rotation.coeffs().allFinite()) trackers_.Add(part, time_ns, rotation);
  if (!position_m.allFinite()) return;
  Track& track = tracks_[part];
  if (track.taken > 0 && time_ns < track.newest().time_ns) return;
  if (track.taken == 0 || time_ns > track.newest().time_ns) ++track.taken;
  track.samples[(track.taken - 1) % kSamples] = {time_ns, position_m};
}

bool Devices::IsLive(const Track& track, std::int64_t now_ns) const noexcept {
  return track.taken > 0 && now_ns - track.newest().time_ns <= options_.stale_ns;
}

// Between the samples on either side; the newest sample if the next one is late.
Vec3 Devices::PositionAt(const Track& track, std::int64_t time_ns) noexcept {
  const auto sample = [&track](std::uint32_t i) -> const Track::Sample& {
    return track.samples[i % kSamples];
  };
  const std::uint32_t oldest = track.taken - std::min(track.taken, kSamples);
  std::uint32_t i = track.taken - 1;
  while (i > oldest && sample(i).time_ns > time_ns) --i;
  const Track::Sample& a = sample(i);
  if (time_ns <= a.time_ns || i + 1 >= track.taken) return a.position_m;
  const Track::Sample& b = sample(i + 1);
  const auto share =
      static_cast<double>(time_ns - a.time_ns) / static_cast<double>(b.time_ns - a.time_ns);
  return a.position_m + static_cast<float>(share) * (b.position_m - a.position_m);
}

rig::Trackers::Outcome Devices::Reset(std::int64_t now_ns, const Stance& stance) noexcept {
  const rig::Trackers::Outcome outcome = trackers_.ResetFull(now_ns, stance.heading);
  heading_ = stance.heading;
  scale_ = stance.scale;
  const Quat from_room = Turn(-heading_);
  body::Pose rest;
  const Vec3 place = from_room * stance.place_m / scale_;
  rest.hips_position_m += Vec3(place.x(), 0, place.z());
  body::WorldPose world;
  body::ForwardKinematics(rest, world);
  for (int part = 0; part < kJointCount; ++part) {
    Track& track = tracks_[part];
    track.calibrated = IsLive(track, now_ns);
    if (!track.calibrated) continue;
    const Vec3 device = from_room * track.newest().position_m / scale_;
    track.joint_from_device = world.positions_m[static_cast<std::size_t>(part)] - device;
  }
  held_.fill(Quat::Identity());
  hips_m_ = rest.hips_position_m;
  return outcome;
}

void Devices::FindPlaces(std::int64_t now_ns) noexcept {
  const std::int64_t time_ns = now_ns - options_.delay_ns;
  const Quat from_room = Turn(-heading_);
  for (int part = 0; part < kJointCount; ++part) {
    const Track& track = tracks_[part];
    places_[part] = !track.calibrated       ? State::kNone
                    : IsLive(track, now_ns) ? State::kLive
                                            : State::kLost;
    if (places_[part] != State::kLive) continue;
    device_m_[part] = from_room * PositionAt(track, time_ns) / scale_;
  }
}

// The position of a part's joint according to its live device, for the part's present rotation.
Vec3 Devices::JointAt(int part) const noexcept {
  return device_m_[part] + world_[part] * tracks_[part].joint_from_device;
}

void Devices::Inherit(int part) noexcept {
  if (Untracked(part)) world_[part] = world_[kHumanoid[part].parent];
}

bool Devices::Solve(std::int64_t now_ns, body::Pose& pose) noexcept {
  body::Pose turned;
  if (!trackers_.Solve(now_ns, turned)) return false;
  world_ = trackers_.world();
  bool any = false;
  for (int part = 0; part < kJointCount; ++part) {
    any = any || !Untracked(part);
    lost_[part] = trackers_.source(part) == Source::kStale;
  }
  if (!any) {  // not calibrated
    pose = turned;
    return true;
  }
  FindPlaces(now_ns);
  LeanSpine();
  PlaceHips(turned.hips_position_m);
  for (const int shoulder : {body::kLeftShoulder, body::kRightShoulder}) Inherit(shoulder);
  for (int limb = 0; limb < kLimbs; ++limb) PlaceLimb(limb);
  for (const int toes : {body::kLeftToes, body::kRightToes}) Inherit(toes);
  Finish(pose);
  return true;
}

void Devices::LeanSpine() noexcept {
  if (!Untracked(body::kSpine) || !Untracked(body::kChest)) return;
  if (places_[body::kHips] == State::kNone || places_[body::kHead] == State::kNone) return;
  if (places_[body::kHips] == State::kLost || places_[body::kHead] == State::kLost) {
    lost_[body::kSpine] = lost_[body::kChest] = lost_[body::kNeck] = true;
    return;
  }
  const Vec3 spine = JointAt(body::kHips) + world_[body::kHips] * Offset(body::kSpine);
  for (int round = 0; round < kLeanRounds; ++round) {
    if (Untracked(body::kHead)) world_[body::kHead] = world_[body::kNeck];
    const Vec3 head = spine + world_[body::kSpine] * Offset(body::kChest) +
                      world_[body::kChest] * Offset(body::kNeck) +
                      world_[body::kNeck] * Offset(body::kHead);
    const Vec3 wish = JointAt(body::kHead) - spine;
    if (wish.norm() < 1e-3F) return;
    const Quat turn = body::ShortestTurn(head - spine, wish);
    world_[body::kSpine] = (Quat::Identity().slerp(0.5F, turn) * world_[body::kSpine]).normalized();
    world_[body::kChest] = (turn * world_[body::kChest]).normalized();
    if (Untracked(body::kNeck)) {
      world_[body::kNeck] = Untracked(body::kHead)
                                ? world_[body::kChest]
                                : world_[body::kChest].slerp(0.5F, world_[body::kHead]);
    }
  }
}

// `standing_m`: the place of the hips according to the standing foot.
void Devices::PlaceHips(const Vec3& standing_m) noexcept {
  hips_measured_ = true;
  if (places_[body::kHips] == State::kLive) {
    hips_m_ = JointAt(body::kHips);
  } else if (places_[body::kHead] == State::kLive) {
    hips_m_ = JointAt(body::kHead);
    for (int part = body::kHead; part != body::kHips; part = kHumanoid[part].parent) {
      hips_m_ -= world_[kHumanoid[part].parent] * Offset(part);
    }
  } else if (places_[body::kHips] == State::kNone && places_[body::kHead] == State::kNone) {
    hips_m_ = standing_m;
    hips_measured_ = false;
  }  // else they are lost: held at their last place
}

void Devices::PlaceLimb(int index) noexcept {
  const Limb& limb = LimbOf(index);
  Vec3 root = hips_m_;
  std::array<int, 4> above{};
  int count = 0;
  for (int part = limb.upper; part != body::kHips; part = kHumanoid[part].parent) {
    above[static_cast<std::size_t>(count++)] = part;
  }
  while (count > 0) {
    const int part = above[static_cast<std::size_t>(--count)];
    root += world_[kHumanoid[part].parent] * Offset(part);
  }
  const bool free = Untracked(limb.upper) && Untracked(limb.lower);
  if (places_[limb.end] == State::kLive) {
    ReachFor(index, root);
  } else if (places_[limb.end] == State::kLost) {
    for (const int part : {limb.upper, limb.lower, limb.end}) {
      Inherit(part);
      lost_[part] = lost_[part] || Untracked(part);
    }
  } else if (free && Untracked(limb.end)) {
    return HangLimb(index, root);
  } else {
    for (const int part : {limb.upper, limb.lower}) Inherit(part);
  }
  Inherit(limb.end);
}

void Devices::ReachFor(int index, const Vec3& root_m) noexcept {
  const Limb& limb = LimbOf(index);
  Quat& upper = world_[limb.upper];
  Quat& lower = world_[limb.lower];
  if (Untracked(limb.end)) world_[limb.end] = lower;
  const Vec3 target = JointAt(limb.end);
  if (Untracked(limb.upper) && Untracked(limb.lower)) {
    const LimbTurns turns = Bend(limb, root_m, target, Pole(index, target - root_m));
    upper = turns.upper;
    lower = turns.lower;
  } else if (Untracked(limb.lower)) {
    lower = Aim(upper, Offset(limb.end), target - root_m - upper * Offset(limb.lower));
  } else if (Untracked(limb.upper)) {
    const Vec3 middle = target - lower * Offset(limb.end);
    upper = Aim(world_[kHumanoid[limb.upper].parent], Offset(limb.lower), middle - root_m);
  }
}

// A limb without any device.
void Devices::HangLimb(int index, const Vec3& root_m) noexcept {
  const Limb& limb = LimbOf(index);
  Quat& upper = world_[limb.upper];
  Quat& lower = world_[limb.lower];
  if (IsArm(index)) {
    const float down_rad = IsLeft(index) ? -kHang_rad : kHang_rad;
    upper = world_[kHumanoid[limb.upper].parent] * Quat(Eigen::AngleAxisf(down_rad, Vec3::UnitZ()));
    lower = upper * Quat(Eigen::AngleAxisf(kElbow_rad, limb.hinge));
    world_[limb.end] = lower;
    return;
  }
  if (!hips_measured_) {
    for (const int part : {limb.upper, limb.lower, limb.end}) Inherit(part);
    return;
  }
  const Quat ahead = Turn(2 * std::atan2(world_[body::kHips].y(), world_[body::kHips].w()));
  const Vec3 side = ahead * Offset(limb.upper);
  const float ankle_m = kHumanoid[body::kHips].y_m + Offset(limb.upper).y() +
                        Offset(limb.lower).y() + Offset(limb.end).y();
  const Vec3 target(hips_m_.x() + side.x(), ankle_m, hips_m_.z() + side.z());
  const LimbTurns turns = Bend(limb, root_m, target, ahead * Vec3::UnitZ());
  upper = turns.upper;
  lower = turns.lower;
  world_[limb.end] = ahead;
}

// The direction of the knee or the elbow. A knee points ahead, between hips and foot. An elbow
// points in the T-pose's direction after the smallest turn of the arm, combined with the hand's
// direction.
Vec3 Devices::Pole(int index, const Vec3& wish_m) const noexcept {
  const Limb& limb = LimbOf(index);
  const bool turned = !Untracked(limb.end);
  if (!IsArm(index)) {
    Vec3 ahead = world_[body::kHips] * Vec3::UnitZ();
    if (turned) ahead += world_[limb.end] * Vec3::UnitZ();
    return ahead;
  }
  const Quat arm = Aim(world_[body::kChest], limb.along, wish_m);
  Vec3 back = arm * -Vec3::UnitZ();
  if (turned) back -= kHandTellsElbow * (world_[limb.end] * Vec3::UnitZ());
  return back;
}

// Local rotations in the devices' space; lost parts keep the last one here and are NaN outside.
void Devices::Finish(body::Pose& pose) noexcept {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  for (int part = 0; part < kJointCount; ++part) {
    const int parent = kHumanoid[part].parent;
    const Quat above = parent < 0 ? Quat::Identity() : world_[parent];
    if (lost_[part]) {
      world_[part] = above * held_[part];
      pose.rotations[part] = Quat(kNan, kNan, kNan, kNan);
    } else {
      held_[part] = (above.conjugate() * world_[part]).normalized();
      pose.rotations[part] = held_[part];
    }
  }
  const Quat to_room = Turn(heading_);
  pose.rotations[body::kHips] = to_room * pose.rotations[body::kHips];
  pose.hips_position_m = to_room * hips_m_;
}

}  // namespace styled::devices
