#include "model/train/judge/ledger.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "tests/support/temporary_folder.h"

namespace styled::judge {
namespace {

using testing::HasSubstr;

struct LedgerTest : testing::Test {
  const support::TemporaryFolder folder;
  const std::filesystem::path file = folder / "TESTED.tsv";
  const TestUse use{.manifest = "set",
                    .weights = "aa11",
                    .files = "new.safetensors",
                    .judges = "bb22",
                    .commit = "cc33",
                    .day = "2026-11-28"};

  std::string Text() const {
    std::stringstream text;
    text << std::ifstream(file).rdbuf();
    return text.str();
  }
};

TEST_F(LedgerTest, HasALineForEachUse) {
  ASSERT_TRUE(BeginTest(use, false, file).ok());
  const std::string begin = "set\taa11\tnew.safetensors\tbb22\tcc33\t2026-11-28\t";
  EXPECT_EQ(Text(), std::string(kLedgerHead) + "\n" + begin + "begun, not ended\n")
      << "a run that was stopped has shown figures, too";
  ASSERT_TRUE(EndTest(use, "style 0.9", file).ok());
  EXPECT_EQ(Text(), std::string(kLedgerHead) + "\n" + begin + "style 0.9\n");
}

TEST_F(LedgerTest, RefusesTheSameWeightsASecondTime) {
  ASSERT_TRUE(BeginTest(use, false, file).ok());
  ASSERT_TRUE(EndTest(use, "style 0.9", file).ok());
  const std::string before = Text();
  const Status refused = BeginTest(use, false, file);
  EXPECT_THAT(refused.message(), HasSubstr("TESTED.tsv: line 2: new.safetensors was judged"));
  EXPECT_THAT(refused.message(), HasSubstr("--again"));
  EXPECT_EQ(Text(), before);

  TestUse other = use;
  other.manifest = "another set";
  EXPECT_TRUE(BeginTest(other, false, file).ok());
  other = use;
  other.weights = "aa12";
  EXPECT_TRUE(BeginTest(other, false, file).ok());
  EXPECT_TRUE(BeginTest(use, true, file).ok()) << "knowingly";
  EXPECT_TRUE(EndTest(use, "style 0.8", file).ok());
  EXPECT_THAT(Text(), HasSubstr("\tstyle 0.9\n"));
  EXPECT_THAT(Text(), HasSubstr("\tstyle 0.8\n"));
}

TEST_F(LedgerTest, AFileThatIsNoneIsLeftAlone) {
  std::ofstream(file) << "notes\n";
  EXPECT_THAT(BeginTest(use, false, file).message(), HasSubstr("TESTED.tsv: line 1: expected"));
  EXPECT_EQ(Text(), "notes\n");
  EXPECT_THAT(EndTest(use, "x", folder / "lost.tsv").message(), HasSubstr("is gone"));
}

TEST(LedgerFigures, AreTheMainSetsBesideOffsetAndRealClips) {
  const auto set = [](const char* key, const nlohmann::json& value, const nlohmann::json& spread) {
    return nlohmann::json{{"key", key},
                          {"judges", {{{"key", "style"}, {"value", value}, {"spread", spread}}}}};
  };
  const nlohmann::json report = {
      {"judges",
       {set("real", 1.0, 0.001), set("offset", nullptr, nullptr), set("styled", 0.9, 0.0125)}}};
  EXPECT_EQ(LedgerFigures(report), "style 0.900 ±0.013 (-, 1.000 ±0.001)");
}

}  // namespace
}  // namespace styled::judge
