#include "model/train/judge/report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <numeric>

#include "model/clip/clip.h"
#include "tests/unit/judge/plain_frechet.h"
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

// One act in two styles; long clips, since FMD takes at least 64 windows.
struct FmdTest : EvaluatorTest {
  static train::TrainingClip Odd(int style, int frames, float phase) {
    train::TrainingClip clip = train::Walker(frames, phase);
    clip.style = style;
    for (std::size_t t = 0; t < clip.poses.size(); ++t) {  // no two windows are alike
      const auto bend = static_cast<float>(style * 0.4 + 0.3 * std::sin(0.013 * t * t / 50));
      body::Quat& spine = clip.poses[t].rotations[body::kSpine];
      spine = spine * body::Exp(body::Vec3(bend, 0.2F * bend, 0));
    }
    return clip;
  }
};

// Features of windows at the places that are compared: as many on either side, evenly spread.
Eigen::MatrixXd Spread(const Eigen::MatrixXd& rows, Eigen::Index count) {
  Eigen::MatrixXd out(count, rows.cols());
  for (Eigen::Index i = 0; i < count; ++i) out.row(i) = rows.row(rows.rows() * i / count);
  return out;
}

TEST_F(FmdTest, IsThePlainDistanceOfTheAutoEncodersFeaturesOnThirtyTwoAxes) {
  manifest.contents = {"walk"};
  const std::vector<train::TrainingClip> train{Odd(0, 200, 0), Odd(1, 1700, 1)};
  const std::vector<train::TrainingClip> judge{Odd(0, 1000, 2), Odd(1, 1000, 3)};
  const std::vector<train::TrainingClip> validation{Odd(0, 200, 4), Odd(1, 700, 5)};
  const auto made =
      Judges::TrainOrLoad(judge, 2, 1, {.iterations = 20, .batch = 8}, cache, "one act");
  ASSERT_TRUE(made.ok()) << made.status().message();
  const Judges& judges = made.value();
  const Evaluator evaluator(manifest, judges, train, judge, validation);
  const Poses input = clip::ResamplePoses(Odd(0, 620, 6).poses, kJudgeRate_hz, kStreamRate_hz);
  const Poses output = clip::ResamplePoses(Odd(1, 620, 7).poses, kJudgeRate_hz, kStreamRate_hz);
  const Transferred transferred{.style = 1, .input = input, .output = output};
  const StyleFigures figures = evaluator.Measure("odd", std::span(&transferred, 1)).styles[1];

  ASSERT_EQ(figures.distances.size(), 1U) << "one judge";
  const Distances& distances = figures.distances[0];
  const auto look = [&](std::span<const body::Pose> poses, int style, int stride) {
    return judges.Judge(MakeSequence(poses, style, 0, false, judges.parameters()), stride).at(0);
  };
  const auto thin = [](const Poses& poses) {
    Poses out;
    for (std::size_t i = 0; i < poses.size(); i += 4) out.push_back(poses[i]);
    return out;
  };
  const Verdicts out = look(thin(output), 1, 8), in = look(thin(input), 1, 8);
  const Verdicts real = look(validation[1].poses, 1, 8), other = look(train[1].poses, 1, 24);
  const Verdicts judged_0 = look(judge[0].poses, 0, 24), judged_1 = look(judge[1].poses, 1, 24);
  Eigen::MatrixXd samples(judged_0.embedding.rows() + judged_1.embedding.rows(), 512);
  samples << judged_0.embedding, judged_1.embedding;
  const Eigen::MatrixXd axes = PlainAxes(samples, 32);
  const Eigen::Index count = std::min(
      {out.embedding.rows(), in.embedding.rows(), real.embedding.rows(), other.embedding.rows()});
  EXPECT_EQ(figures.fmd_windows, count);
  ASSERT_GE(count, 64);
  const auto fmd = [&](const Verdicts& of) {
    return PlainFrechet(Spread(of.embedding, count) * axes, Spread(real.embedding, count) * axes);
  };
  EXPECT_NEAR(distances.fmd, fmd(out), 1e-4 * fmd(out));
  EXPECT_NEAR(distances.fmd_real, fmd(other), 1e-4 * fmd(other));
  EXPECT_NEAR(distances.fmd_neutral, fmd(in), 1e-4 * fmd(in));
  const auto content_fmd = [&](const Verdicts& of) {
    return PlainFrechet(Spread(of.content_features, count), Spread(real.content_features, count));
  };
  EXPECT_NEAR(distances.content_fmd, content_fmd(out), 1e-4 * content_fmd(out));
  EXPECT_NEAR(distances.content_fmd_real, content_fmd(other), 1e-4 * content_fmd(other));
  EXPECT_NEAR(distances.content_fmd_neutral, content_fmd(in), 1e-4 * content_fmd(in));
}

}  // namespace
}  // namespace styled::judge
