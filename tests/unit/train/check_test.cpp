// Errors of a run are reported at once, before anything is trained.

#include "model/train/check.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <fstream>

#include "model/clip/clip.h"
#include "tests/support/temporary_folder.h"
#include "tests/unit/train/walker.h"

namespace styled::train {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr char kHead[] = R"(name = "made-up"
licence = "none"
neutral = "neutral"
styles = [ { name = "neutral", labels = ["plain"] }, { name = "odd", labels = ["odd"] } ]
contents = [ { name = "walk", labels = ["walk"] }, { name = "wave", labels = ["wave"] } ]
)";
constexpr char kByTime[] = R"(
[[clips]]
pattern = "mine/{content}_{style}_{take}.bvh"
rig = "canonical"
split = "train"
time = [0.0, 0.5]
[[clips]]
pattern = "mine/{content}_{style}_{take}.bvh"
rig = "canonical"
split = "judge"
time = [0.5, 0.75]
[[clips]]
pattern = "mine/{content}_{style}_{take}.bvh"
rig = "canonical"
split = "validation"
time = [0.75, 1.0]
)";

class CheckTest : public testing::Test {
 protected:
  void SetUp() override {
    fs::create_directories(folder_ / "mine");
    run_.manifest = folder_ / "manifest.toml";
    run_.data = folder_;
    run_.out = folder_ / "runs" / "odd";
    run_.minutes = 1;
    needs_.judges = folder_ / "judges";
    Manifest(std::string(kHead) + kByTime);
  }

  void Manifest(const std::string& text) { std::ofstream(run_.manifest) << text; }
  // A clip of `seconds` at 30 Hz.
  void Write(const std::string& name, double seconds) {
    clip::Clip clip;
    for (const body::JointRow& row : body::kHumanoid) {
      clip.skeleton.names.emplace_back(row.name);
      clip.skeleton.parents.push_back(row.parent);
      clip.skeleton.offsets.emplace_back(row.x_m, row.y_m, row.z_m);
    }
    clip.rate_hz = 30;
    for (const body::Pose& pose : Walker(static_cast<int>(std::lround(30 * seconds))).poses) {
      rig::RigPose frame(clip.skeleton);
      frame.translations[0] = pose.hips_position_m;
      frame.rotations.assign(pose.rotations.begin(), pose.rotations.end());
      clip.frames.push_back(frame);
    }
    ASSERT_TRUE(clip::WriteBvh(clip, folder_ / "mine" / name).ok());
  }
  void WriteAll(double seconds) {
    for (const char* name : {"walk_plain_1.bvh", "wave_plain_1.bvh", "walk_odd_1.bvh"}) {
      Write(name, seconds);
    }
  }
  Plan Checked() const { return CheckBeforeTraining(run_, needs_); }

  support::TemporaryFolder temporary_;
  const fs::path& folder_ = temporary_.path();
  RunConfig run_;
  Needs needs_;
};

TEST_F(CheckTest, ClipsOfFiveSecondsServeAllSplitsAndNothingIsWritten) {
  WriteAll(5);
  const Plan plan = Checked();
  EXPECT_THAT(plan.wrong, IsEmpty());
  EXPECT_THAT(plan.doubtful, IsEmpty());
  ASSERT_EQ(plan.styles.size(), 2U);
  EXPECT_EQ(plan.styles[0].train.clips, 2);
  EXPECT_NEAR(plan.styles[0].train.seconds, 5, 1e-9);
  EXPECT_EQ(plan.styles[1].windows, 75 - 25 + 1);
  EXPECT_EQ(PlanText(plan, needs_).substr(0, 66),
            "neutral: train 2 clips 5 s, 102 windows of 25 frames; judge 2 clip");
  EXPECT_FALSE(fs::exists(run_.out));
  EXPECT_FALSE(fs::exists(needs_.judges));
}

TEST_F(CheckTest, EverythingThatIsWrongIsSaidAtOnce) {
  WriteAll(5);
  std::ofstream(folder_ / "mine" / "walk_odd_2.bvh") << "HIERARCHY\nROOT\n";
  std::ofstream(folder_ / "mine" / "wave_odd_3.bvh")
      << "HIERARCHY\nROOT a\n{\nOFFSET 0 0 0\nCHANNELS 3 Zrotation Xrotation Yrotation\n"
         "End Site\n{\nOFFSET 0 1 0\n}\n}\nMOTION\nFrames: 1\nFrame Time: 0.033\n0 0 0\n";
  std::ofstream(folder_ / "file") << "x";
  run_.minutes = -1;
  run_.out = folder_ / "file" / "run";
  run_.resume = true;
  needs_.judges = folder_ / "file";
  needs_.files = {{"--init", folder_ / "lost.safetensors"}};
  EXPECT_THAT(Checked().wrong,
              ElementsAre(HasSubstr("--minutes: found -1"),
                          HasSubstr("--minutes: found neither it nor --iterations"),
                          AllOf(HasSubstr("--init "),
                                HasSubstr("lost.safetensors: found no readable file")),
                          AllOf(HasSubstr("--out "), HasSubstr("/file is not a folder")),
                          AllOf(HasSubstr("--resume: found no "), HasSubstr("checkpoint.pt")),
                          AllOf(HasSubstr("--validate "), HasSubstr("/file is not a folder")),
                          HasSubstr("walk_odd_2.bvh:"), HasSubstr("wave_odd_3.bvh: ")))
      << "each file once, though three splits use it";
}

TEST_F(CheckTest, TheManifestsMistakesAreAllNamedWithTheirLines) {
  Manifest(std::string(kHead) + "[[clips]]\npattern = \"mine/{style}_{take}.bvh\"\n" +
           "[[clips]]\npattern = \"{content}_{style}.bvh\"\n");
  EXPECT_THAT(Checked().wrong, ElementsAre(HasSubstr("manifest.toml:6: content: found nothing"),
                                           HasSubstr("manifest.toml:8: pattern: found no file")));
  run_.manifest = folder_ / "lost.toml";
  EXPECT_THAT(Checked().wrong, ElementsAre(HasSubstr("lost.toml: found no readable file")));
}

TEST_F(CheckTest, AStyleWithTooLittleForASplitIsNamedWithWhatItNeeds) {
  WriteAll(5);
  Write("walk_odd_1.bvh", 3);  // a quarter of it is 0.75 s
  EXPECT_THAT(Checked().wrong,
              ElementsAre(HasSubstr("style \"odd\", split \"validation\": found 1 clip, none "
                                    "longer, expected one of 0.83 s or more (25 frames)"),
                          HasSubstr("style \"odd\", split \"judge\": found 1 clip, none longer, "
                                    "expected one of 1.07 s or more (32 frames)")));
  needs_.judges.clear();
  EXPECT_THAT(Checked().wrong, testing::SizeIs(1)) << "no judges, none of their clips";
}

TEST_F(CheckTest, ContentsOfAStyleNeedNeutralClips) {
  for (const char* name : {"walk_plain_1.bvh", "walk_odd_1.bvh", "wave_odd_1.bvh"}) Write(name, 5);
  needs_.paired = true;
  const Plan some = Checked();
  EXPECT_THAT(some.wrong, IsEmpty());
  EXPECT_THAT(
      some.doubtful,
      ElementsAre(HasSubstr("style \"odd\": content \"wave\" has no neutral training clip")));
  fs::remove(folder_ / "mine" / "walk_odd_1.bvh");
  EXPECT_THAT(Checked().wrong, ElementsAre(HasSubstr("expected one of at least one content")));
  needs_.paired = false;
  EXPECT_THAT(Checked().wrong, IsEmpty());
}

TEST_F(CheckTest, ARunThatIsThereIsNotReplaced) {
  WriteAll(5);
  fs::create_directories(run_.out);
  std::ofstream(run_.out / "checkpoint.pt") << "x";
  EXPECT_THAT(Checked().wrong, ElementsAre(HasSubstr("continue it with --resume")));
  run_.resume = true;
  EXPECT_THAT(Checked().wrong, IsEmpty());
}

TEST_F(CheckTest, AFolderThatCannotBeWrittenIsNamed) {
  if (::geteuid() == 0) GTEST_SKIP() << "root may write everywhere";
  WriteAll(5);
  fs::create_directory(folder_ / "closed");
  fs::permissions(folder_ / "closed", fs::perms::owner_read | fs::perms::owner_exec);
  run_.out = folder_ / "closed" / "run";
  EXPECT_THAT(Checked().wrong, ElementsAre(HasSubstr("/closed cannot be written")));
}

TEST_F(CheckTest, WhereNoFolderCanBeMadeIsToldToRoot) {
  WriteAll(5);
  run_.out = "/proc/run";
  EXPECT_THAT(Checked().wrong, ElementsAre(HasSubstr("--out /proc/run: /proc cannot be written")));
  run_.out = folder_ / "new" / "run";
  EXPECT_THAT(Checked().wrong, IsEmpty());
  EXPECT_FALSE(fs::exists(folder_ / "new"));
}

}  // namespace
}  // namespace styled::train
