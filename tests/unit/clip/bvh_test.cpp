#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <clocale>
#include <cmath>
#include <cstdlib>
#include <random>
#include <string>

#include "model/clip/clip.h"
#include "tests/unit/body/random_pose.h"

namespace styled::clip {
namespace {

using body::Angle_rad;
using rig::Quat;
using rig::Vec3;
using testing::HasSubstr;
using testing::StartsWith;

const char kSmall[] =
    "HIERARCHY\n"                                                                 // 1
    "ROOT Hips\n"                                                                 // 2
    "{\n"                                                                         // 3
    "  OFFSET 1 2 3\n"                                                            // 4
    "  CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation\n"  // 5
    "  JOINT Left Arm\n"                                                          // 6
    "  {\n"                                                                       // 7
    "    OFFSET 0 10 0\n"                                                         // 8
    "    CHANNELS 3 Zrotation Yrotation Xrotation\n"                              // 9
    "    End Site\n"                                                              // 10
    "    {\n"                                                                     // 11
    "      OFFSET 0 5 0\n"                                                        // 12
    "    }\n"                                                                     // 13
    "  }\n"                                                                       // 14
    "}\n"                                                                         // 15
    "MOTION\n"                                                                    // 16
    "Frames: 2\n"                                                                 // 17
    "Frame Time: 0.0333333\n"                                                     // 18
    "4 5 6 90 0 0 0 0 90\n"                                                       // 19
    "7 8 9 0 0 0 10 20 30\n";                                                     // 20

std::string With(const std::string& from, const std::string& to) {
  std::string text = kSmall;
  const auto at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

std::string Refusal(const std::string& text) {
  const Result<Clip> clip = ParseBvh(text, "x.bvh");
  return clip.ok() ? "accepted" : clip.status().message();
}

struct Case {
  std::string text, message;
};

// Broken files and their error messages: file, line, what was found, what was expected.
std::vector<Case> Broken() {
  std::string deep = "HIERARCHY\nROOT a\n{\n", wide = "HIERARCHY\nROOT a\n{\n";
  for (int i = 0; i < 300; ++i) deep += "JOINT b\n{\n";
  for (int i = 0; i < 1100; ++i) wide += "JOINT b\n{\n}\n";
  return {
      {"", "x.bvh:1: found the end, expected HIERARCHY"},
      {"MOTION", "x.bvh:1: found \"MOTION\", expected HIERARCHY"},
      {With("ROOT", "JOINT"), "x.bvh:2: found \"JOINT\", expected ROOT"},
      {With("ROOT Hips", "ROOT"), "x.bvh:2: found no name, expected a joint name"},
      {With("JOINT Left Arm", "JOINT  {"), "x.bvh:6: found no name, expected a joint name"},
      {With("Hips\n{", "Hips\n"), "x.bvh:4: found \"OFFSET\", expected {"},
      {With("OFFSET 1 2 3", "OFFSET 1 2"), "x.bvh:5: found \"CHANNELS\", expected three OFFSET"},
      {With("OFFSET 1 2 3", "OFFSET 1 nan 3"), "x.bvh:4: found \"nan\""},
      {With("OFFSET 1 2 3", "WIDTH 3"), "x.bvh:4: found \"WIDTH\", expected OFFSET, CHANNELS"},
      {With("CHANNELS 6", "CHANNELS 7"), "x.bvh:5: found \"7\", expected 0 to 6 channels"},
      {With("CHANNELS 6", "CHANNELS -1"), "x.bvh:5: found \"-1\""},
      {With("CHANNELS 6", "CHANNELS 2.5"), "x.bvh:5: found \"2.5\""},
      {With("CHANNELS 6", "CHANNELS x"), "x.bvh:5: found \"x\""},
      {With("Zposition", "Wposition"), "x.bvh:5: found \"Wposition\", expected a channel"},
      {With("Zposition", "Xposition"), "x.bvh:5: found \"Xposition\" twice"},
      {With("  JOINT Left", "CHANNELS 1 Xrotation\n  JOINT Left"), "x.bvh:6: found CHANNELS again"},
      {With("MOTION", "EMOTION"), "x.bvh:16: found \"EMOTION\", expected MOTION"},
      {With("Frames: 2", "2"), "x.bvh:17: found \"2\", expected Frames:"},
      {With("Frames: 2", "Framed: 2"), "x.bvh:17: found \"Framed:\", expected Frames:"},
      {With("Frames: 2", "Frames 2"), "x.bvh:17: found \"2\", expected Frames:"},
      {With("OFFSET 1 2 3", "OFFSET 1 2,5,1 3"), "x.bvh:4: found \"2,5,1\""},
      {With("OFFSET 1 2 3", "OFFSET 1 2.5,1 3"), "x.bvh:4: found \"2.5,1\""},
      {With("MOTION", "ROOT Second"), "x.bvh:17: found \"Frames:\", expected {"},
      {With("20 30\n", "20\n30\n"), "x.bvh:20: found 8 values in row 2, expected 9"},
      {With("4 5 6 90", "4 5 nan 90")
           .replace(With("4 5 6 90", "4 5 nan 90").find("7 8 9"), 5, "7 8 inf"),
       "found no row of numbers alone, expected at least one"},
      {With("Frames: 2", "Frames: -2"), "x.bvh:17: found \"-2\""},
      {With("Frames: 2", "Frames: 99999999999999999999"), "x.bvh:17: found \"9999999"},
      {With("Frame Time: 0.0333333", "Frame Time: 0"),
       "x.bvh:18: found \"0\", expected a frame time of 0.001 to 1 s"},
      {With("Frame Time: 0.0333333", "Frame Time: 2"), "x.bvh:18: found \"2\""},
      {With("Frame Time: 0.0333333", "Frame Time: 0.0001"), "x.bvh:18: found \"0.0001\""},
      {With("Frame Time: 0.0333333", "Frame Time: -0.03"), "x.bvh:18: found \"-0.03\""},
      {With("Frame Time: 0.0333333", "Frame Time: inf"), "x.bvh:18: found \"inf\""},
      {With("Frame Time", "Frame Rate"), "x.bvh:18: found \"Rate"},
      {With("4 5 6 90", "4 5 6"), "x.bvh:19: found 8 values in row 1, expected 9"},
      {With("20 30\n", "20\n"), "x.bvh:20: found 8 values in row 2, expected 9"},
      {With("20 30\n", "20 30 40\n"), "x.bvh:20: found more than 9 values in row 2, expected 9"},
      {With("4 5 6 90", "4 5 x 90"), "x.bvh:19: found \"x\" as value 3 of row 1"},
      {With("4 5 6 90", "4 5 1e300 90"),
       "x.bvh:19: found \"1e300\" as value 3 of row 1, expected a number within 1e9 of 0"},
      {"HIERARCHY\nROOT a\n{\nCHANNELS 0\n}\nMOTION\nFrames: 1\nFrame Time: 0.1\n",
       "x.bvh:6: found no channels in any joint, expected at least one"},
      {deep, "found one more joint, expected at most 256"},
      {wide, "found one more joint, expected at most 256"},
      {With("Left Arm", std::string(257, 'a')),
       "x.bvh:6: found a joint name of 257 bytes, expected at most 256"},
  };
}

TEST(Bvh, EachBrokenFilesErrorNamesFoundPlaceAndExpected) {
  for (const Case& broken : Broken()) {
    EXPECT_THAT(Refusal(broken.text), HasSubstr(broken.message));
    EXPECT_THAT(Refusal(broken.text), StartsWith("x.bvh:"));
  }
}

TEST(Bvh, RefusesAFileThatIsMissingOrAFolder) {
  EXPECT_THAT(ReadBvh("/nonexistent/a.bvh").status().message(), HasSubstr("/nonexistent/a.bvh"));
  EXPECT_FALSE(ReadBvh(std::filesystem::temp_directory_path()).ok());
}

TEST(Bvh, RefusesEveryPrefixOfAFileAndSurvivesIt) {
  const std::string whole = kSmall;
  const std::size_t first_row = whole.find("\n7 8 9");
  // The text is still whole without the digits of its last number and its line end; and after its
  // first row, which ends in two digits, it has fewer rows than Frames: says.
  for (std::size_t size = 0; size + 3 < whole.size(); ++size) {
    const bool one_row = size + 1 >= first_row && size <= first_row + 1;
    EXPECT_EQ(Refusal(whole.substr(0, size)) == "accepted", one_row) << size;
  }
}

TEST(Bvh, SurvivesGarbageOfEveryKind) {
  std::mt19937 random(1);
  const std::string words[] = {
      "{",  "}",    "ROOT a", "JOINT b",  "OFFSET",
      "1",  "-1e9", "MOTION", "Frames:",  "\n",
      "\0", "nan",  "99",     "End Site", "CHANNELS 3 Xrotation Yrotation Zrotation"};
  for (int round = 0; round < 20000; ++round) {
    std::string text = kSmall;
    for (unsigned edit = 0; edit <= random() % 4; ++edit) {
      const std::size_t at = random() % text.size();
      switch (random() % 4) {
        case 0:
          text[at] = static_cast<char>(random());
          break;
        case 1:
          text.erase(at, random() % 20);
          break;
        case 2:
          text.insert(at, words[random() % std::size(words)]);
          break;
        default:
          text.insert(at, text.substr(random() % text.size(), random() % 60));
      }
      if (text.empty()) text = "x";
    }
    const Result<Clip> clip = ParseBvh(text, "garbage");
    if (!clip.ok()) continue;
    // An accepted clip is complete and finite.
    const int joints = clip.value().skeleton.joint_count();
    EXPECT_GE(clip.value().rate_hz, 0.99);
    for (const rig::RigPose& frame : clip.value().frames) {
      ASSERT_EQ(static_cast<int>(frame.rotations.size()), joints);
      for (const Quat& q : frame.rotations) ASSERT_NEAR(q.norm(), 1, 1e-4);
      for (const Vec3& t : frame.translations) ASSERT_TRUE(t.allFinite());
    }
  }
}

TEST(Bvh, ReadsHierarchyChannelsAndEndSites) {
  const Clip clip = ParseBvh(kSmall, "x").value();
  EXPECT_THAT(clip.skeleton.names, testing::ElementsAre("Hips", "Left Arm"));
  EXPECT_THAT(clip.skeleton.parents, testing::ElementsAre(-1, 0));
  EXPECT_EQ(clip.skeleton.offsets[0], Vec3(1, 2, 3));
  EXPECT_THAT(clip.channels, testing::ElementsAre("XYZzxy", "zyx"));
  ASSERT_EQ(clip.end_sites[1].size(), 1U);
  EXPECT_EQ(clip.end_sites[1][0], Vec3(0, 5, 0));
  EXPECT_EQ(clip.rate_hz, 30.0) << "0.0333333 s means 30 Hz";
  EXPECT_EQ(clip.frames.size(), 2U);
}

TEST(Bvh, PositionChannelsReplaceTheOffset) {
  const Clip clip = ParseBvh(kSmall, "x").value();
  EXPECT_EQ(clip.frames[0].translations[0], Vec3(4, 5, 6));
  EXPECT_EQ(clip.frames[1].translations[0], Vec3(7, 8, 9));
  EXPECT_EQ(clip.frames[0].translations[1], Vec3(0, 10, 0)) << "no channels: the offset";
}

TEST(Bvh, TurnsInChannelOrderFromLeftToRight) {
  const Clip clip = ParseBvh(kSmall, "x").value();
  const auto turn = [](float degrees, const Vec3& axis) {
    return Quat(Eigen::AngleAxisf(degrees * 3.14159265F / 180, axis));
  };
  EXPECT_LT(Angle_rad(clip.frames[0].rotations[0], turn(90, Vec3::UnitZ())), 1e-6);
  EXPECT_LT(Angle_rad(clip.frames[1].rotations[1],
                      turn(10, Vec3::UnitZ()) * turn(20, Vec3::UnitY()) * turn(30, Vec3::UnitX())),
            1e-6);
}

TEST(Bvh, AcceptsWhatExportersWrite) {
  std::string crlf;
  for (char c : std::string(kSmall)) crlf += c == '\n' ? "\r\n" : std::string(1, c);
  const Case cases[] = {
      {crlf, "CRLF"},
      {"\xEF\xBB\xBF" + std::string(kSmall), "byte order mark"},
      {With("HIERARCHY", "hierarchy"), "lower case"},
      {With("Xrotation Yrotation", "xRotation YROTATION"), "mixed case"},
      {With("Frames: 2", "Frames:\t2"), "tab"},
      {With("Frames: 2", "Frames : 2"), "blank before the colon"},
      {With("ROOT Hips\n{", "ROOT Hips {"), "brace on the name's line"},
      {With("4 5 6", "  +4\t5.0e0   6 "), "plus, exponent, blanks"},
      {With("90\n7", "90\n\n \n7"), "blank lines between rows"},
      {std::string(kSmall) + "\n \n", "blank lines at the end"},
      {With("End Site\n", "End Site LeftTip\n"), "a named end site"},
      {With("End Site\n", "End Tip\n"), "an end of another name"},
      {With("End Site\n", "End\n"), "an end without a name"},
      {With("Frames: 2", "Frames:2"), "no blank after Frames:"},
      {With("Frame Time: 0", "Frame Time :0"), "no blank after Time :"},
  };
  for (const Case& variant : cases) {
    const Result<Clip> clip = ParseBvh(variant.text, "x");
    ASSERT_TRUE(clip.ok()) << variant.message << ": " << clip.status().message();
    EXPECT_EQ(clip.value().skeleton, ParseBvh(kSmall, "x").value().skeleton) << variant.message;
    EXPECT_EQ(clip.value().frames[0].translations[0], Vec3(4, 5, 6)) << variant.message;
  }
}

// As Blender's importer, or as exporters write it: read, with a remark.
TEST(Bvh, ReadsWhatIsOddAndSaysSo) {
  const std::string other =
      "ROOT Prop\n{\nOFFSET 0 0 0\nCHANNELS 3 Xposition Yposition Zposition\n}\n";
  const std::string prop_last = "4 5 6 90 0 0 0 0 90 1 2 3\n7 8 9 0 0 0 10 20 30 1 2 3\n";
  const std::string rows = "4 5 6 90 0 0 0 0 90\n7 8 9 0 0 0 10 20 30\n";
  const Case cases[] = {
      {With("Frames: 2", "Frames: 1"), "2 rows where Frames: says 1"},
      {With("Frames: 2", "Frames: 0"), "2 rows where Frames: says 0"},
      {With("Frames: 2", "Frames: 3"), "2 rows where Frames: says 3"},
      {With("Frames: 2", "Frames: 4000000000000"), "2 rows where Frames: says 4000000000000"},
      {With(rows, "4 5 6\n90 0 0\n0 0 90\n7 8 9 0\n0 0 10 20 30\n"), "rows of several lines"},
      {With("4 5 6 90", "4,0 5 6,00 90"), "decimal commas are read as points"},
      {With("0.0333333", "0,0333333"), "decimal commas are read as points"},
      {With("7 8 9 0", "7 8 nan 0"), "a row with values that are no numbers"},
      {With("7 8 9 0", "7 8 -1.#IND 0"), "a row with values that are no numbers"},
      {With("MOTION", other + "MOTION")
           .replace(With("MOTION", other + "MOTION").find(rows), rows.size(), prop_last),
       "of several skeletons that of \"Hips\", without \"Prop\""},
      {With("ROOT Hips", other + "ROOT Hips")
           .replace(With("ROOT Hips", other + "ROOT Hips").find(rows), rows.size(),
                    "1 2 3 4 5 6 90 0 0 0 0 90\n1 2 3 7 8 9 0 0 0 10 20 30\n"),
       "of several skeletons that of \"Hips\", without \"Prop\""},
  };
  for (const Case& odd : cases) {
    const Result<Clip> clip = ParseBvh(odd.text, "x");
    ASSERT_TRUE(clip.ok()) << odd.message << ": " << clip.status().message();
    EXPECT_THAT(clip.value().remark, HasSubstr(odd.message));
    EXPECT_EQ(clip.value().skeleton, ParseBvh(kSmall, "x").value().skeleton) << odd.message;
    ASSERT_EQ(clip.value().frames.size(), 2U) << odd.message;
    EXPECT_EQ(clip.value().frames[0].translations[0], Vec3(4, 5, 6)) << odd.message;
    EXPECT_EQ(clip.value().channels.size(), 2U) << odd.message;
  }
  EXPECT_EQ(ParseBvh(kSmall, "x").value().remark, "");
}

TEST(Bvh, TheFrameBeforeStandsForARowWithoutNumbers) {
  const Clip later = ParseBvh(With("7 8 9 0", "nan 8 9 0"), "x").value();
  EXPECT_EQ(later.frames[1].translations[0], Vec3(4, 5, 6));
  const Clip first = ParseBvh(With("4 5 6 90", "4 inf 6 90"), "x").value();
  EXPECT_EQ(first.frames[0].translations[0], Vec3(7, 8, 9)) << "none is before it";
}

TEST(Bvh, PositionsOfTheFirstFrameStandForOffsetsThatAreZero) {
  const Clip clip =
      ParseBvh(
          "HIERARCHY ROOT a\n{ OFFSET 0 0 0 CHANNELS 3 Xposition Yposition Zposition JOINT b\n{ "
          "OFFSET 0 0 0 CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation } } "
          "MOTION Frames: 2 Frame Time: 0.01\n1 2 3 4 5 6 0 0 0\n1 2 3 4 5 7 0 0 0\n",
          "x")
          .value();
  EXPECT_EQ(clip.skeleton.offsets[1], Vec3(4, 5, 6));
  EXPECT_THAT(clip.remark, HasSubstr("no OFFSETs: the first frame's positions stand for them"));
  EXPECT_EQ(clip.frames[1].translations[1], Vec3(4, 5, 7));
}

std::string Utf16(const std::string& text, bool big) {
  std::string wide = big ? "\xFE\xFF" : "\xFF\xFE";
  for (char c : text) {
    if (big) wide += '\0';
    wide += c;
    if (!big) wide += '\0';
  }
  return wide;
}

TEST(Bvh, ReadsTextsOfOtherSystems) {
  std::string mac = kSmall;
  std::replace(mac.begin(), mac.end(), '\n', '\r');
  const std::string end = std::string(kSmall) + "\x1A" + std::string(3, '\0');
  const std::string one = With("0 0 90\n7", "0 0 90\r7"), twice = With("{\n", "{\r\r\n");
  for (const std::string& text : {mac, one, twice, end, Utf16(kSmall, false), Utf16(kSmall, true),
                                  Utf16(mac, false) + '\x1A' + '\0'}) {
    const Result<Clip> clip = ParseBvh(text, "x");
    ASSERT_TRUE(clip.ok()) << clip.status().message();
    EXPECT_EQ(clip.value().skeleton, ParseBvh(kSmall, "x").value().skeleton);
    EXPECT_EQ(clip.value().remark, "");
  }
  // 左 and, of two surrogates, U+1F938.
  std::string wide = Utf16(With("Left Arm", "LM"), false);
  const std::size_t at = wide.find(std::string("L\0M\0", 4));
  wide.replace(at, 4, "\xE6\x5D\x3E\xD8\x38\xDD");
  EXPECT_EQ(ParseBvh(wide, "x").value().skeleton.names[1], "\xE5\xB7\xA6\xF0\x9F\xA4\xB8");
}

TEST(Bvh, ReadsPositionChannelsOnAnyJointAndInAnyOrder) {
  const Clip clip =
      ParseBvh(
          "HIERARCHY ROOT a\n{ OFFSET 1 2 3 CHANNELS 1 Yrotation JOINT b\n{ OFFSET 4 5 6 "
          "CHANNELS 3 Zposition Xrotation Xposition } } MOTION Frames: 1 Frame Time: 0.01\n"
          "90 7 -90 8",
          "x")
          .value();
  EXPECT_EQ(clip.frames[0].translations[0], Vec3(1, 2, 3));
  EXPECT_EQ(clip.frames[0].translations[1], Vec3(8, 5, 7));
  EXPECT_EQ(clip.rate_hz, 100.0);
  EXPECT_NEAR(clip.frames[0].rotations[1].x(), -std::sqrt(0.5), 1e-6);
}

TEST(Bvh, TakesARoundedFrameTimeForTheRateThatIsMeant) {
  for (auto [text, rate_hz] : {std::pair{"0.0083333", 120.0},
                               {"0.008333", 120.0},
                               {"0.0166667", 60.0},
                               {"0.033367", 30000.0 / 1001},
                               {"0.0417083", 24000.0 / 1001},
                               {"0.04", 25.0},
                               {"1", 1.0},
                               {"0.001", 1000.0}}) {
    const Result<Clip> clip = ParseBvh(With("0.0333333", text), "x");
    ASSERT_TRUE(clip.ok()) << clip.status().message();
    EXPECT_DOUBLE_EQ(clip.value().rate_hz, rate_hz) << text;
  }
  EXPECT_NEAR(ParseBvh(With("0.0333333", "0.03"), "x").value().rate_hz, 33.333, 1e-3);
}

TEST(Bvh, KeepsRotationsContinuousInSignWhereAnglesJump) {
  const Clip clip =
      ParseBvh(
          "HIERARCHY ROOT a\n{ CHANNELS 1 Yrotation } MOTION Frames: 3 Frame Time: 0.1\n"
          "179\n-179\n-177\n",
          "x")
          .value();
  for (int frame = 1; frame < 3; ++frame) {
    EXPECT_GT(clip.frames[frame].rotations[0].dot(clip.frames[frame - 1].rotations[0]), 0.99);
  }
}

TEST(Bvh, DoesNotDependOnTheLocale) {
  const char* locale = std::setlocale(LC_ALL, "de_DE.UTF-8");
  const Clip clip = ParseBvh(With("4 5 6", "4.25 5 6"), "x").value();
  EXPECT_EQ(clip.frames[0].translations[0].x(), 4.25F);
  EXPECT_THAT(FormatBvh(clip), HasSubstr("4.250000"));
  if (locale != nullptr) std::setlocale(LC_ALL, "C");
}

TEST(Bvh, OfALongClipTheBeginIsReadIfThatIsTheLimit) {
  const std::string text =
      "HIERARCHY ROOT a\n{ CHANNELS 1 Yrotation } MOTION Frames: 9 Frame Time: 0.1\n"
      "0\n1\n2\n3\n4\n5\n6\nnot read\n";
  const Result<Clip> cut = ParseBvh(text, "x", {.longest_s = 0.6, .work = {}});
  ASSERT_TRUE(cut.ok()) << cut.status().message();
  EXPECT_EQ(cut.value().frames.size(), 7U);
  EXPECT_EQ(cut.value().remark, "only its first 0.6 s are read");
  const Result<Clip> whole = ParseBvh(kSmall, "x", {.longest_s = 1, .work = {}});
  ASSERT_TRUE(whole.ok()) << whole.status().message();
  EXPECT_EQ(whole.value().remark, "");
}

// Pins known facts about the samples.
TEST(Bvh, ReadsARealClip) {
  const char* set = std::getenv("STYLED_DATA");
  const std::filesystem::path file =
      std::filesystem::path(set != nullptr ? set : STYLED_DATA_DEFAULT) /
      "samples/dataset-1_walk_normal_001.bvh";
  if (!std::filesystem::exists(file)) GTEST_SKIP() << "skipped, no data (set STYLED_DATA)";
  const Result<Clip> clip = ReadBvh(file);
  ASSERT_TRUE(clip.ok()) << clip.status().message();
  EXPECT_EQ(clip.value().skeleton.joint_count(), 21);
  EXPECT_EQ(clip.value().frames.size(), 195U);
  EXPECT_EQ(clip.value().rate_hz, 30.0);
  EXPECT_TRUE(clip.value().frames[0].translations[0].isApprox(Vec3(-1.714F, 90.27F, -407.123F)));
}

}  // namespace
}  // namespace styled::clip
