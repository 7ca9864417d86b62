// How good the body is that devices give: real clips, exact devices mounted anyhow, and the error
// of all joints beside the dumbest method, a T-pose that goes and turns with the true hips.
#include "model/clip/clip.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>

#include "model/clip/bind_clip.h"
#include "tests/unit/devices/mounted.h"

namespace styled::devices {
namespace {

using testing::kMs;
using testing::Worn;

struct Error {
  double mean_deg = 0, worst_deg = 0, mean_cm = 0, worst_cm = 0;
};

class Errors {
 public:
  void Add(const body::Pose& found, const body::Pose& expected) {
    body::WorldPose a, b;
    body::ForwardKinematics(found, a);
    body::ForwardKinematics(expected, b);
    for (std::size_t j = 0; j < body::kJointCount; ++j) {
      const double deg = 57.29578 * a.rotations[j].angularDistance(b.rotations[j]);
      const double cm = 100 * (a.positions_m[j] - b.positions_m[j]).norm();
      sum_.mean_deg += deg;
      sum_.mean_cm += cm;
      sum_.worst_deg = std::max(sum_.worst_deg, deg);
      sum_.worst_cm = std::max(sum_.worst_cm, cm);
      joint_deg_[j] += deg;
      joint_cm_[j] += cm;
      ++count_;
    }
  }
  Error error() const {
    Error error = sum_;
    error.mean_deg /= count_;
    error.mean_cm /= count_;
    return error;
  }
  void PrintJoints() const {
    for (std::size_t j = 0; j < body::kJointCount; ++j) {
      std::printf("  %s %.1f deg %.1f cm\n", body::kHumanoid[j].name.data(),
                  joint_deg_[j] * body::kJointCount / count_,
                  joint_cm_[j] * body::kJointCount / count_);
    }
  }

 private:
  Error sum_;
  std::array<double, body::kJointCount> joint_deg_{}, joint_cm_{};
  double count_ = 0;
};

// The poses of a clip, at 60 Hz.
std::vector<body::Pose> Poses(const std::string& name) {
  const std::filesystem::path file = std::filesystem::path(STYLED_PARITY_DATA) / name;
  if (!std::filesystem::exists(file)) return {};
  const auto read = clip::ReadBvh(file);
  EXPECT_TRUE(read.ok()) << read.status().message();
  const clip::Clip resampled = clip::Resample(read.value(), 60);
  const auto bound = clip::BindClip(resampled);
  EXPECT_TRUE(bound.ok()) << bound.status().message();
  return clip::ToCanonical(resampled, bound.value().binding);
}

struct Set {
  const char* name;
  std::vector<int> parts;
};
const std::vector<Set> kSets{
    {"3", {body::kHead, body::kLeftHand, body::kRightHand}},
    {"6",
     {body::kHead, body::kLeftHand, body::kRightHand, body::kHips, body::kLeftFoot,
      body::kRightFoot}},
    {"8",
     {body::kHead, body::kLeftHand, body::kRightHand, body::kHips, body::kLeftFoot,
      body::kRightFoot, body::kLeftUpperLeg, body::kRightUpperLeg}},
    {"11",
     {body::kHead, body::kLeftHand, body::kRightHand, body::kHips, body::kLeftFoot,
      body::kRightFoot, body::kLeftUpperLeg, body::kRightUpperLeg, body::kChest,
      body::kLeftUpperArm, body::kRightUpperArm}}};

Error Solve(const std::vector<body::Pose>& poses, const std::vector<int>& parts, bool joints) {
  const Worn worn(parts, 5, 1.1F, 0.93F);
  Devices devices(Devices::Options{});
  worn.Measure(body::Pose(), 0, devices);
  (void)devices.Reset(0, worn.TrueStance());
  Errors errors;
  std::int64_t now_ns = 0;
  for (const body::Pose& pose : poses) {
    // Twice, so that the delay does not show.
    for (int k = 0; k < 2; ++k) worn.Measure(pose, now_ns += 20 * kMs, devices);
    body::Pose found;
    EXPECT_TRUE(devices.Solve(now_ns, found));
    errors.Add(worn.Back(found), pose);
  }
  if (joints) errors.PrintJoints();
  return errors.error();
}

Error Dumbest(const std::vector<body::Pose>& poses) {
  Errors errors;
  for (const body::Pose& pose : poses) {
    body::Pose dumb;
    dumb.hips_position_m = pose.hips_position_m;
    dumb.rotations[body::kHips] = pose.rotations[body::kHips];
    errors.Add(dumb, pose);
  }
  return errors.error();
}

void Print(const char* clip, const char* points, const Error& error) {
  std::printf("%-6s %-8s mean %5.1f deg %5.1f cm, worst %5.1f deg %5.1f cm\n", clip, points,
              error.mean_deg, error.mean_cm, error.worst_deg, error.worst_cm);
}

TEST(DevicesClip, TheMoreDevicesTheCloserAndAlwaysCloserThanTheDumbest) {
  for (const auto& [name, file] : {std::pair{"walk", "dataset-1_walk_normal_001.bvh"},
                                   {"dance", "dataset-1_dance-short_normal_001.bvh"}}) {
    const auto poses = Poses(file);
    if (poses.empty()) GTEST_SKIP() << "skipped, no data (set STYLED_DATA)";
    const Error dumbest = Dumbest(poses);
    Print(name, "T-pose", dumbest);
    Error before = dumbest;
    for (const Set& set : kSets) {
      const Error error = Solve(poses, set.parts, std::getenv("STYLED_JOINTS") != nullptr);
      Print(name, set.name, error);
      EXPECT_LT(error.mean_deg, before.mean_deg) << name << " " << set.name;
      EXPECT_LT(error.mean_cm, before.mean_cm + 0.01) << name << " " << set.name;
      before = error;
    }
  }
}

}  // namespace
}  // namespace styled::devices
