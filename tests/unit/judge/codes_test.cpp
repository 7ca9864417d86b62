#include "model/train/judge/codes.h"

#include <gtest/gtest.h>

#include <cmath>

#include "model/clip/clip.h"
#include "tests/support/temporary_folder.h"
#include "tests/unit/judge/arm_network.h"
#include "tests/unit/train/walker.h"

namespace styled::judge {
namespace {

// Three styles of one content, which differ in the angle of the left arm, as do the clips of each.
struct CodesTest : testing::Test {
  static constexpr int kCount = 3;
  Data data;
  support::TemporaryFolder folder;

  void SetUp() override {
    data.manifest.styles = {{"neutral", {}, {}}, {"low", {}, {}}, {"high", {}, {}}};
    data.manifest.contents = {"walk"};
    for (int style = 0; style < 3; ++style) {
      for (int i = 0; i < 4; ++i) {
        train::TrainingClip clip = train::Walker(140, 0.4F * static_cast<float>(i));
        clip.style = style;
        SetArm(clip.poses, ArmNetwork::StyleAngle_rad(style) + 0.1F * static_cast<float>(i - 1));
        data.validation.push_back(clip);
        data.judge.push_back(std::move(clip));
      }
    }
    data.inputs = {clip::ResamplePoses(data.validation[0].poses, kJudgeRate_hz, kStreamRate_hz)};
    data.contents = {0};
  }

  CodeSpace Measured(bool deaf) {
    const auto judges = TrainJudges(data, {.iterations = 4, .batch = 8}, folder.path());
    EXPECT_TRUE(judges.ok()) << judges.status().message();
    const auto network = std::make_shared<ArmNetwork>(ArmHabits{.share = deaf ? 0.0F : 1.0F});
    const ClipRestyler restyler(network, {kAbsent, 1, 2}, {}, {.rate_hz = kJudgeRate_hz});
    return MeasureCodes(data, judges.value(), restyler, kCount);
  }
};

TEST_F(CodesTest, ANetworkThatIgnoresItsCodeScoresNothing) {
  const CodeSpace codes = Measured(true);
  ASSERT_EQ(codes.noise.distance_cm.count, 2);  // two styles
  EXPECT_EQ(codes.noise.distance_cm.value(), 0);
  ASSERT_EQ(codes.examples.distance_cm.count, 2);
  EXPECT_EQ(codes.examples.distance_cm.value(), 0);
  EXPECT_GT(codes.examples.recognized.count, 0) << "recognition is reported beside it";
  EXPECT_EQ(codes.of_all.examples, 8);
  EXPECT_EQ(codes.of_all.slope, 0);
  EXPECT_EQ(codes.of_all.cosine, 0);
  ASSERT_EQ(codes.halves.count, 2);
  EXPECT_EQ(codes.halves.value(), 1);
  EXPECT_EQ(codes.pairs, 1);
  EXPECT_EQ(codes.monotone, 0);
  EXPECT_TRUE(std::isnan(codes.largest_step));
  EXPECT_GT(codes.consistency.value(), 0.2) << "what is read off the output is not its code";
  const nlohmann::json json = ToJson(data.manifest, codes);
  EXPECT_EQ(json["following"]["halves"], 1.0);
  EXPECT_TRUE(json["interpolation"]["half"].is_null());
  testing::internal::CaptureStdout();
  Print(data.manifest, codes);
  const std::string text = testing::internal::GetCapturedStdout();
  EXPECT_NE(text.find("monotone in 0 of 1 pairs, at 1/4, 1/2, 3/4: -, -, -; largest step - of"),
            std::string::npos)
      << text;
}

TEST_F(CodesTest, ANetworkThatFollowsItsCodeScoresAll) {
  const CodeSpace codes = Measured(false);
  EXPECT_GT(codes.real_cm.value(), 0.1);
  EXPECT_EQ(codes.real_by_content[0].value(), codes.real_cm.value());
  EXPECT_GT(codes.noise.distance_cm.value(), 0.1);
  EXPECT_GT(codes.examples.distance_cm.value(), 0.1);
  EXPECT_GT(codes.noise.by_style[1].value(), 0.1);
  EXPECT_GT(codes.of_all.slope, 0.8);
  EXPECT_GT(codes.of_all.cosine, 0.9);
  EXPECT_LT(codes.halves.value(), 0.2);
  EXPECT_EQ(codes.monotone, 1);
  EXPECT_NEAR(codes.half.value(), 0.5, 0.1);
  EXPECT_LT(codes.largest_step, 1.5);
  EXPECT_LT(codes.consistency.value(), 0.1);
  EXPECT_NEAR(ToJson(data.manifest, codes)["interpolation"]["half"].get<double>(), 0.5, 0.1);
}

}  // namespace
}  // namespace styled::judge
