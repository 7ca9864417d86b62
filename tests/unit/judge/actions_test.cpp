#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>

#include "model/train/judge/action_figures.h"
#include "tests/unit/train/walker.h"

namespace styled::judge {
namespace {

// Two contents that differ in the arms; the style does not show.
train::TrainingClip ActionClip(int style, int content, float phase, int frames = 300) {
  train::TrainingClip clip = train::Walker(frames, phase);
  clip.style = style;
  clip.content = content;
  if (content == 0) return clip;
  for (std::size_t t = 0; t < clip.poses.size(); ++t) {
    const float wave = std::sin(0.7F * static_cast<float>(t) + phase);
    clip.poses[t].rotations[body::kLeftUpperArm] = body::Exp(body::Vec3(0.4F * wave, 0, 0.9F));
    clip.poses[t].rotations[body::kRightUpperArm] = body::Exp(body::Vec3(0.4F * wave, 0, -0.9F));
  }
  return clip;
}

Poses AsStream(const Poses& poses) {
  Poses stream;
  for (const body::Pose& pose : poses) stream.insert(stream.end(), 4, pose);
  return stream;
}

class ActionsTest : public testing::Test {
 protected:
  ActionsTest() {
    data_.manifest.styles = {{"neutral", {}, {}}, {"odd", {}, {}}};
    data_.manifest.contents = {"walk", "wave"};
    for (const int content : {0, 1}) {
      for (const int style : {0, 1}) {
        for (const float phase : {0.0F, 1.0F, 2.0F}) {
          data_.judge.push_back(ActionClip(style, content, phase));
          data_.train.push_back(ActionClip(style, content, phase + 0.3F));
          data_.validation.push_back(ActionClip(style, content, phase + 0.6F));
        }
      }
    }
  }
  static void TearDownTestSuite() { std::filesystem::remove_all(Cache()); }
  static std::filesystem::path Cache() {
    return std::filesystem::temp_directory_path() / ("styled_acts_" + std::to_string(::getpid()));
  }
  Result<ActionClassifiers> Train(unsigned seed = 1, int count = 2) const {
    return TrainActionClassifiers(data_, {.iterations = 120, .batch = 8, .seed = seed}, count,
                                  Cache());
  }
  // The clips of style 1 as if a network had made them, where `right` is false, in the other
  // content.
  std::vector<Transferred> Styled(bool right, int frames = 300) const {
    std::vector<Transferred> clips;
    for (const int content : {0, 1}) {
      const auto made = ActionClip(1, right ? content : 1 - content, 0.2F, frames);
      clips.push_back({.clip = content,
                       .style = 1,
                       .content = content,
                       .input = {},
                       .output = AsStream(made.poses)});
    }
    return clips;
  }

  Data data_;
};

TEST_F(ActionsTest, ContentsAreRecognizedAndTakenForTheirOpposites) {
  const auto classifiers = Train();
  ASSERT_TRUE(classifiers.ok()) << classifiers.status().message();
  const ActionComparison comparison(data_, classifiers.value());
  EXPECT_GT(comparison.OfReal().accuracy.value, 0.85);
  const ActionFigures right = comparison.OfStyled("right", "right", Styled(true));
  const ActionFigures wrong = comparison.OfStyled("wrong", "wrong", Styled(false));
  EXPECT_GT(right.accuracy.value, 0.85);
  EXPECT_LT(wrong.accuracy.value, 0.15);
  EXPECT_EQ(right.accuracy.windows, 2 * std::floor((299 - 32) / 8.0 + 1));
}

// By plain loops: as many windows of each content on both sides as the smaller has.
TEST_F(ActionsTest, TheDistanceIsBetweenEqualNumbersOfAllWindows) {
  const auto trained = Train();
  ASSERT_TRUE(trained.ok()) << trained.status().message();
  const ActionClassifiers& classifiers = trained.value();
  const ActionComparison comparison(data_, classifiers);
  const ActionFigures figures = comparison.OfStyled("styled", "styled", Styled(true));
  ASSERT_EQ(figures.fmd.size(), 2U);

  for (std::size_t judge = 0; judge < 2; ++judge) {
    std::vector<Eigen::RowVectorXd> found, real;
    for (const int content : {0, 1}) {
      const auto rows = [&](const Poses& poses, std::vector<Eigen::RowVectorXd>& to) {
        const auto verdicts = classifiers.Judge(
            MakeSequence(poses, 1, content, false, classifiers.parameters()), kStride)[judge];
        for (Eigen::Index i = 0; i < verdicts.features.rows(); ++i) {
          to.emplace_back(verdicts.features.row(i));
        }
      };
      std::vector<Eigen::RowVectorXd> of_real;
      rows(ActionClip(1, content, 0.2F).poses, found);
      for (const float phase : {0.6F, 1.6F, 2.6F}) {
        rows(ActionClip(1, content, phase).poses, of_real);
      }
      const std::size_t count = found.size() / static_cast<std::size_t>(content + 1);
      ASSERT_EQ(of_real.size(), 3 * count);
      for (std::size_t i = 0; i < count; ++i) real.push_back(of_real[3 * i]);
    }
    Eigen::MatrixXd a(found.size(), found[0].cols()), b(real.size(), real[0].cols());
    for (std::size_t i = 0; i < found.size(); ++i) a.row(i) = found[i];
    for (std::size_t i = 0; i < real.size(); ++i) b.row(i) = real[i];
    EXPECT_NEAR(figures.fmd[judge], FrechetDistance(a, b), 1e-9 + 1e-6 * figures.fmd[judge]);
  }
  EXPECT_LT(figures.Fmd(), comparison.OfStyled("", "", Styled(false)).Fmd() + 1e-9);
}

TEST_F(ActionsTest, ClassifiersAreNamedByTheirHashAndReadFromTheCache) {
  const auto first = Train(1, 1);
  const auto again = Train(1, 1);
  const auto other = Train(2, 1);
  ASSERT_TRUE(first.ok() && again.ok() && other.ok());
  EXPECT_EQ(first.value().hash(), again.value().hash());
  EXPECT_NE(first.value().hash(), other.value().hash());
}

TEST_F(ActionsTest, TooFewWindowsHaveNoDistance) {
  const auto classifiers = Train();
  ASSERT_TRUE(classifiers.ok()) << classifiers.status().message();
  const ActionComparison comparison(data_, classifiers.value());
  const std::array sets{comparison.OfReal(), comparison.OfStyled("few", "few", Styled(true, 48))};
  EXPECT_TRUE(std::isnan(sets[1].Fmd()));
  const nlohmann::json json = ToJson(sets, classifiers.value())["sets"];
  EXPECT_TRUE(json["few"]["fmd"].is_null());
  EXPECT_TRUE(json["real"]["fmd"].is_number());
  testing::internal::CaptureStdout();
  Print(sets, classifiers.value());
  EXPECT_THAT(testing::internal::GetCapturedStdout(), testing::ContainsRegex("few .*\\]  -\n"));
}

}  // namespace
}  // namespace styled::judge
