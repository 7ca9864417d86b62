#include "model/train/judge/mixed.h"

#include <gtest/gtest.h>

#include <set>

#include "tests/support/temporary_folder.h"
#include "tests/unit/judge/arm_network.h"
#include "tests/unit/train/walker.h"

namespace styled::judge {
namespace {

TEST(MixedClip, HasEveryActAndNoFrameOfABlendInASegment) {
  Data data;
  data.manifest.contents = {"walk", "raise", "run"};
  for (const auto& [content, height_m] : {std::pair{0, 1.0F}, {1, 2.0F}, {2, 3.0F}}) {
    train::TrainingClip& clip = data.validation.emplace_back();
    clip.content = content;
    clip.poses.resize(150);
    for (body::Pose& pose : clip.poses) pose.hips_position_m.y() = height_m;
  }
  const MixedClip mixed = MakeMixed(data);
  ASSERT_EQ(mixed.poses.size(), kMixedFrames);
  std::set<int> contents;
  for (const MixedClip::Segment& segment : mixed.segments) {
    contents.insert(segment.content);
    for (std::size_t i = segment.begin; i < segment.end; ++i) {
      ASSERT_EQ(mixed.poses[i].hips_position_m.y(), static_cast<float>(segment.content + 1));
    }
  }
  EXPECT_EQ(contents, (std::set<int>{0, 2}));
  EXPECT_TRUE(MakeMixed({}).poses.empty());
}

// Three styles that differ in the angle of the left arm; walks, and runs that lean forward. No clip
// bows, and no weights know the style "other".
struct MixedTest : testing::Test {
  enum Content { kWalk, kBow, kRun };
  // Far apart, so that judges learn them in seconds: neutral, and the network's styles 1 and 4.
  static inline const float kArms_rad[] = {-1, ArmNetwork::StyleAngle_rad(1),
                                           ArmNetwork::StyleAngle_rad(4)};
  Data data;
  support::TemporaryFolder folder;

  void SetUp() override {
    data.manifest.styles = {
        {"neutral", {}, {}}, {"low", {}, {}}, {"high", {}, {}}, {"other", {}, {}}};
    data.manifest.contents = {"walk", "bow", "run"};
    for (int style = 0; style < 3; ++style) {
      for (const int content : {kWalk, kRun}) {
        for (int i = 0; i < 2; ++i) {
          train::TrainingClip clip = train::Walker(140, 0.8F * static_cast<float>(i));
          clip.style = style;
          clip.content = content;
          SetArm(clip.poses, kArms_rad[style]);
          for (body::Pose& pose : clip.poses) {
            pose.rotations[body::kRightUpperArm] = Arm(0);  // judges learn from mirror images, too
            if (content == kRun) pose.rotations[body::kSpine] = body::Exp(body::Vec3(0.8F, 0, 0));
          }
          data.validation.push_back(clip);
          data.judge.push_back(std::move(clip));
        }
      }
    }
  }

  MixedFigures Measured(const ArmHabits& habits, int iterations = 120) {
    const auto judges = TrainJudges(data, {.iterations = iterations, .batch = 16}, folder.path());
    EXPECT_TRUE(judges.ok()) << judges.status().message();
    const ClipRestyler restyler(std::make_shared<ArmNetwork>(habits), {kAbsent, 1, 4, kAbsent}, {},
                                {.rate_hz = kJudgeRate_hz});
    return MeasureMixed(data, judges.value(), restyler);
  }

  // Windows of 32 frames at every eighth frame of the segments of a content; the first frame of
  // each has no velocity.
  double Windows(int content) const {
    double windows = 0;
    for (const MixedClip::Segment& segment : MakeMixed(data).segments) {
      const auto frames = static_cast<int>(segment.end - segment.begin) - 1;
      if (segment.content == content && frames >= 32) windows += (frames - 32) / 8 + 1;
    }
    return windows;
  }
};

TEST_F(MixedTest, ANetworkThatFollowsIsRecognizedInEveryAct) {
  const MixedFigures figures = Measured({});
  EXPECT_NEAR(figures.seconds, 1000 / 30.0, 1e-9);
  ASSERT_EQ(figures.acts.size(), 3U);
  for (const int content : {kWalk, kRun}) {
    const MixedFigures::Act& act = figures.acts[static_cast<std::size_t>(content)];
    ASSERT_GT(Windows(content), 10);
    EXPECT_EQ(act.content_of_input.count, Windows(content));
    for (const ActRecognition* of : {&act.mixed, &act.alone}) {
      EXPECT_EQ(of->style.count, 2 * Windows(content)) << "two styles";
      EXPECT_EQ(of->content.count, 2 * Windows(content));
      EXPECT_GT(of->style.value(), 0.9);
      EXPECT_GT(of->content.value(), 0.9);
    }
    EXPECT_GT(act.content_of_input.value(), 0.9);
  }
  EXPECT_EQ(figures.acts[kBow].mixed.style.count, 0);
  EXPECT_EQ(figures.acts[kBow].content_of_input.count, 0);

  const nlohmann::json json = ToJson(data.manifest, figures);
  EXPECT_EQ(json["acts"].size(), 2U) << "no row for what nobody does";
  EXPECT_EQ(json["acts"]["run"]["windows"], 2 * Windows(kRun));
  testing::internal::CaptureStdout();
  Print(data.manifest, figures);
  const std::string text = testing::internal::GetCapturedStdout();
  EXPECT_NE(text.find("\nrun "), std::string::npos) << text;
  EXPECT_EQ(text.find("\nbow "), std::string::npos) << text;
}

TEST_F(MixedTest, ANetworkThatIgnoresItsCodeIsRecognizedInOneOfTwoStyles) {
  const MixedFigures figures = Measured({.share = 0});
  for (const int content : {kWalk, kRun}) {
    const MixedFigures::Act& act = figures.acts[static_cast<std::size_t>(content)];
    ASSERT_EQ(act.mixed.style.count, 2 * Windows(content));
    EXPECT_NEAR(act.mixed.style.value(), 0.5, 0.05) << "all of one style, nothing of the other";
    EXPECT_NEAR(act.alone.style.value(), 0.5, 0.05);
    EXPECT_GT(act.mixed.content.value(), 0.9);
  }
}

TEST_F(MixedTest, AStyleThatIsLostInALongClipIsSeenInTheMixedClipAlone) {
  // Each act is shorter than what this network styles of a clip.
  const MixedFigures figures = Measured({.frames = 128});
  for (const int content : {kWalk, kRun}) {
    const MixedFigures::Act& act = figures.acts[static_cast<std::size_t>(content)];
    EXPECT_GT(act.alone.style.value(), 0.9);
    EXPECT_LT(act.mixed.style.value(), 0.4);
    EXPECT_GT(act.mixed.content.value(), 0.9);
  }
  EXPECT_LT(figures.acts[kRun].mixed.style.value(), 0.05) << "the first act is a walk";
}

TEST_F(MixedTest, NothingIsMeasuredWhereEveryClipIsTooShort) {
  for (train::TrainingClip& clip : data.validation) clip.poses.resize(40);
  const MixedFigures figures = Measured({}, 1);
  EXPECT_EQ(figures.seconds, 0);
  ASSERT_EQ(figures.acts.size(), 3U);
  EXPECT_EQ(figures.acts[kWalk].mixed.style.count, 0);
  EXPECT_TRUE(ToJson(data.manifest, figures)["acts"].empty());
}

TEST(RestyleRecorded, GivesAsManyPosesAtTheClipsRateWhicheverRateIsStyled) {
  for (const int frames : {1, 4, 75, 140}) {
    Poses walk = train::Walker(frames).poses;
    SetArm(walk, 0);
    for (const double rate_hz : {kJudgeRate_hz, kStreamRate_hz}) {
      SCOPED_TRACE(std::to_string(frames) + " frames at " + std::to_string(rate_hz));
      const auto network = std::make_shared<ArmNetwork>(ArmHabits{});
      const ClipRestyler restyler(network, {}, {}, {.rate_hz = rate_hz});
      const Poses out = RestyleRecorded(restyler, walk, {0.7F});
      ASSERT_EQ(out.size(), walk.size());
      for (std::size_t i = 0; i < out.size(); ++i) {
        ASSERT_NEAR(ArmOf(out[i]), 0.7F, 0.02F) << i;
        ASSERT_LT((out[i].hips_position_m - walk[i].hips_position_m).norm(), 0.05F) << i;
      }
    }
  }
}

}  // namespace
}  // namespace styled::judge
