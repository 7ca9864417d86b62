#include "model/gait/tracker.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "tests/unit/body/random_pose.h"
#include "tests/unit/gait/performed.h"

namespace styled::gait {
namespace {

using body::Pose;
using body::Vec3;
using Poses = std::vector<Pose>;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

float MostAfter(const std::vector<Phase>& phases, double from_s, double rate_hz = 60) {
  float most = 0;
  for (auto i = static_cast<std::size_t>(from_s * rate_hz); i < phases.size(); ++i) {
    most = std::max(most, phases[i].confidence);
  }
  return most;
}

float LeastAfter(const std::vector<Phase>& phases, double from_s, double rate_hz = 60) {
  float least = 1;
  for (auto i = static_cast<std::size_t>(from_s * rate_hz); i < phases.size(); ++i) {
    least = std::min(least, phases[i].confidence);
  }
  return least;
}

// Two feet whose distance is a sine of 0.3 m, the forward-moving one lifted; nothing else.
class Steps {
 public:
  explicit Steps(float hz) : rate_rad_s_(hz * tuning::kTurn_rad) {}

  const Phase& Follow(float dt_s, bool stands = false) {
    if (!stands) phase_rad_ += rate_rad_s_ * dt_s;
    Vec3& left = world_.positions_m[body::kLeftFoot];
    Vec3& right = world_.positions_m[body::kRightFoot];
    left = Vec3(0.1F, 0.1F + 0.1F * std::max(0.0F, -std::sin(phase_rad_)),
                0.15F * std::cos(phase_rad_));
    right = Vec3(-0.1F, 0.1F + 0.1F * std::max(0.0F, std::sin(phase_rad_)),
                 -0.15F * std::cos(phase_rad_));
    world_.positions_m[body::kHips] = Vec3(0, 0.9F, 0);
    tracker_.Follow(world_, 0, Vec3::Zero(), dt_s);
    return tracker_.phase();
  }
  float phase_rad() const { return phase_rad_; }
  Tracker& tracker() { return tracker_; }

 private:
  float rate_rad_s_, phase_rad_ = 1;
  body::WorldPose world_{};
  Tracker tracker_;
};

TEST(TrackerTest, FollowsMadeStepsWithoutLagAtTheirRate) {
  for (const float hz : {0.6F, 0.9F, 1.4F}) {
    for (const float rate_hz : {24.0F, 60.0F, 240.0F}) {
      Steps steps(hz);
      for (int i = 0; i < static_cast<int>(4 * rate_hz); ++i) steps.Follow(1 / rate_hz);
      double rate_rad_s = 0;
      const int stride = static_cast<int>(std::round(rate_hz / hz));
      for (int i = 0; i < stride; ++i) {
        const Phase& phase = steps.Follow(1 / rate_hz);
        rate_rad_s += static_cast<double>(phase.rate_rad_s) / stride;
        EXPECT_GT(phase.confidence, 0.95F) << hz << " of " << rate_hz;
        EXPECT_NEAR(Between_rad(phase.phase_rad, steps.phase_rad()), 0, 4 * kDegree)
            << hz << " of " << rate_hz;
      }
      EXPECT_NEAR(rate_rad_s, hz * tuning::kTurn_rad, 0.01F * tuning::kTurn_rad)
          << hz << " of " << rate_hz;
    }
  }
}

TEST(TrackerTest, LocksWithinASecond) {
  for (const char* script : {"walk:60", "run:60", "turn-left:60"}) {
    const auto phases = PhasesOf(Perform(script, 10));
    EXPECT_GT(phases[66].confidence, 0.5F) << script;
    EXPECT_GT(LeastAfter(phases, 2), 0.9F) << script;
  }
}

TEST(TrackerTest, ReleasesWithinHalfASecondWhereverTheFeetStop) {
  for (int stop = 200; stop < 270; stop += 5) {
    Steps steps(0.9F);
    for (int i = 0; i < stop; ++i) steps.Follow(1.0F / 60);
    EXPECT_GT(steps.tracker().phase().confidence, 0.95F);
    for (int i = 0; i < 30; ++i) steps.Follow(1.0F / 60, true);
    EXPECT_LT(steps.tracker().phase().confidence, 0.5F) << stop;
    for (int i = 0; i < 60; ++i) steps.Follow(1.0F / 60, true);
    EXPECT_LT(steps.tracker().phase().confidence, 0.05F) << stop;
  }
}

TEST(TrackerTest, KnowsNoGaitInStandingAndWaving) {
  EXPECT_EQ(MostAfter(PhasesOf(Perform("stand:60", 20)), 0), 0);
  EXPECT_LT(MostAfter(PhasesOf(Perform("stand:1,wave-left:9,wave-both:9", 20)), 0), 0.01F);
  EXPECT_LT(MostAfter(PhasesOf(Perform("stand:1,raise-both:9,raise-right:9", 20)), 0), 0.01F);
}

TEST(TrackerTest, AStandAfterAWalkIsNoGait) {
  EXPECT_LT(MostAfter(PhasesOf(Perform("walk:5,stand:5", 10)), 6.5), 0.01F);
}

TEST(TrackerTest, StepsBackwardAreNoGaitAlsoOnTheSpot) {
  Poses poses = Perform("walk:60", 10);
  std::reverse(poses.begin(), poses.end());
  EXPECT_LT(MostAfter(PhasesOf(poses), 1), 0.1F);
  for (Pose& pose : poses) pose.hips_position_m.x() = pose.hips_position_m.z() = 0;
  EXPECT_LT(MostAfter(PhasesOf(poses), 0), 0.1F);
}

TEST(TrackerTest, AWalkOnTheSpotIsAGait) {
  Poses poses = Perform("walk:60", 10);
  for (Pose& pose : poses) pose.hips_position_m.x() = pose.hips_position_m.z() = 0;
  EXPECT_GT(LeastAfter(PhasesOf(poses), 2), 0.9F);
}

TEST(TrackerTest, StepsToTheSideAreNoGait) {
  for (const float degrees : {-90.0F, -45.0F, 45.0F, 90.0F, 135.0F}) {
    Poses poses = Perform("walk:60", 10);
    for (Pose& pose : poses) {
      pose.hips_position_m = body::Yaw(degrees * kDegree) * pose.hips_position_m;
    }
    EXPECT_LT(MostAfter(PhasesOf(poses), 3), 0.3F) << degrees;
  }
}

TEST(TrackerTest, ACircleIsAGaitAndItsPhaseDoesNotDependOnTheHeading) {
  const Poses circle = Perform("turn-right:60", 20);
  EXPECT_GT(LeastAfter(PhasesOf(circle), 2), 0.9F);
  const auto here = PhasesOf(circle);
  Poses moved;
  for (const Pose& pose : circle) moved.push_back(body::Moved(pose, 2, {7, 0, -3}));
  const auto there = PhasesOf(moved);
  for (std::size_t i = 0; i < here.size(); ++i) {
    ASSERT_NEAR(Between_rad(here[i].phase_rad, there[i].phase_rad), 0, 0.1F * kDegree) << i;
    ASSERT_NEAR(here[i].confidence, there[i].confidence, 1e-3F) << i;
  }
}

TEST(TrackerTest, AMirroredWalkIsHalfAStrideApart) {
  const Poses poses = Perform("walk:60", 8);
  Poses mirrored = poses;
  for (Pose& pose : mirrored) body::Mirror(pose, pose);
  const auto here = PhasesOf(poses), there = PhasesOf(mirrored);
  for (std::size_t i = 3 * 60; i < here.size(); ++i) {
    EXPECT_NEAR(Between_rad(here[i].phase_rad, there[i].phase_rad + tuning::kTurn_rad / 2), 0,
                2 * kDegree);
  }
}

// From one frame to the next, and back: the gait stays locked.
TEST(TrackerTest, AWalkThatIsMirroredIsFollowedOn) {
  const Poses poses = Perform("walk:60", 8);
  const auto expected = PhasesOf(poses);
  Follower follower, other;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const bool mirrored = i >= 5 * 60;
    if (i == 5 * 60) follower.tracker.Mirror();
    Pose pose = poses[i];
    if (mirrored) body::Mirror(pose, pose);
    const Phase& phase = follower.Follow(pose, 1.0F / 60);
    const Phase& unaware = other.Follow(pose, 1.0F / 60);
    if (i < 3 * 60) continue;
    EXPECT_NEAR(Between_rad(phase.phase_rad,
                            expected[i].phase_rad + (mirrored ? tuning::kTurn_rad / 2 : 0)),
                0, 2 * kDegree)
        << i;
    EXPECT_GT(phase.confidence, 0.9F) << i;
    if (i == 5 * 60 + 5) {
      EXPECT_GT(std::abs(Between_rad(unaware.phase_rad, phase.phase_rad)), 30 * kDegree);
    }
  }
}

TEST(TrackerTest, ThePhaseIsTheSameAtEveryRate) {
  for (const char* script : {"walk:60", "run:60"}) {
    const auto expected = PhasesOf(Perform(script, 8, 120), 120);
    for (const int rate_hz : {24, 30, 60, 90, 240}) {
      const auto phases = PhasesOf(Perform(script, 8, rate_hz), rate_hz);
      for (int s = 2; s < 8; ++s) {
        const Phase& phase = phases[static_cast<std::size_t>(s * rate_hz)];
        const Phase& same = expected[static_cast<std::size_t>(s) * 120];
        EXPECT_NEAR(Between_rad(phase.phase_rad, same.phase_rad), 0, 4 * kDegree)
            << script << " at " << rate_hz << " Hz, " << s << " s";
        EXPECT_NEAR(phase.rate_rad_s, same.rate_rad_s, 0.02F * tuning::kTurn_rad);
        EXPECT_NEAR(phase.confidence, same.confidence, 0.05F);
      }
    }
  }
}

TEST(TrackerTest, FramesThatComeUnevenlyChangeLittle) {
  const Poses poses = Perform("walk:60", 10, 240);
  const auto expected = PhasesOf(poses, 240);
  body::Random random(3);
  Follower follower;
  std::size_t last = 0;
  for (std::size_t i = 0; i < poses.size();) {
    const Phase& phase = follower.Follow(poses[i], static_cast<float>(i - last) / 240);
    if (i > 2 * 240) {
      EXPECT_NEAR(Between_rad(phase.phase_rad, expected[i].phase_rad), 0, 6 * kDegree) << i;
      EXPECT_GT(phase.confidence, 0.9F) << i;
    }
    last = i;
    i += static_cast<std::size_t>(random.Between(1, 9));  // 4 to 33 ms
  }
}

TEST(TrackerTest, AShortHoleIsBridgedAndALongOneStartsAgain) {
  const Poses poses = Perform("walk:60", 10);
  const auto expected = PhasesOf(poses);
  Follower follower;
  for (std::size_t i = 0; i < 240; ++i) follower.Follow(poses[i], 1.0F / 60);
  Follower longer = follower;
  follower.Follow(poses[239 + 15], 15.0F / 60);
  for (std::size_t i = 239 + 16; i < 300; ++i) {
    const Phase& phase = follower.Follow(poses[i], 1.0F / 60);
    EXPECT_NEAR(Between_rad(phase.phase_rad, expected[i].phase_rad), 0, 20 * kDegree) << i;
    EXPECT_GT(phase.confidence, 0.8F) << i;
  }
  EXPECT_EQ(longer.Follow(poses[239 + 40], 40.0F / 60).confidence, 0);
}

TEST(TrackerTest, AFrameWithoutTimeChangesNothing) {
  Steps steps(0.9F);
  for (int i = 0; i < 200; ++i) steps.Follow(1.0F / 60);
  const Phase before = steps.tracker().phase();
  steps.Follow(0);
  steps.Follow(-1);
  EXPECT_EQ(steps.tracker().phase().phase_rad, before.phase_rad);
  EXPECT_EQ(steps.tracker().phase().confidence, before.confidence);
}

TEST(TrackerTest, NothingThatIsAbsurdStaysBehind) {
  const Poses walk = Perform("walk:60", 4);
  body::Random random(1);
  const auto ends_sound = [&](const char* name, const auto& damage) {
    Follower follower;
    for (int i = 0; i < 120; ++i) {
      body::WorldPose world;
      body::ForwardKinematics(i % 2 == 0 ? random.AnyPose() : walk[10], world);
      Vec3 velocity_mps = Vec3::Zero();
      float heading_rad = 0, dt_s = 1.0F / 60;
      damage(world, velocity_mps, heading_rad, dt_s);
      follower.tracker.Follow(world, heading_rad, velocity_mps, dt_s);
      const Phase& phase = follower.tracker.phase();
      EXPECT_TRUE(phase.phase_rad >= 0 && phase.phase_rad <= tuning::kTurn_rad) << name;
      EXPECT_TRUE(std::isfinite(phase.rate_rad_s) && std::isfinite(phase.bounce_m)) << name;
      EXPECT_TRUE(phase.confidence >= 0 && phase.confidence <= 1) << name;
    }
    for (const Pose& pose : walk) follower.Follow(pose, 1.0F / 60);
    EXPECT_GT(follower.tracker.phase().confidence, 0.9F) << name;
  };
  using W = body::WorldPose;
  ends_sound("any pose", [](W&, Vec3&, float&, float&) {});
  ends_sound("far", [](W& w, Vec3&, float&, float&) { w.positions_m[body::kLeftFoot] *= 1e30F; });
  ends_sound("foot",
             [](W& w, Vec3&, float&, float&) { w.positions_m[body::kLeftFoot].y() = kNan; });
  ends_sound("hips", [](W& w, Vec3&, float&, float&) { w.positions_m[body::kHips].y() = kNan; });
  ends_sound("velocity", [](W&, Vec3& v, float&, float&) { v.x() = kNan; });
  ends_sound("speed", [](W&, Vec3& v, float&, float&) { v.x() = 1e38F; });
  ends_sound("heading", [](W&, Vec3&, float& heading, float&) { heading = kNan; });
  ends_sound("time", [](W&, Vec3&, float&, float& dt) { dt = kNan; });
  for (const float short_s : {1e-3F, 1e-6F, 1e-9F, 1e-12F, 1e-40F}) {
    ends_sound("short", [short_s](W&, Vec3&, float&, float& dt) { dt = short_s; });
  }
}

TEST(TrackerTest, TheNoiseOfARigIsNoGaitAndHidesNone) {
  body::Random random(9);
  for (const char* script : {"stand:60", "walk:60"}) {
    Follower follower;
    for (const Pose& pose : Perform(script, 10, 120)) {
      body::WorldPose world;
      body::ForwardKinematics(pose, world);
      world.positions_m[body::kLeftFoot] += random.Vector(0.005F);
      world.positions_m[body::kRightFoot] += random.Vector(0.005F);
      follower.velocity.Follow(pose.hips_position_m, 1.0F / 120);
      follower.tracker.Follow(world, body::Heading_rad(world), follower.velocity.mps(), 1.0F / 120);
    }
    EXPECT_NEAR(follower.tracker.phase().confidence, script[0] == 'w' ? 1 : 0, 0.05F) << script;
  }
}

TEST(TrackerTest, TenMinutesAreLikeTheFirst) {
  Steps steps(0.93F);
  for (int i = 0; i < 10 * 60 * 120; ++i) steps.Follow(1.0F / 120);
  const Phase& phase = steps.tracker().phase();
  EXPECT_GT(phase.confidence, 0.99F);
  EXPECT_NEAR(phase.rate_rad_s, 0.93F * tuning::kTurn_rad, 0.01F * tuning::kTurn_rad);
  EXPECT_GE(phase.phase_rad, 0);
  EXPECT_LE(phase.phase_rad, tuning::kTurn_rad);
}

TEST(TrackerTest, TellsARunFromAWalk) {
  const auto share = [](const char* script, bool on_the_spot) {
    Poses poses = Perform(script, 8);
    Follower follower;
    for (Pose& pose : poses) {
      if (on_the_spot) pose.hips_position_m.x() = pose.hips_position_m.z() = 0;
      follower.Follow(pose, 1.0F / 60);
    }
    return RunShare(follower.tracker.phase(), follower.velocity.mps().norm());
  };
  for (const bool on_the_spot : {false, true}) {
    EXPECT_LT(share("walk:60", on_the_spot), 0.1F);
    EXPECT_LT(share("turn-left:60", on_the_spot), 0.1F);
    EXPECT_GT(share("run:60", on_the_spot), 0.9F);
  }
}

TEST(TrackerTest, ThePhaseBeforeIsThatOfTheSameRate) {
  Steps steps(0.9F);
  for (int i = 0; i < 300; ++i) steps.Follow(1.0F / 60);
  const float now_rad = steps.tracker().phase().phase_rad;
  const Phase before = steps.tracker().Before(1).phase();
  EXPECT_NEAR(Between_rad(before.phase_rad, now_rad - 0.9F * tuning::kTurn_rad), 0, 5 * kDegree);
  EXPECT_GE(before.phase_rad, 0);
}

std::vector<std::byte> Written(Tracker& tracker) {
  Checkpoint count;
  tracker.Carry(count);
  std::vector<std::byte> bytes(count.size());
  auto into = Checkpoint::Into(bytes);
  tracker.Carry(into);
  return bytes;
}

TEST(TrackerTest, ACheckpointContinuesBitForBit) {
  const Poses poses = Perform("walk:60", 6);
  Follower one;
  for (std::size_t i = 0; i < 200; ++i) one.Follow(poses[i], 1.0F / 60);
  const auto bytes = Written(one.tracker);
  Follower other = one;
  other.tracker = Tracker();
  auto from = Checkpoint::From(bytes);
  other.tracker.Carry(from);
  ASSERT_TRUE(from.complete());
  for (std::size_t i = 200; i < poses.size(); ++i) {
    one.Follow(poses[i], 1.0F / 60);
    other.Follow(poses[i], 1.0F / 60);
  }
  EXPECT_EQ(Written(one.tracker), Written(other.tracker));
}

TEST(TrackerTest, ACheckpointWithoutSenseIsRefused) {
  Steps steps(0.9F);
  for (int i = 0; i < 200; ++i) steps.Follow(1.0F / 60);
  const auto bytes = Written(steps.tracker());  // numbers, then a flag
  for (const float wrong : {kNan, std::numeric_limits<float>::infinity(), -1e30F}) {
    for (std::size_t at = 0; at + 4 < bytes.size(); at += 4) {
      auto damaged = bytes;
      std::memcpy(&damaged[at], &wrong, 4);
      Tracker tracker;
      auto from = Checkpoint::From(damaged);
      tracker.Carry(from);
      EXPECT_FALSE(from.ok()) << "number " << at / 4 << ", " << wrong;
    }
  }
  auto from = Checkpoint::From(std::span(bytes).first(bytes.size() - 1));
  Tracker tracker;
  tracker.Carry(from);
  EXPECT_FALSE(from.complete());
}

}  // namespace
}  // namespace styled::gait
