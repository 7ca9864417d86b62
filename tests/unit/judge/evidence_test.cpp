#include "model/train/judge/evidence.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cctype>
#include <fstream>
#include <sstream>

#include "model/net/load.h"
#include "model/train/judge/speeds.h"
#include "tests/support/temporary_folder.h"
#include "tests/unit/net/erd/random_weights.h"

namespace styled::judge {
namespace {

const JudgedBy kBy{.manifest = "set", .judges = "0123456789abcdef0123"};

class WeightsOnDisk : public testing::Test {
 protected:
  WeightsOnDisk() {
    const erd::WeightsFile made = erd::RandomWeights(3, 1);
    bytes_ = made.Bytes();
    std::ofstream(file_, std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes_.data()),
               static_cast<std::streamsize>(bytes_.size()));
  }
  net::Styles Read() const {
    const auto network = net::Load(file_);
    EXPECT_TRUE(network.ok()) << network.status().message();
    return network.ok() ? network.value()->model().styles : net::Styles();
  }

  const support::TemporaryFolder folder_;
  const std::filesystem::path file_ = folder_ / "evidence.safetensors";
  std::vector<std::byte> bytes_;
};

TEST_F(WeightsOnDisk, GetEvidenceAndSpeedsAndKeepAllElse) {
  const net::Styles before = Read();
  const std::string name = before[1].name;
  const std::vector<Evidence> evidence{{name, 61.52, 0.98765}, {"nobody", 5, 0.5}};
  ASSERT_TRUE(WriteEvidence(evidence, kBy, file_).ok());
  const std::vector<StyleSpeeds> speeds{{name, 1.25, 0, 118.4, 0}};
  ASSERT_TRUE(WriteSpeeds(speeds, file_).ok());
  const net::Styles after = Read();
  ASSERT_EQ(after.size(), before.size());
  EXPECT_EQ(after[1].name, name);
  EXPECT_EQ(after[1].aliases, before[1].aliases);
  EXPECT_FLOAT_EQ(after[1].recorded_s, 61.5F);
  EXPECT_FLOAT_EQ(after[1].recognized, 0.988F);
  EXPECT_FLOAT_EQ(after[1].walk_mps, 1.25F);
  EXPECT_EQ(after[1].run_mps, 0);
  EXPECT_FLOAT_EQ(after[1].walk_spm, 118.4F);
  EXPECT_EQ(after[1].run_spm, 0);
  EXPECT_EQ(after[2].recognized, 0) << "not measured";
}

TEST_F(WeightsOnDisk, ACadenceThatNoBodyHasIsRefusedAndNothingIsWritten) {
  const std::string name = Read()[1].name;
  const Status status = WriteSpeeds(std::vector<StyleSpeeds>{{name, 1.25, 0, 12, 0}}, file_);
  EXPECT_THAT(
      status.message(),
      testing::HasSubstr("'styles[1].walk_spm': expected a number from 20 to 400, found 12"));
  EXPECT_EQ(Read()[1].walk_mps, 0);
}

// A figure of 0 means that the style was not measured.
TEST_F(WeightsOnDisk, AStyleThatIsNeverRecognizedIsWeakAndNotUnknown) {
  const std::string name = Read()[1].name;
  ASSERT_TRUE(WriteEvidence(std::vector<Evidence>{{name, 3, 0}}, kBy, file_).ok());
  EXPECT_TRUE(net::IsWeak(Read()[1]));
  ASSERT_TRUE(WriteEvidence(std::vector<Evidence>{{name, 3, -1}}, kBy, file_).ok());
  EXPECT_TRUE(net::IsWeak(Read()[1])) << "a run that did not measure it takes nothing away";
}

TEST_F(WeightsOnDisk, AreOfTheManifestsStylesByNameOrAlias) {
  std::string shouted = Read()[1].name;
  for (char& letter : shouted) letter = static_cast<char>(std::toupper(letter));
  ASSERT_TRUE(WriteEvidence(std::vector<Evidence>{{shouted, 3, 0.9}}, kBy, file_).ok());
  EXPECT_FLOAT_EQ(Read()[1].recognized, 0.9F);
  EXPECT_THAT(WriteEvidence(std::vector<Evidence>{{"nobody", 3, 1}}, kBy, file_).message(),
              testing::HasSubstr("evidence.safetensors: has none of the manifest's styles"));
}

TEST_F(WeightsOnDisk, FiguresOfOtherJudgesDoNotStandSideBySide) {
  const net::Styles styles = Read();
  const std::vector<Evidence> first{{styles[1].name, 3, 0.9}};
  const std::vector<Evidence> second{{styles[2].name, 3, 0.8}};
  ASSERT_TRUE(WriteEvidence(first, kBy, file_).ok());
  const JudgedBy other{.manifest = kBy.manifest, .judges = "fedcba98765432100123"};
  const Status refused = WriteEvidence(second, other, file_);
  EXPECT_THAT(refused.message(),
              testing::HasSubstr("style '" + styles[1].name +
                                 "' was judged on set by judges of SHA-256 0123456789abcdef, "
                                 "expected fedcba9876543210"));
  EXPECT_EQ(Read()[2].recognized, 0) << "nothing is written";
  EXPECT_TRUE(WriteEvidence(second, {"another set", other.judges}, file_).ok());
  EXPECT_TRUE(WriteEvidence(first, other, file_).ok()) << "in place of the old figure";
}

TEST_F(WeightsOnDisk, AFileThatIsNoneIsLeftAlone) {
  std::ofstream(file_) << "no weights";
  const Status status = WriteEvidence(std::vector<Evidence>{{"a", 3, 1}}, kBy, file_);
  EXPECT_THAT(status.message(), testing::HasSubstr("evidence.safetensors"));
  std::stringstream text;
  text << std::ifstream(file_).rdbuf();
  EXPECT_EQ(text.str(), "no weights");
}

TEST(EvidenceOf, IsTheRecordedTimeAndTheShareOfEachStyle) {
  clip::Manifest manifest;
  manifest.styles.resize(4);
  manifest.styles[1].name = "odd";
  manifest.styles[2].name = "rare";
  manifest.styles[3].name = "absent";
  std::vector<train::TrainingClip> clips(3);
  clips[0].style = 1;
  clips[0].poses.resize(60);
  clips[1].style = 1;
  clips[1].poses.resize(30);
  clips[2].style = 2;
  clips[2].poses.resize(15);
  Figures figures;
  figures.styles.resize(4);
  figures.styles[1].sra.windows = 8;
  figures.styles[1].sra.value = 0.75;
  const std::vector<Evidence> evidence = EvidenceOf(manifest, clips, 30, figures);
  ASSERT_EQ(evidence.size(), 2U);
  EXPECT_EQ(evidence[0].style, "odd");
  EXPECT_NEAR(evidence[0].recorded_s, 3, 1e-9);
  EXPECT_NEAR(evidence[0].recognized, 0.75, 1e-9);
  EXPECT_NEAR(evidence[1].recorded_s, 0.5, 1e-9);
  EXPECT_EQ(evidence[1].recognized, -1) << "no window of it was judged";
}

}  // namespace
}  // namespace styled::judge
