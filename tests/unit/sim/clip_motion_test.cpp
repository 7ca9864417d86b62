#include "sim/player/clip_motion.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <set>
#include <string>

#include "sim/player/performer_motion.h"
#include "tests/support/temporary_folder.h"

namespace styled::player {
namespace {

namespace fs = std::filesystem;

class ClipMotionTest : public ::testing::Test {
 protected:
  // A walking performer's first seconds as BVH.
  fs::path Write(const std::string& name, const std::string& script, double seconds) {
    const auto parsed = synthetic::ParseScript(script);
    EXPECT_TRUE(parsed.ok());
    PerformerMotion motion({1, 1, 0, parsed.value()}, {}, 30);
    const Status status = WriteMotion(motion, seconds, 30, folder_ / name);
    EXPECT_TRUE(status.ok()) << status.message();
    return folder_ / name;
  }

  support::TemporaryFolder temporary_;
  const fs::path& folder_ = temporary_.path();
};

TEST_F(ClipMotionTest, MissingAndEmptyFilesAreNamed) {
  const auto missing = FindClips({folder_ / "no.bvh"});
  ASSERT_FALSE(missing.ok());
  EXPECT_NE(missing.status().message().find("no.bvh: not found"), std::string::npos);
  const auto empty = FindClips({folder_});
  ASSERT_FALSE(empty.ok());
  EXPECT_NE(empty.status().message().find("no *.bvh in it"), std::string::npos);
  std::ofstream(folder_ / "bad.bvh") << "nonsense\n";
  const auto bad = ClipMotion::Make({folder_ / "bad.bvh"}, {});
  ASSERT_FALSE(bad.ok());
  EXPECT_NE(bad.status().message().find("bad.bvh:1"), std::string::npos) << bad.status().message();
}

TEST_F(ClipMotionTest, AFolderStandsForItsFilesByName) {
  Write("b.bvh", "stand:1", 0.2);
  Write("a.BVH", "stand:1", 0.2);
  std::ofstream(folder_ / "notes.txt") << "x";
  const auto files = FindClips({folder_});
  ASSERT_TRUE(files.ok());
  EXPECT_EQ(files.value(), (std::vector<fs::path>{folder_ / "a.BVH", folder_ / "b.bvh"}));
}

TEST_F(ClipMotionTest, AClipThatIsTooLargeAtTheRateIsRefused) {
  std::ofstream slow(folder_ / "slow.bvh");
  slow << "HIERARCHY\nROOT a\n{\nOFFSET 0 0 0\nCHANNELS 6 Xposition Yposition "
          "Zposition Zrotation Xrotation Yrotation\n}\nMOTION\nFrames: 60000\nFrame Time: 1\n";
  for (int i = 0; i < 60000; ++i) slow << "0.00 0.00 0.00 0.00 0.00 0.00\n";
  slow.close();
  const auto refused = ClipMotion::Make({folder_ / "slow.bvh"}, {.rate_hz = 120});
  ASSERT_FALSE(refused.ok());
  EXPECT_NE(refused.status().message().find("MiB at 120 Hz, expected at most 512 MiB"),
            std::string::npos)
      << refused.status().message();
  EXPECT_TRUE(ClipMotion::Make({folder_ / "slow.bvh"}, {.rate_hz = 5}).ok());
}

TEST_F(ClipMotionTest, JointsByHandAndThoseTheyDecideAreSentUnderTheHumanoidsNames) {
  const auto file = Write("walk.bvh", "walk:10", 1);
  const auto made = ClipMotion::Make({file}, {.joints = {{"neck", "head"}, {"head", "neck"}}});
  ASSERT_TRUE(made.ok()) << made.status().message();
  const auto& names = made.value()->body().skeleton.names;
  EXPECT_EQ(names[body::kHead], "neck");
  EXPECT_EQ(names[body::kLeftUpperArm], "leftUpperArm");
  std::set<std::string> all(names.begin(), names.end());
  EXPECT_EQ(all.size(), names.size()) << "one name for each";
  const auto wrong = ClipMotion::Make({file}, {.joints = {{"neck", "Hals"}}});
  ASSERT_FALSE(wrong.ok());
  EXPECT_NE(wrong.status().message().find("walk.bvh: joints.neck: the rig has no joint"),
            std::string::npos)
      << wrong.status().message();
}

TEST_F(ClipMotionTest, PlaysAFileOnceAtTheAskedRate) {
  const auto file = Write("walk.bvh", "walk:10", 3);
  auto made = ClipMotion::Make({file}, {.rate_hz = 120});
  ASSERT_TRUE(made.ok()) << made.status().message();
  ClipMotion& motion = *made.value();
  EXPECT_EQ(motion.body().skeleton.joint_count(), body::kJointCount);
  rig::RigPose pose;
  int frames = 0;
  while (motion.Next(pose) == Motion::Step::kPose) ++frames;
  EXPECT_EQ(frames, 4 * 89 + 1);  // from the first to the last of 90 frames at 30 Hz
}

TEST_F(ClipMotionTest, PlaysSeveralFilesAsOneBodyAfterTheOther) {
  const auto a = Write("a.bvh", "walk:10", 0.5), b = Write("b.bvh", "stand:10", 0.5);
  auto made = ClipMotion::Make({a, b}, {.rate_hz = 30, .first = 1});
  ASSERT_TRUE(made.ok());
  rig::RigPose pose;
  std::vector<int> frames{0};
  for (;;) {
    const auto step = made.value()->Next(pose);
    if (step == Motion::Step::kEnd) break;
    ASSERT_NE(step, Motion::Step::kError);
    if (step == Motion::Step::kNewBody) frames.push_back(0);
    frames.back() += step == Motion::Step::kPose;
  }
  EXPECT_EQ(frames, (std::vector<int>{15, 15}));
}

TEST_F(ClipMotionTest, ALoopGoesOnWhereItEndedAndNeverJumps) {
  const auto file = Write("turn.bvh", "walk:2,turn-left:1,run:2", 4);
  auto made = ClipMotion::Make({file}, {.rate_hz = 120, .loop = true});
  ASSERT_TRUE(made.ok());
  rig::RigPose before, pose;
  float fastest_turn = 0, fastest_cm = 0, farthest_cm = 0;
  ASSERT_EQ(made.value()->Next(before), Motion::Step::kPose);
  for (int i = 1; i < 120 * 30; ++i) {
    ASSERT_EQ(made.value()->Next(pose), Motion::Step::kPose);
    for (std::size_t j = 0; j < pose.rotations.size(); ++j) {
      fastest_turn = std::max(fastest_turn, before.rotations[j].angularDistance(pose.rotations[j]));
      EXPECT_NEAR(pose.rotations[j].norm(), 1, 1e-5);
    }
    fastest_cm = std::max(fastest_cm, (pose.translations[0] - before.translations[0]).norm());
    farthest_cm = std::max(farthest_cm, pose.translations[0].norm());
    EXPECT_GT(pose.translations[0].y(), 80);
    EXPECT_LT(pose.translations[0].y(), 120);
    before = pose;
  }
  EXPECT_LT(fastest_turn, 0.2);  // 24 rad/s; a running knee makes 13
  EXPECT_LT(fastest_cm, 4.5);    // 5.4 m/s
  EXPECT_GT(farthest_cm, 300);
}

}  // namespace
}  // namespace styled::player
