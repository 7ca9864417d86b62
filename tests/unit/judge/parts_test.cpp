#include "model/train/judge/parts.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>

#include "model/train/judge/comparison.h"
#include "tests/unit/train/walker.h"

namespace styled::judge {
namespace {

constexpr int kFrames = 80;

std::size_t View(std::string_view key) {
  const auto& views = PartViews();
  return static_cast<std::size_t>(
      std::find_if(views.begin(), views.end(), [=](const PartView& v) { return v.key == key; }) -
      views.begin());
}

// Two styles that differ in the arms alone: style 1 holds them up and swings them three times as
// wide.
train::TrainingClip CalmOrWildClip(int style, float phase) {
  train::TrainingClip clip = train::Walker(kFrames, phase);
  clip.style = style;
  for (std::size_t t = 0; t < clip.poses.size(); ++t) {
    const float swing = (style == 1 ? 0.9F : 0.3F) * std::sin(0.3F * static_cast<float>(t) + phase);
    for (const int arm : {body::kLeftUpperArm, body::kRightUpperArm}) {
      clip.poses[t].rotations[static_cast<std::size_t>(arm)] =
          body::Exp(body::Vec3(swing, 0, style == 1 ? 0.8F : 0.0F));
    }
  }
  return clip;
}

struct PartJudgesTest : testing::Test {
  std::vector<train::TrainingClip> clips;

  void SetUp() override {
    for (int i = 0; i < 6; ++i) {
      for (const int style : {0, 1}) clips.push_back(CalmOrWildClip(style, static_cast<float>(i)));
    }
  }
  static void TearDownTestSuite() { std::filesystem::remove_all(Cache()); }
  static std::filesystem::path Cache() {
    return std::filesystem::temp_directory_path() / ("styled_parts_" + std::to_string(::getpid()));
  }
  // Trains once for all tests.
  Result<PartJudges> Train(int iterations = 80) const {
    return PartJudges::TrainOrLoad(clips, 2, 1, {.iterations = iterations, .batch = 16}, Cache(),
                                   "arms-" + std::to_string(iterations));
  }
};

TEST_F(PartJudgesTest, APartsJudgeSeesItsPartAlone) {
  const auto judges = Train();
  ASSERT_TRUE(judges.ok()) << judges.status().message();
  for (const float phase : {0.5F, 2.5F}) {
    const auto calm = judges.value().Judge(CalmOrWildClip(0, phase).poses, 8).front();
    const auto wild = judges.value().Judge(CalmOrWildClip(1, phase).poses, 8).front();
    for (const char* arms : {"arms_pose", "arms_movement", "movement"}) {
      const std::size_t view = View(arms);
      ASSERT_FALSE(calm[view].empty());
      EXPECT_EQ(std::count(calm[view].begin(), calm[view].end(), 0),
                static_cast<long>(calm[view].size()))
          << arms;
      EXPECT_EQ(std::count(wild[view].begin(), wild[view].end(), 1),
                static_cast<long>(wild[view].size()))
          << arms;
    }
    for (const char* other : {"legs_pose", "legs_movement", "trunk_pose", "trunk_movement"}) {
      EXPECT_EQ(calm[View(other)], wild[View(other)]) << other;
    }
  }
}

TEST_F(PartJudgesTest, AJudgeOfMovementDoesNotSeeWhereTheHipsAre) {
  const auto judges = Train();
  ASSERT_TRUE(judges.ok()) << judges.status().message();
  train::TrainingClip high = CalmOrWildClip(1, 0.7F);
  const auto before = judges.value().Judge(high.poses, 4).front();
  for (body::Pose& pose : high.poses) pose.hips_position_m.y() += 0.5F;
  const auto after = judges.value().Judge(high.poses, 4).front();
  EXPECT_EQ(before[View("movement")], after[View("movement")]);
}

TEST_F(PartJudgesTest, AreReadFromTheCacheAsTheyWereTrained) {
  const auto trained = Train(3);
  ASSERT_TRUE(trained.ok());
  clips.clear();  // cannot be trained on
  const auto read = Train(3);
  ASSERT_TRUE(read.ok()) << read.status().message();
  const auto poses = CalmOrWildClip(1, 0.2F).poses;
  EXPECT_EQ(trained.value().Judge(poses, 4), read.value().Judge(poses, 4));
}

TEST_F(PartJudgesTest, AClipShorterThanAWindowIsNotJudged) {
  const auto judges = Train();
  ASSERT_TRUE(judges.ok());
  const auto poses = CalmOrWildClip(1, 0.2F).poses;
  const auto by_judge = judges.value().Judge(std::span(poses).first(32), 4);
  for (const auto& answers : by_judge.front()) {
    EXPECT_TRUE(answers.empty());
  }
}

}  // namespace
}  // namespace styled::judge
