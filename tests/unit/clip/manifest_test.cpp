#include "model/clip/manifest.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <set>
#include <string>

#include "tests/support/temporary_folder.h"

namespace styled::clip {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

const char kHead[] =
    "name = \"test\"\n"
    "licence = \"none\"\n"
    "neutral = \"neutral\"\n"
    "styles = [ { name = \"neutral\", labels = [\"normal\"] },\n"
    "  { name = \"old\", labels = [\"old\", \"elderly\"], aliases = [\"aged\"] },\n"
    "  { name = \"very-old\", labels = [\"old_old\"] } ]\n"
    "contents = [ { name = \"walk\", labels = [\"walk\"] },\n"
    "  { name = \"turn\", labels = [\"walk-left\", \"walk-right\"] } ]\n";

// A folder of empty files and a manifest over it.
class ManifestTest : public testing::Test {
 protected:
  void Touch(const std::string& name) {
    fs::create_directories((folder_ / name).parent_path());
    std::ofstream(folder_ / name) << "x";
  }
  Result<Manifest> Load(const std::string& text) {
    const fs::path file = folder_ / "manifest.toml";
    std::ofstream(file) << text;
    return LoadManifest(file, folder_);
  }
  std::string Refusal(const std::string& text) {
    const Result<Manifest> manifest = Load(text);
    return manifest.ok() ? "accepted" : manifest.status().message();
  }
  static std::string With(const std::string& from, const std::string& to) {
    std::string text = kHead;
    const auto at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return text.replace(at, from.size(), to) + Rule("");
  }
  static std::string Rule(const std::string& more) {
    return "[[clips]]\npattern = \"d/{content}_{style}_{take}.bvh\"\n" + more;
  }

  support::TemporaryFolder temporary_;
  const fs::path& folder_ = temporary_.path();
};

TEST_F(ManifestTest, NamesFileLineKeyAndWhatIsWrong) {
  Touch("d/walk_normal_1.bvh");
  ASSERT_EQ(Refusal(kHead + Rule("")), "accepted");
  const std::pair<std::string, std::string> cases[] = {
      {"name = ", "manifest.toml:1: found"},
      {With("name = \"test\"\n", ""), "name: found nothing, expected a string"},
      {With("licence = \"none\"", "licence = 3"), "manifest.toml:2: licence: found something else"},
      {With("neutral = \"neutral\"", "neutral = \"old\""),
       "expected the neutral style \"old\" first"},
      {With("licence = \"none\"", "licence = \"none\"\nauthor = \"me\""),
       "manifest.toml:3: author: found an unknown key"},
      {With("labels = [\"normal\"]", "labels = []"), "labels: found an empty array"},
      {With("labels = [\"normal\"]", "label = [\"normal\"]"), "label: found an unknown key"},
      {With("labels = [\"normal\"]", "labels = [1]"), "found something else in the array"},
      {With("\"elderly\"", "\"normal\""), "label \"normal\" twice"},
      {With("very-old", "old"), "\"old\" twice, expected each style once"},
      {With("name = \"turn\"", "name = \"walk\""), "\"walk\" twice, expected each content once"},
      {With("styles = [", "contents = 1 # ["), "manifest.toml:"},
      {"name = \"a\"\nlicence = \"b\"\nneutral = \"c\"\n", "styles: found nothing"},
      {kHead, "clips: found nothing, expected an array of tables"},
      {kHead + std::string("[[clips]]\nrig = \"cmu\"\n"), "pattern: found nothing"},
      {kHead + std::string("[[clips]]\npattern = \"d/{content}_{take}.bvh\"\n"),
       "style: found nothing, expected it either fixed or as {style}"},
      {kHead + Rule("content = \"walk\"\n"), "content: found it fixed and in the pattern"},
      {kHead + std::string("[[clips]]\npattern = \"d/{content}*\"\nstyle = \"drunk\"\n"),
       "style: found \"drunk\", expected the name of one of the styles"},
      {kHead + std::string("[[clips]]\npattern = \"d/*{style}*\"\ncontent = \"swim\"\n"),
       "content: found \"swim\""},
      {kHead + Rule("split = \"exam\"\n"),
       "split: found \"exam\", expected train, judge, validation or test"},
      {kHead + Rule("judge_share = 1.0\n"), "judge_share: found 1.0"},
      {kHead + Rule("judge_share = -0.1\n"), "judge_share: found -0.1"},
      {kHead + Rule("judge_share = \"all\"\n"), "judge_share: found something else"},
      {kHead + Rule("split = \"judge\"\njudge_share = 0.2\n"), "expected it with split \"train\""},
      {kHead + Rule("validation_share = 1\n"), "validation_share: found 1.0"},
      {kHead + Rule("split = \"judge\"\nvalidation_share = 0.2\n"),
       "expected it with split \"train\""},
      {kHead + Rule("judge_share = 0.5\nvalidation_share = 0.5\n"), "with a sum of 1 or more"},
      {kHead + Rule("") + Rule(""), "under two patterns, expected each part of a clip once"},
      {kHead + Rule("time = [0.0, 0.6]\n") + Rule("time = [0.5, 1.0]\n"), "under two patterns"},
      {kHead + Rule("time = [0.5, 0.5]\n"), "time: found something else, expected [from, to]"},
      {kHead + Rule("time = 0.5\n"), "time: found something else"},
      {kHead + Rule("repeat_s = -1\n"), "repeat_s: found -1"},
      {kHead + Rule("skip_s = -0.1\n"), "skip_s: found -0.1"},
      {kHead + Rule("floor = \"low\"\n"), "floor: found \"low\", expected \"feet\""},
      {kHead + Rule("still = 0\n"), "still: found something else, expected true or false"},
      {kHead + Rule("except = \"d/*\"\n"), "except: found something else, expected an array"},
      {kHead + Rule("except = [\"d/*\"]\n"), "pattern: found no file"},
      {kHead + std::string("[still]\ncontent = \"stand\"\nspeed_mps = 0.1\n") + Rule(""),
       "content: found \"stand\", expected the name of one of the contents"},
      {kHead + std::string("[still]\ncontent = \"walk\"\n") + Rule(""),
       "speed_mps: found nothing, expected a number above 0"},
      {kHead + Rule("except = [\"" + std::string(1001, '*') + "\"]\n"),
       "expected at most 1000 characters"},
      {kHead + std::string("[[clips]]\npattern = \"e/{content}_{style}.bvh\"\n"),
       "pattern: found no file for \"e/{content}_{style}.bvh\" in "},
  };
  for (const auto& [text, message] : cases) {
    EXPECT_THAT(Refusal(text), HasSubstr(message));
    EXPECT_THAT(Refusal(text), HasSubstr("manifest.toml"));
  }
  std::string deep;  // overflows the stack of a reader that descends
  for (int i = 0; i < 200'000; ++i) deep += "a.";
  EXPECT_THAT(Refusal(kHead + deep + "a = 1\n"), HasSubstr("nested too deep"));
  EXPECT_THAT(Refusal("#" + std::string(1 << 20, '#')),
              HasSubstr("larger than the limit of 1 MiB"));
  EXPECT_THAT(LoadManifest("/nonexistent.toml", "/").status().message(),
              HasSubstr("/nonexistent.toml"));
}

TEST_F(ManifestTest, ReadsStylesContentsAndClipsSortedByPath) {
  for (const char* name : {"d/walk_elderly_012.bvh", "d/walk-left_old_3.bvh", "d/walk_normal_1.bvh",
                           "d/swim_normal_1.bvh", "d/walk_drunk_1.bvh", "d/walk_normal_x.bvh",
                           "d/walk_normal_1.bvh.txt", "e/walk_normal_1.bvh"}) {
    Touch(name);
  }
  const Result<Manifest> result = Load(kHead + Rule("rig = \"bandai-namco\"\n"));
  ASSERT_TRUE(result.ok()) << result.status().message();
  const Manifest& manifest = result.value();
  EXPECT_EQ(manifest.name, "test");
  EXPECT_EQ(manifest.licence, "none");
  ASSERT_EQ(manifest.styles.size(), 3U);
  EXPECT_THAT(manifest.styles[1].aliases, testing::ElementsAre("aged"));
  EXPECT_THAT(manifest.contents, testing::ElementsAre("walk", "turn"));
  ASSERT_EQ(manifest.entries.size(), 3U);
  const ManifestEntry& turn = manifest.entries[0];
  EXPECT_EQ(turn.file, folder_ / "d/walk-left_old_3.bvh");
  EXPECT_EQ(turn.content, "turn");
  EXPECT_EQ(turn.style, "old");
  EXPECT_EQ(turn.take, 3);
  EXPECT_EQ(turn.rig, "bandai-namco");
  EXPECT_EQ(turn.split, "train");
  EXPECT_EQ(manifest.entries[1].style, "old") << "elderly";
  EXPECT_EQ(manifest.entries[1].take, 12);
  EXPECT_EQ(manifest.entries[2].style, "neutral");
}

TEST_F(ManifestTest, TriesTheLongestLabelFirst) {
  Touch("d/walk_old_old_1.bvh");
  const Result<Manifest> manifest = Load(kHead + Rule(""));
  ASSERT_TRUE(manifest.ok()) << manifest.status().message();
  EXPECT_EQ(manifest.value().entries[0].style, "very-old");
}

TEST_F(ManifestTest, FixedStyleAndContentAndStars) {
  Touch("xia/old_01_000.bvh");
  Touch("xia/deeper/old_01_000.bvh");
  const Result<Manifest> manifest =
      Load(kHead + std::string("[[clips]]\npattern = \"xia/{style}_01_*.bvh\"\ncontent = \"walk\"\n"
                               "split = \"validation\"\n"));
  ASSERT_TRUE(manifest.ok()) << manifest.status().message();
  ASSERT_EQ(manifest.value().entries.size(), 1U) << "a star stays in its folder";
  EXPECT_EQ(manifest.value().entries[0].content, "walk");
  EXPECT_EQ(manifest.value().entries[0].rig, "auto");
  EXPECT_EQ(manifest.value().entries[0].split, "validation");
  EXPECT_EQ(manifest.value().entries[0].take, 0);
}

// Found by libFuzzer: each star tried every remainder for each star before it.
TEST_F(ManifestTest, ManyStarsTakeNoLongerThanFew) {
  Touch("xia/old_01_000000000000000000000000000000000.bvh");
  Touch("xia/old_02_000.bvh");
  const Result<Manifest> manifest =
      Load(kHead + std::string("[[clips]]\npattern = \"xia/{style}_*.bvh\"\ncontent = \"walk\"\n"
                               "except = [\"xia/old*_01***************************0*x\", "
                               "\"xia/*****************************02_*************.bvh\"]\n"));
  ASSERT_TRUE(manifest.ok()) << manifest.status().message();
  ASSERT_EQ(manifest.value().entries.size(), 1U);
  EXPECT_THAT(manifest.value().entries[0].file.string(), HasSubstr("old_01"));
}

TEST_F(ManifestTest, OneClipServesSeveralSplitsInTurn) {
  Touch("d/walk_old_1.bvh");
  Touch("d/turn_old_1.bvh");
  Touch("d/walk-left_old_1.bvh");
  const Result<Manifest> result =
      Load(kHead + std::string("[still]\ncontent = \"turn\"\nspeed_mps = 0.2\n") +
           Rule("split = \"validation\"\ntime = [0.75, 1.0]\nexcept = [\"*/walk-left*\"]\n") +
           Rule("time = [0.0, 0.75]\nrepeat_s = 4\nexcept = [\"*/walk-left*\"]\n"));
  ASSERT_TRUE(result.ok()) << result.status().message();
  const Manifest& manifest = result.value();
  ASSERT_EQ(manifest.entries.size(), 2U);
  EXPECT_EQ(manifest.entries[0].split, "train");
  EXPECT_EQ(manifest.entries[0].from, 0.0);
  EXPECT_EQ(manifest.entries[0].to, 0.75);
  EXPECT_EQ(manifest.entries[0].repeat_s, 4.0);
  EXPECT_EQ(manifest.entries[1].split, "validation");
  EXPECT_EQ(manifest.entries[1].repeat_s, 0.0);
  EXPECT_EQ(manifest.still_content, "turn");
  EXPECT_EQ(manifest.still_speed_mps, 0.2);
}

TEST_F(ManifestTest, FramesBeforeTheMotionAndTheFloorAreRead) {
  Touch("d/walk_old_1.bvh");
  Touch("d/turn_old_1.bvh");
  Touch("d/walk-left_old_1.bvh");
  const Result<Manifest> result = Load(kHead + Rule("except = [\"*/walk-left*\"]\n") +
                                       Rule("rig = \"standing\"\nskip_s = 0.5\nfloor = "
                                            "\"feet\"\nstill = false\nperson = \"b{take}\"\n"
                                            "except = [\"*/walk_*\"]\n"));
  ASSERT_TRUE(result.ok()) << result.status().message();
  ASSERT_EQ(result.value().entries.size(), 2U);
  const ManifestEntry& other = result.value().entries[0];
  EXPECT_EQ(other.rig, "standing");
  EXPECT_EQ(other.skip_s, 0.5);
  EXPECT_TRUE(other.floor_at_feet);
  EXPECT_FALSE(other.still);
  EXPECT_EQ(other.person, "b1");
  const ManifestEntry& usual = result.value().entries[1];
  EXPECT_EQ(usual.skip_s, 0.0);
  EXPECT_FALSE(usual.floor_at_feet);
  EXPECT_TRUE(usual.still);
  EXPECT_TRUE(usual.person.empty());
}

TEST_F(ManifestTest, SetsTheLastTakesOfEveryCellAsideForTheJudge) {
  for (int take = 1; take <= 10; ++take) {
    Touch("d/walk_normal_" + std::to_string(take) + ".bvh");
    if (take <= 4) Touch("d/walk_old_" + std::to_string(take) + ".bvh");
  }
  Touch("d/walk-left_old_1.bvh");
  const Result<Manifest> manifest = Load(kHead + Rule("judge_share = 0.25\n"));
  ASSERT_TRUE(manifest.ok()) << manifest.status().message();
  std::set<std::string> judged;
  for (const ManifestEntry& entry : manifest.value().entries) {
    if (entry.split == "judge") judged.insert(entry.file.filename().string());
  }
  EXPECT_THAT(judged, testing::ElementsAre("walk_normal_10.bvh", "walk_normal_8.bvh",
                                           "walk_normal_9.bvh", "walk_old_4.bvh"))
      << "by number, not by spelling; a cell of one clip keeps it";
}

TEST_F(ManifestTest, SetsTheVeryLastTakesAsideForTheValidation) {
  for (int take = 1; take <= 6; ++take) Touch("d/walk_normal_" + std::to_string(take) + ".bvh");
  Touch("d/walk_old_1.bvh");
  Touch("d/walk_old_2.bvh");
  const Result<Manifest> manifest =
      Load(kHead + Rule("judge_share = 0.33\nvalidation_share = 0.33\n"));
  ASSERT_TRUE(manifest.ok()) << manifest.status().message();
  std::vector<std::string> splits;
  for (const ManifestEntry& entry : manifest.value().entries) splits.push_back(entry.split);
  EXPECT_THAT(splits, testing::ElementsAre("train", "train", "judge", "judge", "validation",
                                           "validation", "train", "validation"));
}

TEST_F(ManifestTest, SetsTheLastTakesOfAValidationAsideForTheTest) {
  for (int take = 1; take <= 3; ++take) Touch("d/walk_normal_" + std::to_string(take) + ".bvh");
  Touch("d/walk_old_1.bvh");
  const Result<Manifest> manifest =
      Load(kHead + Rule("split = \"validation\"\ntest_share = 0.5\n"));
  ASSERT_TRUE(manifest.ok()) << manifest.status().message();
  std::vector<std::string> splits;
  for (const ManifestEntry& entry : manifest.value().entries) splits.push_back(entry.split);
  EXPECT_THAT(splits, testing::ElementsAre("validation", "test", "test", "validation"));
  EXPECT_THAT(Refusal(kHead + Rule("test_share = 0.5\n")),
              HasSubstr("test_share: found it with split \"train\", expected it with split "
                        "\"validation\" only"));
}

TEST_F(ManifestTest, EveryPartSaysWhatIsWrongWithIt) {
  const std::string head =
      "name = \"test\"\nneutral = \"neutral\"\nstyles = []\ncontents = [{name = 1}]\n";
  EXPECT_THAT(Refusal(head + Rule("")),
              testing::AllOf(HasSubstr("licence: found nothing"), HasSubstr("\n"),
                             HasSubstr("styles: found"), HasSubstr("name: found something else"),
                             testing::Not(HasSubstr("pattern"))))
      << "[[clips]] refer to styles and contents";
  EXPECT_THAT(
      Refusal(kHead + Rule("time = 1\n") + Rule("split = \"x\"\n")),
      testing::AllOf(HasSubstr("manifest.toml:11: time:"), HasSubstr("split: found \"x\"")));
}

}  // namespace
}  // namespace styled::clip
