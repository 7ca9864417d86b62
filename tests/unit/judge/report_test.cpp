#include "model/train/judge/report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <numeric>

#include "model/clip/clip.h"
#include "tests/unit/train/walker.h"

namespace styled::judge {
namespace {

// Two styles and two contents; the odd waves have clips, but none as long as a window.
struct EvaluatorTest : testing::Test {
  static constexpr int kNeutral = 0, kOdd = 1, kWalk = 0, kWave = 1;
  const std::filesystem::path cache = std::filesystem::temp_directory_path() /
                                      ("styled_judge_report_" + std::to_string(::getpid()));
  clip::Manifest manifest;
  std::vector<train::TrainingClip> clips;

  void SetUp() override {
    manifest.styles = {{"neutral", {}, {}}, {"odd", {}, {}}};
    manifest.contents = {"walk", "wave"};
    for (const int style : {kNeutral, kOdd}) {
      for (const int content : {kWalk, kWave}) {
        const bool cut = style == kOdd && content == kWave;
        clips.push_back(train::Walker(cut ? 20 : 80, static_cast<float>(style)));
        clips.back().style = style;
        clips.back().content = content;
      }
    }
  }
  void TearDown() override { std::filesystem::remove_all(cache); }
};

TEST_F(EvaluatorTest, AStyleIsNotJudgedInAContentWhereTheJudgeHasNeverSeenIt) {
  const auto judges =
      Judges::TrainOrLoad(clips, 2, 2, {.iterations = 20, .batch = 8}, cache, "two styles");
  ASSERT_TRUE(judges.ok()) << judges.status().message();
  const Evaluator evaluator(manifest, judges.value(), clips, clips, clips);

  const Poses stream = clip::ResamplePoses(train::Walker(90).poses, kJudgeRate_hz, kStreamRate_hz);
  std::vector<Transferred> transferred;
  for (const int content : {kWalk, kWave}) {
    transferred.push_back({content, kOdd, content, stream, stream});
  }
  const Figures both = evaluator.Measure("both", transferred);
  const Figures walk = evaluator.Measure("walk", std::span(transferred).first(1));
  EXPECT_THAT(both.unknown, testing::ElementsAre(kOdd * 2 + kWave));
  EXPECT_THAT(walk.unknown, testing::IsEmpty());
  EXPECT_GT(walk.sra.windows, 0);
  EXPECT_EQ(both.sra.windows, walk.sra.windows);
  EXPECT_EQ(both.sra_with_unknown.windows, 2 * walk.sra.windows);
  EXPECT_EQ(both.sra.value, walk.sra.value);
  EXPECT_EQ(both.cra.windows, 2 * walk.cra.windows) << "contents are judged all the same";
  EXPECT_EQ(evaluator.ToJson(both)["unknown_to_style_judge"],
            nlohmann::json({evaluator.CellName(kOdd * 2 + kWave)}));

  const std::vector<double>& taken_for = both.styles[kOdd].taken_for;
  EXPECT_NEAR(std::accumulate(taken_for.begin(), taken_for.end(), 0.0), 1, 1e-9);
  EXPECT_NEAR(taken_for[kOdd], both.styles[kOdd].sra.value, 1e-9);
}

}  // namespace
}  // namespace styled::judge
