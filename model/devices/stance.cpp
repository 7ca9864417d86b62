#include "model/devices/stance.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

namespace styled::devices {
namespace {

constexpr float kPi = std::numbers::pi_v<float>;
// The eyes above the head's joint and before it, on the canonical humanoid (as VMC's body has it).
constexpr float kEyesUp_m = 0.06F, kEyesAhead_m = 0.08F;
constexpr float kFarthest_m = 0.3F;
// Above this height the highest device is assumed to be on the head, unless another device is known
// to be there. It is above the arms of a T-pose of a performer of 1.5 m, and below the eyes of one
// of 1.35 m.
constexpr float kLeastHead_m = 1.25F;
// A pair closer than this has no direction worth using.
constexpr float kLeastPair_m = 0.1F;

// The usual places of devices in the T-pose: part, metres to the performer's left, height.
struct Usual {
  int part;
  float left_m, up_m;
};
// A strap above the knee turns as the thigh, one above the elbow as the upper arm.
constexpr std::array<Usual, 11> kUsual{{{body::kHead, 0, 1.55F},
                                        {body::kChest, 0, 1.25F},
                                        {body::kHips, 0, 0.98F},
                                        {body::kLeftHand, 0.72F, 1.37F},
                                        {body::kRightHand, -0.72F, 1.37F},
                                        {body::kLeftUpperArm, 0.38F, 1.37F},
                                        {body::kRightUpperArm, -0.38F, 1.37F},
                                        {body::kLeftUpperLeg, 0.09F, 0.5F},
                                        {body::kRightUpperLeg, -0.09F, 0.5F},
                                        {body::kLeftFoot, 0.09F, 0.09F},
                                        {body::kRightFoot, -0.09F, 0.09F}}};

struct Pair {
  int left, right;
  std::string_view name;
};
constexpr std::array<Pair, 4> kPairs{{{body::kLeftHand, body::kRightHand, "the hands"},
                                      {body::kLeftUpperArm, body::kRightUpperArm, "the elbows"},
                                      {body::kLeftFoot, body::kRightFoot, "the feet"},
                                      {body::kLeftUpperLeg, body::kRightUpperLeg, "the knees"}}};

Vec3 Flat(const Vec3& v) { return {v.x(), 0, v.z()}; }
// Heading of the direction from a right device to its left one.
float HeadingOfLeft(const Vec3& left) { return std::atan2(-left.z(), left.x()); }
float HeadingOf(const Quat& q) {
  const Vec3 ahead = q * Vec3::UnitZ();
  return std::atan2(ahead.x(), ahead.z());
}

const Seen* Find(std::span<const Seen> devices, int part) {
  const auto found = std::ranges::find(devices, part, &Seen::part);
  return found == devices.end() ? nullptr : &*found;
}

float HeadHeight_m(const Seen& head) {
  body::WorldPose world;
  body::ForwardKinematics(body::Pose(), world);
  return world.positions_m[body::kHead].y() + (head.at_joint ? 0 : kEyesUp_m);
}

// The two devices farthest apart on the floor; both null if none are apart.
std::pair<const Seen*, const Seen*> Widest(std::span<const Seen> devices) {
  std::pair<const Seen*, const Seen*> widest{nullptr, nullptr};
  float most_m = kLeastPair_m;
  for (const Seen& a : devices) {
    for (const Seen& b : devices) {
      const float apart_m = Flat(a.position_m - b.position_m).norm();
      if (apart_m <= most_m) continue;
      most_m = apart_m;
      widest = {&a, &b};
    }
  }
  return widest;
}

}  // namespace

void GuessParts(std::span<Seen> devices) {
  if (devices.empty()) return;
  if (Find(devices, body::kHead) == nullptr) {
    auto head = std::ranges::find_if(
        devices, [](const Seen& d) { return d.is_head && d.part == Seen::kUnknown; });
    if (head == devices.end()) {
      head = std::ranges::max_element(devices, {}, [](const Seen& d) { return d.position_m.y(); });
      if (head->part != Seen::kUnknown || head->position_m.y() < kLeastHead_m) head = devices.end();
    }
    if (head != devices.end()) {
      head->part = body::kHead;
      head->guessed = !head->is_head;
    }
  }
  const Seen* const head = Find(devices, body::kHead);
  const float scale = head == nullptr ? 1 : head->position_m.y() / HeadHeight_m(*head);
  if (!(scale > 0)) return;
  const auto [one, other] = Widest(devices);
  float heading = 0;
  if (head != nullptr && head->is_head && head->has_rotation) {
    heading = HeadingOf(head->rotation);
  } else if (one != nullptr) {
    heading = HeadingOfLeft(one->position_m - other->position_m);
    if (std::abs(heading) > kPi / 2) heading = std::remainder(heading + kPi, 2 * kPi);
  }
  const Vec3 left(std::cos(heading), 0, -std::sin(heading));
  Vec3 centre = Vec3::Zero();
  if (one != nullptr) centre = 0.5F * (one->position_m + other->position_m);
  if (head != nullptr) centre = head->position_m;

  // The closest of all pairs of a device and a free part, until none is close enough.
  for (;;) {
    Seen* best = nullptr;
    int part = Seen::kUnknown;
    float least_m = kFarthest_m;
    for (Seen& device : devices) {
      if (device.part != Seen::kUnknown) continue;
      const float aside_m = (device.position_m - centre).dot(left) / scale;
      const float up_m = device.position_m.y() / scale;
      for (const Usual& usual : kUsual) {
        const float off_m = std::hypot(aside_m - usual.left_m, up_m - usual.up_m);
        if (off_m >= least_m || Find(devices, usual.part) != nullptr) continue;
        least_m = off_m;
        best = &device;
        part = usual.part;
      }
    }
    if (best == nullptr) return;
    best->part = part;
    best->guessed = true;
  }
}

Stance FindStance(std::span<const Seen> devices) {
  Stance stance;
  const Seen* const head = Find(devices, body::kHead);
  const Seen* const hips = Find(devices, body::kHips);
  const Seen* const left = Find(devices, body::kLeftHand);
  const Seen* const right = Find(devices, body::kRightHand);
  stance.faced_by = "nothing: +Z is assumed to be ahead";
  for (const Pair& pair : kPairs) {
    if (pair.left != body::kLeftHand && head != nullptr && head->has_rotation) {
      stance.heading = HeadingOf(head->rotation);
      stance.faced_by = "the head";
      break;
    }
    const Seen* const a = Find(devices, pair.left);
    const Seen* const b = Find(devices, pair.right);
    if (a == nullptr || b == nullptr) continue;
    const Vec3 apart = Flat(a->position_m - b->position_m);
    if (apart.norm() < kLeastPair_m) continue;
    stance.heading = HeadingOfLeft(apart);
    stance.faced_by = pair.name;
    break;
  }

  body::WorldPose rest;
  body::ForwardKinematics(body::Pose(), rest);
  const auto apart_m = [](const Vec3& a, const Vec3& b) { return Flat(a - b).norm(); };
  if (head != nullptr) {
    stance.scale = head->position_m.y() / HeadHeight_m(*head);
    stance.scaled_by = "the head's height";
  } else if (left != nullptr && right != nullptr) {
    stance.scale = apart_m(left->position_m, right->position_m) /
                   apart_m(rest.positions_m[body::kLeftHand], rest.positions_m[body::kRightHand]);
    stance.scaled_by = "the distance of the hands";
  } else if (hips != nullptr) {
    stance.scale = hips->position_m.y() / rest.positions_m[body::kHips].y();
    stance.scaled_by = "the hips' height";
  } else {
    stance.scaled_by = "nothing";
  }

  const Seen* const left_foot = Find(devices, body::kLeftFoot);
  const Seen* const right_foot = Find(devices, body::kRightFoot);
  const Vec3 ahead(std::sin(stance.heading), 0, std::cos(stance.heading));
  if (left != nullptr && right != nullptr) {
    stance.place_m = Flat(0.5F * (left->position_m + right->position_m));
  } else if (left_foot != nullptr && right_foot != nullptr) {
    stance.place_m = Flat(0.5F * (left_foot->position_m + right_foot->position_m));
  } else if (hips != nullptr) {
    stance.place_m = Flat(hips->position_m);
  } else if (head != nullptr) {
    const float eyes_m = head->at_joint ? 0 : kEyesAhead_m * stance.scale;
    stance.place_m = Flat(head->position_m) - eyes_m * ahead;
  }
  return stance;
}

}  // namespace styled::devices
