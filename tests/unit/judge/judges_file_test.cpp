#include "model/train/judge/judges_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "model/net/safetensors.h"
#include "model/net/sha256.h"
#include "tests/support/temporary_folder.h"
#include "tests/unit/train/walker.h"

namespace styled::judge {
namespace {

using testing::HasSubstr;

struct JudgesFileTest : testing::Test {
  const support::TemporaryFolder folder;
  const std::filesystem::path file = folder / "judges.safetensors";
  clip::Manifest manifest;
  std::vector<train::TrainingClip> clips;
  const JudgeSettings settings{.iterations = 3, .batch = 8, .seed = 4, .count = 2};

  void SetUp() override {
    manifest.name = "set";
    manifest.styles = {{"neutral", {}, {}}, {"odd", {}, {}}};
    manifest.contents = {"walk"};
    for (const int style : {0, 1}) {
      clips.push_back(train::Walker(80, static_cast<float>(style)));
      clips.back().style = style;
    }
  }
  Result<Panel> Train(const char* cache, const JudgeSettings& wanted) const {
    return TrainPanel(clips, manifest, wanted, folder / cache, "key");
  }
  std::string Refusal() const {
    const auto read = ReadPanel(file, clips, manifest);
    return read.ok() ? "" : read.status().message();
  }
};

TEST_F(JudgesFileTest, JudgesAsTheyDidWhenTheyWereTrained) {
  const auto trained = Train("a", settings);
  ASSERT_TRUE(trained.ok()) << trained.status().message();
  ASSERT_TRUE(WritePanel(trained.value(), file).ok());
  EXPECT_EQ(net::Sha256OfFile(file).value(), trained.value().hash);
  const auto read = ReadPanel(file, clips, manifest);
  ASSERT_TRUE(read.ok()) << read.status().message();
  EXPECT_EQ(read.value().hash, trained.value().hash);
  EXPECT_EQ(read.value().judges.settings().count, 2);
  EXPECT_EQ(read.value().judges.settings().seed, 4U);

  const Sequence sequence =
      MakeSequence(clips[1].poses, 1, 0, false, trained.value().judges.parameters());
  const std::vector<Verdicts> before = trained.value().judges.Judge(sequence, 4);
  const std::vector<Verdicts> after = read.value().judges.Judge(sequence, 4);
  ASSERT_EQ(after.size(), 2U);
  for (std::size_t judge = 0; judge < 2; ++judge) {
    EXPECT_EQ(after[judge].style, before[judge].style);
    EXPECT_EQ(after[judge].content, before[judge].content);
    EXPECT_EQ(after[judge].embedding, before[judge].embedding);
    EXPECT_EQ(after[judge].content_features, before[judge].content_features);
  }
  EXPECT_NE(after[0].embedding, after[1].embedding) << "seeds differ";
  EXPECT_EQ(trained.value().parts.Judge(clips[1].poses, 4),
            read.value().parts.Judge(clips[1].poses, 4));
}

TEST_F(JudgesFileTest, IsTheSameByteForByteWhereItIsTrainedAgain) {
  const auto first = Train("a", settings);
  const auto again = Train("b", settings);
  const auto cached = Train("a", settings);
  JudgeSettings later = settings;
  later.seed = 5;
  const auto other = Train("a", later);
  ASSERT_TRUE(first.ok() && again.ok() && cached.ok() && other.ok());
  EXPECT_EQ(again.value().hash, first.value().hash);
  EXPECT_EQ(cached.value().hash, first.value().hash);
  EXPECT_NE(other.value().hash, first.value().hash);
}

TEST_F(JudgesFileTest, RefusesWhatItsJudgesAreNotMadeFor) {
  const auto trained = Train("a", settings);
  ASSERT_TRUE(trained.ok() && WritePanel(trained.value(), file).ok());
  EXPECT_EQ(Refusal(), "");
  manifest.styles[1].name = "even";
  EXPECT_THAT(Refusal(), HasSubstr("judges.safetensors: key 'styles': expected"));
  manifest.styles[1].name = "odd";
  manifest.contents = {"walk", "wave"};
  EXPECT_THAT(Refusal(), HasSubstr("key 'contents': expected"));
  manifest.contents = {"walk"};
  clips.pop_back();
  EXPECT_THAT(Refusal(), HasSubstr("key 'clips': expected 1, found 2"));
}

TEST_F(JudgesFileTest, RefusesAFileOfAnotherHumanoidOrFeaturesOrNone) {
  auto trained = Train("a", settings);
  ASSERT_TRUE(trained.ok());
  for (const auto& [key, other] : {std::pair{"humanoid_hash", nlohmann::json("00")},
                                   {"features", nlohmann::json(7)},
                                   {"recipes", nlohmann::json::array({"0", "0"})},
                                   {"count", nlohmann::json(0)},
                                   {"seed", nlohmann::json("one")}}) {
    const nlohmann::json kept = trained.value().header[key];
    trained.value().header[key] = other;
    ASSERT_TRUE(WritePanel(trained.value(), file).ok());
    EXPECT_THAT(Refusal(), HasSubstr(std::string("key '") + key + "': expected"));
    trained.value().header[key] = kept;
  }
  trained.value().header["count"] = 1;
  ASSERT_TRUE(WritePanel(trained.value(), file).ok());
  EXPECT_THAT(Refusal(), HasSubstr("unknown")) << "the second judge's tensors";
  const std::vector<net::NamedTensor> none;
  ASSERT_TRUE(net::WriteSafetensors(file, none, {{"styled", "{}"}}).ok());
  EXPECT_THAT(Refusal(), HasSubstr("no judges; `styleeval --write-judges`"));
}

}  // namespace
}  // namespace styled::judge
