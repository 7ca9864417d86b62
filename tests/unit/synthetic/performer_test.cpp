#include "model/synthetic/performer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace styled::synthetic {
namespace {

using body::kJointCount;

constexpr double kRate_hz = 120;

Options Scripted(std::string_view text, std::uint64_t seed = 1) {
  const auto script = ParseScript(text);
  EXPECT_TRUE(script.ok()) << script.status().message();
  return Vary(seed, 0, script.value());
}

struct Recording {
  std::vector<body::Pose> poses;
  std::vector<body::WorldPose> world;
  std::vector<std::array<double, 2>> contacts;
  std::vector<synthetic::Motion> motions;
};

Recording Record(Options options, double seconds, double rate_hz = kRate_hz) {
  Performer performer(std::move(options));
  Recording r;
  for (int i = 0; i < seconds * rate_hz; ++i) {
    body::Pose pose;
    body::WorldPose world;
    performer.Pose(i / rate_hz, pose);
    body::ForwardKinematics(pose, world);
    r.poses.push_back(pose);
    r.world.push_back(world);
    r.contacts.push_back(performer.contacts());
    r.motions.push_back(performer.motion());
  }
  return r;
}

bool Same(const body::Pose& a, const body::Pose& b) {
  if (a.hips_position_m != b.hips_position_m) return false;
  for (int j = 0; j < kJointCount; ++j) {
    if (a.rotations[j].coeffs() != b.rotations[j].coeffs()) return false;
  }
  return true;
}

// Largest angular speed (rad/s) and acceleration (rad/s^2) of any joint, largest acceleration of
// the hips (m/s^2), from differences.
struct Violence {
  double speed = 0, acceleration = 0, hips_acceleration = 0;
};
Violence Worst(const Recording& r) {
  Violence worst;
  std::array<body::Vec3, kJointCount> before;
  for (std::size_t i = 1; i < r.poses.size(); ++i) {
    for (int j = 0; j < kJointCount; ++j) {
      const body::Vec3 speed =
          body::Log(r.poses[i - 1].rotations[j].conjugate() * r.poses[i].rotations[j]) *
          static_cast<float>(kRate_hz);
      worst.speed = std::max(worst.speed, static_cast<double>(speed.norm()));
      if (i > 1) {
        worst.acceleration = std::max(worst.acceleration, (speed - before[j]).norm() * kRate_hz);
      }
      before[j] = speed;
    }
    if (i + 1 < r.poses.size()) {
      const body::Vec3 second = r.poses[i + 1].hips_position_m - 2 * r.poses[i].hips_position_m +
                                r.poses[i - 1].hips_position_m;
      worst.hips_acceleration =
          std::max(worst.hips_acceleration, second.norm() * kRate_hz * kRate_hz);
    }
  }
  return worst;
}

constexpr std::string_view kEverything =
    "stand:1,walk:3,turn-left:2,run:3,turn-right:2,walk:2,stand:1.5,wave-left:3,wave-right:3,"
    "wave-both:3,raise-left:2,raise-right:2,raise-both:2,walk:0.5,stand:0.3,run:0.7,raise-left:0.4,"
    "walk:1,stand:2";

TEST(Performer, IsTheSameForTheSameSeedAndAnotherForAnother) {
  const Recording a = Record(Vary(5, 0, {}), 60), b = Record(Vary(5, 0, {}), 60);
  const Recording c = Record(Vary(6, 0, {}), 60), d = Record(Vary(5, 1, {}), 60);
  bool differs_c = false, differs_d = false;
  for (std::size_t i = 0; i < a.poses.size(); ++i) {
    ASSERT_TRUE(Same(a.poses[i], b.poses[i])) << i;
    differs_c = differs_c || !Same(a.poses[i], c.poses[i]);
    differs_d = differs_d || !Same(a.poses[i], d.poses[i]);
  }
  EXPECT_TRUE(differs_c);
  EXPECT_TRUE(differs_d);
}

TEST(Performer, MovesTheSameAtWhateverRateItIsLookedAt) {
  const Recording at_120 = Record(Scripted(kEverything), 30, 120);
  const Recording at_30 = Record(Scripted(kEverything), 30, 30);
  const Recording at_100 = Record(Scripted(kEverything), 30, 100);
  for (std::size_t i = 0; i < at_30.poses.size(); ++i) {
    EXPECT_TRUE(Same(at_30.poses[i], at_120.poses[4 * i])) << i;
  }
  for (std::size_t i = 0; 5 * i < at_100.poses.size(); ++i) {  // every 50 ms: on a tick of both
    EXPECT_TRUE(Same(at_100.poses[5 * i], at_120.poses[6 * i])) << i;
  }
}

TEST(Performer, IsSmoothBetweenTicksToo) {
  Performer coarse(Scripted("walk:20")), fine(Scripted("walk:20"));
  for (int i = 0; i < 5000; ++i) {
    body::Pose a, b;
    coarse.Pose(i / 1000.0, a);
    fine.Pose(i / 1000.0 + 1e-4, b);
    for (int j = 0; j < kJointCount; ++j) {
      EXPECT_LT(a.rotations[j].angularDistance(b.rotations[j]), 0.003) << i << " " << j;
    }
    EXPECT_LT((a.hips_position_m - b.hips_position_m).norm(), 0.001);
  }
}

TEST(Performer, NeverJerksThroughEveryMotionAndTransition) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    const Violence worst = Worst(Record(Scripted(kEverything, seed), 80));
    EXPECT_LT(worst.speed, 16) << seed;  // 920 deg/s, 7.6 deg in 1/120 s; a running knee
    EXPECT_LT(worst.acceleration, 350) << seed;
    EXPECT_LT(worst.hips_acceleration, 35) << seed;
  }
}

TEST(Performer, MovesGentlyWhereTheMotionIsGentle) {
  for (const auto& [script, speed, acceleration] :
       {std::tuple{"stand:10", 0.5, 5.0}, {"walk:20", 10.0, 180.0}, {"wave-left:6", 9.0, 140.0}}) {
    const Violence worst = Worst(Record(Scripted(script), 30));
    EXPECT_LT(worst.speed, speed) << script;
    EXPECT_LT(worst.acceleration, acceleration) << script;
  }
}

TEST(Performer, KeepsAStandingFootWhereItStands) {
  const Recording r = Record(Scripted(kEverything), 80);
  double slid_m = 0, stood_s = 0, fastest = 0;
  for (std::size_t i = 1; i < r.world.size(); ++i) {
    for (int side = 0; side < 2; ++side) {
      if (r.contacts[i][side] < 0.99 || r.contacts[i - 1][side] < 0.99) continue;
      const int toes = side == 0 ? body::kLeftToes : body::kRightToes;
      body::Vec3 moved = r.world[i].positions_m[toes] - r.world[i - 1].positions_m[toes];
      moved.y() = 0;
      slid_m += moved.norm();
      stood_s += 1 / kRate_hz;
      fastest = std::max(fastest, moved.norm() * kRate_hz);
    }
  }
  EXPECT_GT(stood_s, 40);
  EXPECT_LT(slid_m / stood_s, 0.01);  // m/s on average
  EXPECT_LT(fastest, 0.25);
}

TEST(Performer, StandsOnTheFloorAndLeavesItOnlyInARun) {
  const Recording r = Record(Scripted("stand:2,walk:4,turn-left:3,stand:2,wave-both:4"), 60);
  for (std::size_t i = 0; i < r.world.size(); ++i) {
    const float lowest_m = body::LowestFoot_m(r.world[i]);
    EXPECT_GT(lowest_m, 0.015) << i;
    EXPECT_LT(lowest_m, 0.075) << i;
  }
  const Recording run = Record(Scripted("run:10"), 20);
  float highest_m = 0;
  for (const body::WorldPose& world : run.world) {
    EXPECT_GT(body::LowestFoot_m(world), 0.015);
    highest_m = std::max(highest_m, body::LowestFoot_m(world));
  }
  EXPECT_GT(highest_m, 0.10);
  EXPECT_LT(highest_m, 0.25);
}

TEST(Performer, NeverBendsAKneeBackwards) {
  const Recording r = Record(Scripted(kEverything), 80);
  for (std::size_t i = 0; i < r.poses.size(); ++i) {
    for (const int knee : {body::kLeftLowerLeg, body::kRightLowerLeg}) {
      EXPECT_GT(body::Log(r.poses[i].rotations[knee]).x(), 0) << i;
    }
  }
}

TEST(Performer, ThePerformerFollowsTheScript) {
  // A Vec3 by name: Eigen's difference would refer to a recording that is gone.
  const auto walked = [](std::string_view script) -> body::Vec3 {
    const Recording r = Record(Scripted(script), 10);
    return r.poses.back().hips_position_m - r.poses.front().hips_position_m;
  };
  EXPECT_LT(walked("stand:20").norm(), 0.1);
  const body::Vec3 walk = walked("walk:20"), run = walked("run:20");
  EXPECT_NEAR(walk.z() / 10, 1.2, 0.25);
  EXPECT_NEAR(walk.x() / 10, 0, 0.15);
  EXPECT_NEAR(run.z() / 10, 2.9, 0.5);
  const Recording left = Record(Scripted("walk:2,turn-left:2,walk:9"), 6);
  EXPECT_GT(left.poses.back().hips_position_m.x(), 1.0);  // +X is to the left of +Z
  const Recording right = Record(Scripted("walk:2,turn-right:2,walk:9"), 6);
  EXPECT_LT(right.poses.back().hips_position_m.x(), -1.0);
}

TEST(Performer, RaisesAndWavesTheHandsNamed) {
  const auto highest = [](std::string_view script, int hand) {
    const Recording r = Record(Scripted(script), 6);
    float y = 0;
    for (const body::WorldPose& world : r.world) y = std::max(y, world.positions_m[hand].y());
    return y;
  };
  for (const std::string gesture : {"raise", "wave"}) {
    for (const std::string side : {"left", "right", "both"}) {
      const std::string script = gesture + "-" + side + ":5,stand:9";
      EXPECT_EQ(highest(script, body::kLeftHand) > 1.5F, side != "right") << script;
      EXPECT_EQ(highest(script, body::kRightHand) > 1.5F, side != "left") << script;
    }
  }
}

TEST(Performer, WavesToAndFro) {
  const Recording r = Record(Scripted("wave-left:8,stand:9"), 8);
  int turns = 0;
  float before = 0;
  for (std::size_t i = 3 * 120; i < 6 * 120; ++i) {
    const float speed = r.world[i].positions_m[body::kLeftHand].x() -
                        r.world[i - 1].positions_m[body::kLeftHand].x();
    turns += before * speed < 0;
    before = speed;
  }
  EXPECT_GE(turns, 8);  // 1.65 Hz for 3 s
  EXPECT_LE(turns, 12);
}

TEST(Performer, StaysSaneThroughTenMinutesOfRandomOrder) {
  const Recording r = Record(Vary(42, 3, {}), 600);
  const Violence worst = Worst(r);
  EXPECT_LT(worst.speed, 16);
  EXPECT_LT(worst.acceleration, 350);
  std::array<int, static_cast<std::size_t>(synthetic::Motion::kCount)> seen{};
  for (std::size_t i = 0; i < r.poses.size(); ++i) {
    ++seen[static_cast<std::size_t>(r.motions[i])];
    const body::Vec3& hips = r.poses[i].hips_position_m;
    ASSERT_TRUE(hips.allFinite());
    EXPECT_GT(hips.y(), 0.80F);
    EXPECT_LT(hips.y(), 1.10F);
    EXPECT_LT(std::hypot(hips.x(), hips.z()), 40);
    EXPECT_GT(body::LowestFoot_m(r.world[i]), 0.01F) << i;
    for (const body::Quat& q : r.poses[i].rotations) EXPECT_NEAR(q.norm(), 1, 1e-5);
  }
  for (std::size_t m = 0; m < seen.size(); ++m) {
    EXPECT_GT(seen[m], 120) << Name(static_cast<synthetic::Motion>(m));
  }
}

TEST(Performer, IsItsOwnPersonAmongSeveral) {
  for (std::uint64_t k = 0; k < 20; ++k) {
    const Options a = Vary(1, k, {}), b = Vary(1, k + 1, {});
    EXPECT_NE(a.seed, b.seed);
    EXPECT_NE(a.speed, b.speed);
    EXPECT_NE(a.phase, b.phase);
    const Proportions p = VaryProportions(1, k);
    for (const float share : {p.height, p.torso, p.arms}) {
      EXPECT_GT(share, 0.9F);
      EXPECT_LT(share, 1.1F);
    }
  }
}

TEST(Performer, HasTheCanonicalSkeletonInItsOwnProportions) {
  const rig::Skeleton same = MakeSkeleton({});
  const rig::Skeleton tall = MakeSkeleton({1.1F, 1.05F, 0.95F});
  ASSERT_EQ(same.joint_count(), kJointCount);
  for (int j = 0; j < kJointCount; ++j) {
    EXPECT_EQ(same.names[j], body::kHumanoid[j].name);
    EXPECT_EQ(same.parents[j], body::kHumanoid[j].parent);
    EXPECT_EQ(same.offsets[j], body::Offset(j));
  }
  EXPECT_FLOAT_EQ(tall.offsets[body::kHips].y(), 1.1F * same.offsets[body::kHips].y());
  EXPECT_FLOAT_EQ(tall.offsets[body::kLeftLowerLeg].y(),
                  1.1F * same.offsets[body::kLeftLowerLeg].y());
  EXPECT_FLOAT_EQ(tall.offsets[body::kLeftHand].x(),
                  1.1F * 0.95F * same.offsets[body::kLeftHand].x());
}

}  // namespace
}  // namespace styled::synthetic
