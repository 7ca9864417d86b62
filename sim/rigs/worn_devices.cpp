#include "sim/rigs/worn_devices.h"

#include <algorithm>
#include <cmath>

namespace styled::rigs {
namespace {

using body::Quat;
using body::Vec3;

constexpr double kWornStanding_s = 1;
constexpr float kMostOff_m = 0.03F;
const Vec3 kEyes_m(0, 0.06F, 0.08F);  // from the head's joint

}  // namespace

WornDevices::WornDevices(const Options& options, const std::vector<Place>& places)
    : random_(options.seed),
      t_pose_(HasQuirk(options, "t-pose")),
      vanish_(HasQuirk(options, "vanish")),
      shuffled_(HasQuirk(options, "shuffled")) {
  const auto named = [&](const Place& place) {
    return HasQuirk(options, body::kHumanoid[static_cast<std::size_t>(place.joint)].name);
  };
  const bool all = std::ranges::none_of(places, named);
  for (const Place& place : places) {
    if (!all && !named(place)) continue;
    Worn worn{place};
    if (HasQuirk(options, "mounted")) {
      std::normal_distribution<float> normal;
      for (float& value : worn.part_from_device.coeffs()) value = normal(random_);
      worn.part_from_device.normalize();
      // A display, or a sender's head, faces in the head's direction.
      if (place.joint == body::kHead) worn.part_from_device.setIdentity();
      std::uniform_real_distribution<float> off(-kMostOff_m, kMostOff_m);
      worn.offset_m = Vec3(off(random_), off(random_), off(random_)) / std::sqrt(3.0F);
    }
    if (place.before_eyes) worn.offset_m += kEyes_m;
    worn_.push_back(worn);
  }
}

const std::vector<WornDevices::Reading>& WornDevices::Read(const Frame& frame) {
  const body::Pose standing;
  const bool stands = t_pose_ && frame.time_s < kWornStanding_s;
  const body::Pose& tracked = stands ? standing : frame.poses[0];
  body::Pose whole = stands || frame.whole.empty() ? tracked : frame.whole[0];
  for (Quat& q : whole.rotations) {
    if (!q.coeffs().allFinite()) q = Quat::Identity();
  }
  body::WorldPose world;
  body::ForwardKinematics(whole, world);
  readings_.clear();
  const bool gone = vanish_ && std::fmod(frame.time_s, 3.0) >= 2.0;
  for (const Worn& worn : worn_) {
    const auto joint = static_cast<std::size_t>(worn.place.joint);
    if (!tracked.rotations[joint].coeffs().allFinite()) continue;
    if (gone && &worn == &worn_.back()) continue;
    const Vec3 p = world.positions_m[joint] + world.rotations[joint] * worn.offset_m;
    const Quat q = world.rotations[joint] * worn.part_from_device;
    readings_.push_back({worn.place.index, worn.place.joint, Vec3(-p.x(), p.y(), p.z()),
                         Quat(q.w(), q.x(), -q.y(), -q.z())});
  }
  if (shuffled_) std::ranges::shuffle(readings_, random_);
  return readings_;
}

}  // namespace styled::rigs
