#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <string>

#include "model/clip/clip.h"
#include "tests/support/temporary_folder.h"
#include "tests/unit/body/random_pose.h"

namespace styled::clip {
namespace {

using body::Angle_rad;
using body::Random;
using rig::Quat;
using rig::Vec3;
using testing::HasSubstr;

constexpr double kTenThousandthDegree_rad = 1e-4 * 3.14159265 / 180;

// A chain of three joints whose rotations drift without bound, in the given channel order.
Clip Wandering(const std::string& order, unsigned seed, int frames = 200) {
  Random random(seed);
  Clip clip;
  clip.skeleton.names = {"root", "a", "b"};
  clip.skeleton.parents = {-1, 0, 1};
  clip.skeleton.offsets = {Vec3(1, 2, 3), Vec3(0, 10, 0), Vec3(0.5F, -3, 1e-5F)};
  clip.channels = {"XYZ" + order, order, order};
  clip.end_sites = {{}, {}, {Vec3(0, 1, 0)}};
  rig::RigPose pose(clip.skeleton);
  for (int frame = 0; frame < frames; ++frame) {
    for (Quat& q : pose.rotations) q = (q * random.Turn(0.3F)).normalized();
    pose.translations[0] += random.Vector(3);
    clip.frames.push_back(pose);
  }
  return clip;
}

Clip Reread(const Clip& clip) {
  Result<Clip> again = ParseBvh(FormatBvh(clip), "written");
  EXPECT_TRUE(again.ok()) << again.status().message();
  return again.ok() ? again.value() : Clip();
}

void ExpectSameMotion(const Clip& a, const Clip& b, const std::string& what) {
  ASSERT_EQ(a.frames.size(), b.frames.size()) << what;
  for (std::size_t frame = 0; frame < a.frames.size(); ++frame) {
    for (int joint = 0; joint < a.skeleton.joint_count(); ++joint) {
      ASSERT_LT(Angle_rad(a.frames[frame].rotations[joint], b.frames[frame].rotations[joint]),
                kTenThousandthDegree_rad)
          << what << " frame " << frame << " joint " << joint;
      ASSERT_LT((a.frames[frame].translations[joint] - b.frames[frame].translations[joint]).norm(),
                1e-4)
          << what;
    }
  }
}

// The numbers of the motion rows.
std::vector<std::vector<double>> Rows(const std::string& text) {
  std::vector<std::vector<double>> rows;
  std::size_t at = text.find('\n', text.find("Frame Time")) + 1;
  while (at < text.size()) {
    const std::size_t end = text.find('\n', at);
    std::vector<double>& row = rows.emplace_back();
    while (at < end) {
      const std::size_t next = std::min(text.find(' ', at), end);
      std::from_chars(text.data() + at, text.data() + next, row.emplace_back());
      at = next + 1;
    }
    at = end + 1;
  }
  return rows;
}

TEST(WriteBvh, RefusesAnEmptyClipARateOutOfRangeAndAPlaceThatCannotBeWritten) {
  EXPECT_THAT(WriteBvh(Clip(), "/tmp/x.bvh").message(), HasSubstr("without joints or frames"));
  Clip clip = Wandering("zxy", 1, 2);
  EXPECT_THAT(WriteBvh(clip, "/nonexistent/x.bvh").message(),
              HasSubstr("cannot be opened for writing: No such file or directory"));
  for (double bad : {0.0, -30.0, 1e9, std::nan("")}) {
    clip.rate_hz = bad;
    EXPECT_THAT(WriteBvh(clip, "/tmp/x.bvh").message(), HasSubstr("expected 1 to 1000"));
  }
}

TEST(WriteBvh, GivesTheMotionBackInAllSixOrders) {
  for (const char* order : {"xyz", "xzy", "yxz", "yzx", "zxy", "zyx"}) {
    const Clip clip = Wandering(order, 2);
    const Clip again = Reread(clip);
    ExpectSameMotion(clip, again, order);
    EXPECT_EQ(again.channels, clip.channels);
    EXPECT_EQ(again.end_sites[2], clip.end_sites[2]);
    EXPECT_EQ(again.skeleton.names, clip.skeleton.names);
    EXPECT_EQ(again.skeleton.parents, clip.skeleton.parents);
    for (int joint = 0; joint < 3; ++joint) {
      EXPECT_LT((again.skeleton.offsets[joint] - clip.skeleton.offsets[joint]).norm(), 1e-6);
    }
  }
}

TEST(WriteBvh, KeepsAnglesContinuousOverManyTurns) {
  for (const char* order : {"xyz", "xzy", "yxz", "yzx", "zxy", "zyx"}) {
    Clip clip = Wandering(order, 3, 1);
    for (int frame = 1; frame < 300; ++frame) {  // 300 * 7 degrees, about the first axis
      rig::RigPose pose = clip.frames[0];
      const Vec3 axis = Vec3::Unit(order[0] - 'x');
      pose.rotations[1] = Quat(Eigen::AngleAxisf(0.122F * static_cast<float>(frame), axis)) *
                          clip.frames[0].rotations[1];
      clip.frames.push_back(pose);
    }
    const auto rows = Rows(FormatBvh(clip));
    for (std::size_t frame = 1; frame < rows.size(); ++frame) {
      for (std::size_t i = 6; i < 9; ++i) {
        EXPECT_LT(std::abs(rows[frame][i] - rows[frame - 1][i]), 8) << order << " " << frame;
      }
    }
    EXPECT_GT(std::abs(rows.back()[6] - rows[0][6]), 2000) << "turns add up";
  }
}

TEST(WriteBvh, PassesStraightThroughTheGimbalWithoutAJump) {
  for (const char* order : {"xyz", "xzy", "yxz", "yzx", "zxy", "zyx"}) {
    Clip clip = Wandering(order, 4, 1);
    clip.frames[0].rotations[1] = Quat::Identity();
    // about the middle axis, passing exactly through 90
    for (int degree = 1; degree <= 360; ++degree) {
      rig::RigPose pose = clip.frames[0];
      pose.rotations[1] = Quat(Eigen::AngleAxisf(static_cast<float>(degree) * 0.0174532925F,
                                                 Vec3::Unit(order[1] - 'x')));
      clip.frames.push_back(pose);
    }
    const auto rows = Rows(FormatBvh(clip));
    for (std::size_t frame = 1; frame < rows.size(); ++frame) {
      EXPECT_NEAR(rows[frame][7] - rows[frame - 1][7], 1, 0.01) << order << " " << frame;
    }
    ExpectSameMotion(clip, Reread(clip), order);
  }
}

TEST(WriteBvh, HoldsItsPrecisionAtAndNearTheGimbal) {
  Random random(5);
  for (const char* order : {"xyz", "xzy", "yxz", "yzx", "zxy", "zyx"}) {
    Clip clip = Wandering(order, 5, 1);
    for (float off : {0.0F, 1e-8F, 1e-7F, 1e-6F, 1e-5F, 1e-4F, 1e-3F}) {
      for (float quarter : {1.57079633F, -1.57079633F}) {
        rig::RigPose pose = clip.frames[0];
        const auto turn = [&](int i, float angle) {
          return Quat(Eigen::AngleAxisf(angle, Vec3::Unit(order[i] - 'x')));
        };
        pose.rotations[1] = turn(0, random.Between(-3, 3)) * turn(1, quarter + off) *
                            turn(2, random.Between(-3, 3));
        clip.frames.push_back(pose);
      }
    }
    ExpectSameMotion(clip, Reread(clip), order);
  }
}

TEST(WriteBvh, GivesJointsWithFewerThanThreeRotationChannelsBack) {
  for (const char* order : {"x", "y", "z", "xy", "xz", "yx", "yz", "zx", "zy"}) {
    std::string text =
        "HIERARCHY ROOT a\n{ OFFSET 0 0 0 CHANNELS " + std::to_string(std::string(order).size());
    for (char kind : std::string(order)) {
      text += std::string(" ") + static_cast<char>(kind - 'x' + 'X') + "rotation";
    }
    text += " } MOTION Frames: 100 Frame Time: 0.01\n";
    Random random(6);
    for (int frame = 0; frame < 100; ++frame) {
      for (std::size_t i = 0; i < std::string(order).size(); ++i) {
        text += std::to_string(random.Between(-179, 179)) + " ";
      }
      text += "\n";
    }
    const Clip clip = ParseBvh(text, "x").value();
    ExpectSameMotion(clip, Reread(clip), order);
  }
}

TEST(WriteBvh, WithoutChannelsWritesRootPositionsAndZxy) {
  Clip clip = Wandering("zxy", 7, 10);
  clip.channels.clear();
  clip.end_sites.clear();
  const Clip again = Reread(clip);
  EXPECT_THAT(again.channels, testing::ElementsAre("XYZzxy", "zxy", "zxy"));
  ASSERT_EQ(again.end_sites[2].size(), 1U) << "every chain ends in an End Site";
  ExpectSameMotion(clip, again, "default");
}

TEST(WriteBvh, WritesJointsDepthFirstWithTheirOwnMotion) {
  Clip clip = Wandering("zxy", 8, 5);
  clip.skeleton.names.emplace_back("c");  // a second child of "a", after "b"'s subtree begins
  clip.skeleton.parents = {-1, 0, 0, 1};  // breadth first: root, a, b, c under a
  clip.skeleton.offsets.emplace_back(Vec3(9, 9, 9));
  clip.channels.emplace_back("xyz");
  clip.end_sites.emplace_back();
  for (rig::RigPose& frame : clip.frames) {
    frame.translations.emplace_back(Vec3(9, 9, 9));
    frame.rotations.push_back(Quat(Eigen::AngleAxisf(0.7F, Vec3::UnitX())));
  }
  const Clip again = Reread(clip);
  EXPECT_THAT(again.skeleton.names, testing::ElementsAre("root", "a", "c", "b"));
  EXPECT_LT(Angle_rad(again.frames[3].rotations[2], clip.frames[3].rotations[3]), 1e-6);
  EXPECT_LT(Angle_rad(again.frames[3].rotations[3], clip.frames[3].rotations[2]), 1e-6);
}

TEST(WriteBvh, KeepsTheRate) {
  for (double rate_hz : {1.0, 24000.0 / 1001, 25.0, 30.0, 33.3, 60.0, 90.0, 119.88, 120.0, 240.0}) {
    Clip clip = Wandering("zxy", 9, 2);
    clip.rate_hz = rate_hz;
    EXPECT_NEAR(Reread(clip).rate_hz / rate_hz, 1, 2e-6);
  }
}

TEST(WriteBvh, WritesAFileThatReadsBack) {
  const support::TemporaryFolder folder;
  const std::string file = folder / "x.bvh";
  const Clip clip = Wandering("yxz", 10);
  ASSERT_TRUE(WriteBvh(clip, file).ok());
  const Result<Clip> again = ReadBvh(file);
  ASSERT_TRUE(again.ok()) << again.status().message();
  ExpectSameMotion(clip, again.value(), "file");
}

}  // namespace
}  // namespace styled::clip
