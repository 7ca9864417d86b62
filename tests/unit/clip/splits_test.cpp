// What networks learn from, what judges learn from and what is judged have no clip in common, in no
// manifest that trains what another one judges; and the test splits are those that are frozen.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>

#include "model/clip/manifest.h"
#include "tests/support/temporary_folder.h"

namespace styled::clip {
namespace {

namespace fs = std::filesystem;

const fs::path kManifests = fs::path(STYLED_SHIPPED) / "manifests";

struct SplitPart {
  std::string file;
  double from = 0, to = 1;
};

// Names alone decide which clip is in which split: empty files of these names.
bool MakeNames(const fs::path& data, const support::TemporaryFolder& folder) {
  for (const char* archive : {"bandai-1", "bandai-2-train", "bandai-2-val", "open"}) {
    const fs::path file = data / (std::string(archive) + ".tar.xz");
    if (!fs::exists(file)) return false;
    std::FILE* const list = popen(("tar -tJf '" + file.string() + "'").c_str(), "r");
    if (list == nullptr) return false;
    std::array<char, 4096> line{};
    while (std::fgets(line.data(), line.size(), list) != nullptr) {
      std::string name(line.data());
      name.erase(name.find_last_not_of('\n') + 1);
      const fs::path made = folder.path() / name;
      if (!name.ends_with(".bvh")) continue;
      fs::create_directories(made.parent_path());
      std::ofstream touch(made);
    }
    if (pclose(list) != 0) return false;
  }
  return true;
}

class SplitsTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    const char* const data = std::getenv("STYLED_DATA");
    if (data == nullptr) return;
    folder_ = std::make_unique<support::TemporaryFolder>();
    if (!MakeNames(data, *folder_)) folder_.reset();
  }
  static void TearDownTestSuite() { folder_.reset(); }
  void SetUp() override {
    if (!folder_) GTEST_SKIP() << "skipped, no data (set STYLED_DATA)";
  }

  static std::vector<SplitPart> PartsOf(const fs::path& manifest,
                                        const std::set<std::string>& splits) {
    const Result<Manifest> read = LoadManifest(manifest, folder_->path());
    EXPECT_TRUE(read.ok()) << read.status().message();
    std::vector<SplitPart> parts;
    if (!read.ok()) return parts;
    for (const ManifestEntry& entry : read.value().entries) {
      if (!splits.contains(entry.split)) continue;
      parts.push_back(
          {fs::relative(entry.file, folder_->path()).generic_string(), entry.from, entry.to});
    }
    return parts;
  }
  // The files of which both have the same part.
  static std::set<std::string> Shared(const std::vector<SplitPart>& a,
                                      const std::vector<SplitPart>& b) {
    std::multimap<std::string, SplitPart> by_file;
    for (const SplitPart& part : b) by_file.emplace(part.file, part);
    std::set<std::string> shared;
    for (const SplitPart& part : a) {
      const auto [first, last] = by_file.equal_range(part.file);
      for (auto other = first; other != last; ++other) {
        const SplitPart& of = other->second;
        if (part.from < of.to && of.from < part.to) shared.insert(part.file);
      }
    }
    return shared;
  }

  static std::unique_ptr<support::TemporaryFolder> folder_;
};
std::unique_ptr<support::TemporaryFolder> SplitsTest::folder_;

TEST_F(SplitsTest, NoNetworkLearnsFromWhatJudgesLearnFromOrJudge) {
  // All that train weights which set 1 and set 2 judge; open is judged by its own manifest.
  const std::vector<std::pair<const char*, std::vector<const char*>>> judged_by{
      {"v2.toml", {"bandai-1.toml", "bandai-2.toml", "v2.toml"}},
      {"bandai.toml", {"bandai-1.toml", "bandai-2.toml", "bandai.toml"}},
      {"bandai-1.toml", {"bandai-1.toml", "bandai-2.toml"}},
      {"bandai-2.toml", {"bandai-1.toml", "bandai-2.toml"}},
      {"bandai-2-one.toml", {"bandai-2.toml"}},
      {"add-style/base.toml", {"bandai-1.toml", "bandai-2.toml"}},
      {"add-style/feminine.toml", {"bandai-2.toml"}},
      {"add-style/set-1.toml", {"bandai-1.toml", "bandai-2.toml"}},
      {"open.toml", {"open.toml", "bandai-2.toml"}},
      {"add-style/open-fast.toml", {"open.toml", "bandai-2.toml"}}};
  for (const auto& [trains, judges] : judged_by) {
    const auto train = PartsOf(kManifests / trains, {"train"});
    EXPECT_FALSE(train.empty());
    for (const char* const judge : judges) {
      const auto held = PartsOf(kManifests / judge, {"judge", "validation", "test"});
      EXPECT_FALSE(held.empty());
      EXPECT_THAT(Shared(train, held), testing::IsEmpty()) << trains << " judged by " << judge;
    }
  }
}

TEST_F(SplitsTest, JudgesNeverSawWhatTheyJudge) {
  for (const char* const judge : {"bandai-1.toml", "bandai-2.toml", "open.toml"}) {
    const auto learned = PartsOf(kManifests / judge, {"judge"});
    const auto judged = PartsOf(kManifests / judge, {"validation", "test"});
    EXPECT_FALSE(learned.empty());
    EXPECT_THAT(Shared(learned, judged), testing::IsEmpty()) << judge;
  }
}

TEST_F(SplitsTest, NothingChoosesByATestClip) {
  const auto test = PartsOf(kManifests / "bandai-2.toml", {"test"});
  for (const char* const manifest :
       {"bandai.toml", "v2.toml", "bandai-2-one.toml", "add-style/base.toml",
        "add-style/feminine.toml", "add-style/set-1.toml", "bandai-2.toml"}) {
    const auto used = PartsOf(kManifests / manifest, {"train", "judge", "validation"});
    EXPECT_THAT(Shared(used, test), testing::IsEmpty()) << manifest;
  }
}

TEST_F(SplitsTest, TheTestClipsAreThoseOfTheFrozenList) {
  std::set<std::string> frozen;
  std::ifstream list(kManifests / "bandai-2-test.sha256");
  for (std::string hash, file; list >> hash >> file;) {
    EXPECT_EQ(hash.size(), 64U) << file;
    frozen.insert(file);
  }
  std::set<std::string> test;
  for (const SplitPart& part : PartsOf(kManifests / "bandai-2.toml", {"test"})) {
    test.insert(part.file);
  }
  EXPECT_FALSE(test.empty());
  EXPECT_EQ(test, frozen);
}

// The guard's own test.
TEST_F(SplitsTest, AnOverlapIsFound) {
  const std::string copy = folder_->operator/("overlap.toml");
  std::ifstream in(kManifests / "bandai-2.toml");
  std::string text((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
  const std::string share = "judge_share = 0.2";
  ASSERT_NE(text.find(share), std::string::npos);
  text.replace(text.find(share), share.size(), "judge_share = 0.1");
  std::ofstream(copy) << text;
  EXPECT_FALSE(
      Shared(PartsOf(copy, {"train"}), PartsOf(kManifests / "bandai-2.toml", {"judge"})).empty());
}

}  // namespace
}  // namespace styled::clip
