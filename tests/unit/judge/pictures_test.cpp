#include "model/train/judge/pictures.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "model/train/judge/mixed.h"
#include "tests/unit/judge/arm_network.h"
#include "tests/unit/train/walker.h"

namespace styled::judge {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::StartsWith;

// The network's number of each style of the manifest; its angles are in the order of these.
// "unwalked" is the farthest of all, but has no walk.
const std::vector<std::string> kNames{"neutral", "a", "b", "absent", "c", "d", "e", "unwalked"};
const std::vector<int> kStyleOf{0, 2, 5, kAbsent, 1, 3, 4, 6};
enum Style { kNeutral, kA, kB, kStyleAbsent, kC, kD, kE, kUnwalked };
enum Pictured { kBowPictured, kWalkPictured };

struct PicturesTest : testing::Test {
  Data data;

  void Add(int style, int content, int frames) {
    train::TrainingClip& clip = data.validation.emplace_back(train::Walker(frames));
    clip.file = "clips/" + std::to_string(frames) + ".bvh";  // the length names the clip
    clip.style = style;
    clip.content = content;
    const int number = kStyleOf[static_cast<std::size_t>(style)];
    SetArm(clip.poses, number < 0 ? 0 : ArmNetwork::StyleAngle_rad(number));
  }
  void SetUp() override {
    for (const std::string& name : kNames) data.manifest.styles.push_back({name, {}, {}});
    data.manifest.contents = {"bow", "walk"};
    Add(kNeutral, kWalkPictured, 100);
    Add(kNeutral, kWalkPictured, 140);
    Add(kNeutral, kBowPictured, 200);
    for (const int style : {kA, kB, kStyleAbsent, kC, kD, kE}) {
      Add(style, kWalkPictured, 60 + style);
      Add(style, kWalkPictured, 70 + style);
      Add(style, kBowPictured, 150 + style);
    }
    Add(kUnwalked, kBowPictured, 180);
  }
  std::vector<Picture> Pictures(const std::vector<int>& style_of = kStyleOf) const {
    const auto network = std::make_shared<ArmNetwork>(ArmHabits{});
    return PicturesOf(data, ClipRestyler(network, style_of, {}, {.rate_hz = kJudgeRate_hz}));
  }
};

std::vector<std::string> CaptionsOf(const Picture& picture) {
  std::vector<std::string> captions;
  for (const Strip& strip : picture.strips) captions.push_back(strip.caption);
  return captions;
}

// Every frame shows the arm at this angle; outputs are seen as a source as long as they.
void ExpectArm(const Strip& strip, float angle_rad) {
  SCOPED_TRACE(strip.caption);
  for (const body::Pose& pose : strip.poses) ASSERT_NEAR(ArmOf(pose), angle_rad, 0.01F);
  EXPECT_LT(strip.first, strip.poses.size());
  if (strip.caption.starts_with("output")) {
    EXPECT_EQ(strip.source.size(), strip.poses.size());
  } else {
    EXPECT_TRUE(strip.source.empty());
  }
}
float Mean_rad(int style) {
  return ArmNetwork::StyleAngle_rad(kStyleOf[static_cast<std::size_t>(style)]);
}

TEST_F(PicturesTest, FourStylesAreShownByAnExampleEachBesideIt) {
  const std::vector<Picture> pictures = Pictures();
  ASSERT_EQ(pictures.size(), 4U);
  const Picture& picture = pictures[0];
  EXPECT_THAT(CaptionsOf(picture),
              ElementsAre("source, neutral walk, 140.bvh", "output, a by the example below",
                          "example, a walk, 71.bvh", "output, b by the example below",
                          "example, b walk, 72.bvh", "output, c by the example below",
                          "example, c walk, 74.bvh", "output, e by the example below",
                          "example, e walk, 76.bvh"));
  EXPECT_EQ(picture.strips[0].poses.size(), 140U);
  ExpectArm(picture.strips[0], 0);
  std::size_t strip = 1;
  for (const int style : {kA, kB, kC, kE}) {
    EXPECT_EQ(picture.strips[strip].poses.size(), 140U) << "the source";
    ExpectArm(picture.strips[strip++], Mean_rad(style));
    ExpectArm(picture.strips[strip++], Mean_rad(style));
  }
}

TEST_F(PicturesTest, ThreeNoisesAreOfTheTwoStylesThatAreFarthestApart) {
  const std::vector<Picture> pictures = Pictures();
  ASSERT_EQ(pictures.size(), 4U);
  const Picture& picture = pictures[1];
  EXPECT_THAT(
      CaptionsOf(picture),
      ElementsAre("source, neutral walk, 140.bvh", "output, b, noise 1", "output, b, noise 2",
                  "output, b, noise 3", "real, b walk, 72.bvh", "output, c, noise 1",
                  "output, c, noise 2", "output, c, noise 3", "real, c walk, 74.bvh"));
  std::size_t strip = 1;
  for (const int style : {kB, kC}) {
    for (std::uint64_t seed = 1; seed <= 3; ++seed) {
      ExpectArm(picture.strips[strip++], Mean_rad(style) + ArmNetwork::SeedAngle_rad(seed));
    }
    ExpectArm(picture.strips[strip++], Mean_rad(style));
  }
}

TEST_F(PicturesTest, BetweenThemTheCodeGoesInQuarters) {
  const std::vector<Picture> pictures = Pictures();
  ASSERT_EQ(pictures.size(), 4U);
  const Picture& picture = pictures[2];
  ASSERT_EQ(picture.strips.size(), 6U);
  EXPECT_THAT(picture.strips[0].caption, StartsWith("source"));
  EXPECT_EQ(picture.strips[2].caption, "output, b to c, 0.25");
  for (std::size_t quarter = 0; quarter <= 4; ++quarter) {
    const float share = 0.25F * static_cast<float>(quarter);
    ExpectArm(picture.strips[1 + quarter], (1 - share) * Mean_rad(kB) + share * Mean_rad(kC));
  }
}

TEST_F(PicturesTest, TheMixedClipIsShownWholeAboveItsOutput) {
  const std::vector<Picture> pictures = Pictures();
  ASSERT_EQ(pictures.size(), 4U);
  const Picture& picture = pictures[3];
  EXPECT_EQ(picture.title, "1000 frames of mixed acts, all in b");
  const std::size_t row = picture.step * static_cast<std::size_t>(picture.figures);
  ASSERT_EQ(picture.strips.size(), 2 * ((kMixedFrames + row - 1) / row));
  const MixedClip mixed = MakeMixed(data);
  for (std::size_t i = 0; i < picture.strips.size(); ++i) {
    const Strip& strip = picture.strips[i];
    EXPECT_THAT(strip.caption, StartsWith(i % 2 == 0 ? "source from" : "output from"));
    EXPECT_EQ(strip.first, i / 2 * row);
    EXPECT_EQ(strip.poses.size(), kMixedFrames);
    ExpectArm(strip, i % 2 == 0 ? 0 : Mean_rad(kB));
    for (const MixedClip::Segment& segment : mixed.segments) {
      if (segment.begin >= strip.first + row || segment.end <= strip.first) continue;
      EXPECT_THAT(strip.caption, HasSubstr(segment.content == kBowPictured ? "bow" : "walk"));
    }
  }
  EXPECT_EQ(picture.strips[0].caption, "source from frame 0: bow");
  EXPECT_EQ(picture.strips[2].caption, "source from frame 120: walk, bow");
}

TEST_F(PicturesTest, TwoStylesAreEnoughAndOneIsNot) {
  std::vector<int> style_of(kNames.size(), kAbsent);
  style_of[kD] = 3;
  style_of[kUnwalked] = 6;
  EXPECT_TRUE(Pictures(style_of).empty());
  style_of[kA] = 2;
  const std::vector<Picture> pictures = Pictures(style_of);
  ASSERT_EQ(pictures.size(), 4U);
  EXPECT_EQ(pictures[0].strips.size(), 1U + 2 * 2);
  EXPECT_EQ(pictures[1].strips.size(), 1U + 2 * 4);
}

TEST_F(PicturesTest, ThereAreNoneWithoutANeutralWalk) {
  std::erase_if(data.validation, [](const auto& clip) {
    return clip.style == kNeutral && clip.content == kWalkPictured;
  });
  EXPECT_TRUE(Pictures().empty());
  data.manifest.contents = {"bow", "run"};
  EXPECT_TRUE(Pictures().empty());
}

}  // namespace
}  // namespace styled::judge
