#include "model/train/judge/comparison.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace styled::judge {
namespace {

using testing::HasSubstr;

struct ComparisonTest : testing::Test {
  clip::Manifest manifest;

  void SetUp() override {
    manifest.styles = {{"neutral", {}, {}}, {"odd", {}, {}}};
    manifest.contents = {"walk", "wave"};
  }

  // Every judge right in `value` of the walks; no wave was judged.
  static JudgedShare Walks(double value, double windows) {
    const Share walks{.value = value, .windows = windows};
    return {.all = walks, .by_style = {{}, walks}, .by_content = {walks, {}}};
  }
  static Compared Set(const char* key, double value, double windows) {
    Compared set{.key = key,
                 .title = key,
                 .style = Walks(value, windows),
                 .content = Walks(value, windows),
                 .parts = {}};
    set.parts.fill(Walks(value, windows));
    return set;
  }
};

TEST_F(ComparisonTest, AnUnjudgedValueIsADashAndNull) {
  const std::array sets{Set("real", 1.0, 40), Set("styled", 0.0, 30)};
  testing::internal::CaptureStdout();
  Print(manifest, sets);
  const std::string text = testing::internal::GetCapturedStdout();
  EXPECT_THAT(text, testing::ContainsRegex(
                        "movement +1\\.00 .0\\.00 0\\.00. +0\\.00 .0\\.00 0\\.00. +30\n"));
  EXPECT_THAT(text, testing::ContainsRegex("movement +0\\.00 +0\\.00 +-\n"));  // walk, wave

  const nlohmann::json judges = ToJson(manifest, sets)[1]["judges"];
  ASSERT_EQ(judges.size(), 2 + kPartViewCount);
  for (const nlohmann::json& judge : judges) {
    EXPECT_EQ(judge["value"], 0.0);
    EXPECT_EQ(judge["contents"]["walk"], 0.0);
    EXPECT_TRUE(judge["contents"]["wave"].is_null());
  }
}

TEST_F(ComparisonTest, TheSpreadOverJudgesStandsBesideTheIntervalOverClips) {
  Compared set = Set("real", 0.7, 40);
  set.style.all = {.value = 0.7, .low = 0.6, .high = 0.8, .windows = 40, .by_judge = {0.6, 0.8}};
  testing::internal::CaptureStdout();
  Print(manifest, std::array{set});
  EXPECT_THAT(testing::internal::GetCapturedStdout(), HasSubstr("0.70 ±0.14 [0.60 0.80]  40\n"));
  const nlohmann::json judge = ToJson(manifest, std::array{set})[0]["judges"][0];
  EXPECT_NEAR(judge["spread"].get<double>(), 0.1414, 1e-4);
  EXPECT_EQ(judge["low"], 0.6);
  EXPECT_TRUE(ToJson(manifest, std::array{set})[0]["judges"][1]["spread"].is_null());
}

TEST_F(ComparisonTest, AJudgeThatIsWeakOnRealClipsIsNamed) {
  Compared real = Set("real", 0.9, 40);
  EXPECT_TRUE(WeakJudges(manifest, real).empty());
  real.parts[0].by_content[1] = {.value = 0.5, .windows = 10};
  real.content.all.value = 0.7;
  const std::vector<std::string> weak = WeakJudges(manifest, real);
  ASSERT_EQ(weak.size(), 2U);
  EXPECT_THAT(weak[0], HasSubstr("content"));
  EXPECT_THAT(weak[1], HasSubstr("movement"));
  EXPECT_THAT(weak[1], HasSubstr("wave 0.50"));
}

}  // namespace
}  // namespace styled::judge
