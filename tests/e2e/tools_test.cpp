// The offline programs as a user runs them in a shell.
#include "tests/e2e/tools.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <numbers>
#include <set>

#include "model/clip/clip.h"
#include "model/net/shipped_weights.h"
#include "tests/unit/net/erd/random_weights.h"
#include "tests/unit/net/offset/weights.h"
#include "tests/unit/net/stgcn/random_weights.h"
#include "tests/unit/net/stgcn_causal/random_weights.h"

namespace styled::support {
namespace {

using testing::AllOf;
using testing::HasSubstr;

TEST_F(ToolsTest, StylesimSaysOnceThatNobodyListens) {
  EXPECT_EQ(Run({STYLESIM_BINARY, "--to", "udp://127.0.0.1:9", "--seconds", "1"}), 0);
  const std::string line =
      "stylesim: no program listens at udp://127.0.0.1:9 (Connection refused); sending continues.";
  const std::size_t at = output_.find(line);
  ASSERT_NE(at, std::string::npos) << output_;
  EXPECT_EQ(output_.find(line, at + 1), std::string::npos) << output_;
}

TEST_F(ToolsTest, StylizeTakesItsFilesBehindAMix) {
  const std::string in = Walk(), out = folder_ / "out.bvh";
  ASSERT_EQ(Run({STYLIZE_BINARY, "--overwrite", "--style", "elderly=0.5", "--mix", "active=0.3",
                 "--mix", "youthful=0.1", in, out}),
            0)
      << output_;
  const std::string mixed = ReadText(out);
  ASSERT_EQ(Run({STYLIZE_BINARY, "--overwrite", in, out, "--style", "elderly=0.5"}), 0) << output_;
  EXPECT_NE(mixed, "");
  EXPECT_NE(ReadText(out), mixed);
}

// Styling to neutral needs an input style to remove; without one, neutral requests nothing.
TEST_F(ToolsTest, StylizeTakesAStyleAway) {
  const std::string in = Walk(), out = folder_ / "out.bvh";
  ASSERT_EQ(Run({STYLIZE_BINARY, "--overwrite", "--style", "neutral", in, out}), 0) << output_;
  const std::string untouched = ReadText(out);
  ASSERT_EQ(Run({STYLIZE_BINARY, "--overwrite", "--input-style", "elderly", "--style", "neutral",
                 in, out}),
            0)
      << output_;
  EXPECT_NE(ReadText(out), untouched);
  EXPECT_EQ(Run({STYLIZE_BINARY, "--overwrite", "--from", "elderly", in, out}), 2)
      << "nothing to put on";
  EXPECT_NE(output_.find("give --style neutral to remove elderly"), std::string::npos) << output_;
  EXPECT_EQ(Run({STYLIZE_BINARY, "--overwrite", "--from", "zombie", "--style", "neutral", in, out}),
            2);
  EXPECT_NE(output_.find("--input-style: unknown style 'zombie'"), std::string::npos) << output_;
}

// The shipped network with a content input.
class StylizeContents : public ToolsTest {
 protected:
  std::string WithContents(bool idle) {
    const auto shipped = net::FindWeights("");
    EXPECT_TRUE(shipped.ok()) << shipped.status().message();
    erd::WeightsFile file = erd::ReadParts(shipped.value());
    erd::AddContents(file, 3, 1, idle);
    const std::string name = folder_ / (idle ? "idle.safetensors" : "contents.safetensors");
    WriteWeights(name, file);
    return name;
  }
  std::string Stylize(std::vector<std::string> arguments) {
    const std::string out = folder_ / "out.bvh";
    arguments.insert(arguments.begin(), {STYLIZE_BINARY, "--overwrite", "--style", "elderly"});
    arguments.insert(arguments.end(), {in_, out});
    EXPECT_EQ(Run(arguments), 0) << output_;
    return ReadText(out);
  }

  std::string in_ = Walk("30", "3");
};

TEST_F(StylizeContents, EachContentIsSeen) {
  const std::string weights = WithContents(false);
  std::set<std::string> all{Stylize({"--weights", weights})};
  for (const std::string content : {"unknown", "content1", "CONTENT3"}) {
    EXPECT_TRUE(all.insert(Stylize({"--weights", weights, "--content", content})).second)
        << content;
  }
}

TEST_F(StylizeContents, IdleContentsChangeNoByte) {
  const std::string weights = WithContents(true), shipped = Stylize({});
  EXPECT_EQ(Stylize({"--weights", weights}), shipped);
  EXPECT_EQ(Stylize({"--weights", weights, "--content", "content2"}), shipped);
}

TEST_F(StylizeContents, AContentThatTheNetworkLacksIsRefusedWithTheChoices) {
  const std::string weights = WithContents(false), out = folder_ / "out.bvh";
  const auto refusal = [&](std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), STYLIZE_BINARY);
    arguments.insert(arguments.end(), {in_, out});
    EXPECT_EQ(Run(arguments), 2);
    EXPECT_FALSE(std::filesystem::exists(out));
    return output_;
  };
  EXPECT_NE(refusal({"--weights", weights, "--style", "elderly", "--content", "walk"})
                .find("--content: unknown content 'walk'; expected one of unknown, content1, "
                      "content2, content3"),
            std::string::npos)
      << output_;
  EXPECT_NE(refusal({"--style", "elderly", "--content", "unknown"})
                .find("--content: content 'unknown': the network takes no content as input"),
            std::string::npos)
      << output_;
  EXPECT_NE(refusal({"--weights", weights, "--content", "content1"}).find("expected a style"),
            std::string::npos)
      << output_;
}

TEST_F(ToolsTest, StylizeTakesTheBodyAlongAtTheSpeedOfTheStyle) {
  const std::string in = Walk("30", "4"), out = folder_ / "out.bvh";
  const auto way = [&](const std::string& root) {
    EXPECT_EQ(Run({STYLIZE_BINARY, "--overwrite", "--style", "elderly", "--root", root, in, out}),
              0)
        << output_;
    const clip::Clip styled = clip::ReadBvh(out).value();
    const rig::Vec3 way =
        styled.frames.back().translations[0] - styled.frames.front().translations[0];
    return std::hypot(way.x(), way.z());
  };
  const float followed = way("follow");
  EXPECT_LT(way("stride"), 0.9F * followed) << "the elderly walk slower";
  EXPECT_EQ(Run({STYLIZE_BINARY, "--overwrite", "--style", "elderly", "--root", "home", in, out}),
            2);
  EXPECT_NE(output_.find("follow,stride"), std::string::npos) << output_;
  EXPECT_EQ(Run({STYLIZE_BINARY, "--overwrite", "--root", "stride", in, out}), 2);
  EXPECT_NE(output_.find("--root stride: expected a style"), std::string::npos) << output_;
}

// Between frames far apart, stylize interpolates along a curve: its result for 10 frames per second
// matches that for 30.
TEST_F(ToolsTest, StylizeMakesOfASlowClipWhatItMakesOfAFastOne) {
  std::vector<clip::Clip> styled;
  for (const std::string rate_hz : {"30", "10"}) {
    const std::string in = Walk(rate_hz, "5"), out = folder_ / "out.bvh";
    ASSERT_EQ(Run({STYLIZE_BINARY, "--overwrite", "--style", "elderly", in, out}), 0) << output_;
    styled.push_back(clip::ReadBvh(out).value());
  }
  ASSERT_GE(styled[0].frames.size(), 3 * (styled[1].frames.size() - 1) + 1);
  double sum_rad = 0;
  int count = 0;
  for (std::size_t i = 0; i < styled[1].frames.size(); ++i) {
    const auto& slow = styled[1].frames[i].rotations;
    const auto& fast = styled[0].frames[3 * i].rotations;
    for (std::size_t joint = 0; joint < slow.size(); ++joint, ++count) {
      sum_rad += slow[joint].angularDistance(fast[joint]);
    }
  }
  EXPECT_LT(sum_rad / count * 180 / std::numbers::pi, 0.2);  // 0.65 without the curve
}

TEST_F(ToolsTest, StylizeRefusesWildWeightsAndWritesNothing) {
  const std::string in = Walk(), out = folder_ / "out.bvh", weights = folder_ / "wild.safetensors";
  for (const char* const tensor : {"head.rotation.weight", "feature.deviation"}) {
    erd::WeightsFile wild = erd::RandomWeights(5, 1);
    for (float& value : wild.tensor(tensor).values) value *= 1e30F;
    WriteWeights(weights, wild);
    EXPECT_EQ(
        Run({STYLIZE_BINARY, "--overwrite", "--weights", weights, "--style", "style2", in, out}),
        1);
    EXPECT_NE(output_.find(weights + ": the trial run"), std::string::npos) << output_;
    EXPECT_NE(output_.find("expected a rotation of length 1, found nan"), std::string::npos)
        << output_;
    EXPECT_FALSE(std::filesystem::exists(out)) << tensor;
  }
}

// Weights whose defect a trial cannot detect: they produce invalid poses only when the performer's
// hips are high.
TEST_F(ToolsTest, StylizeSaysHowManyFramesItCouldNotStyleAndWritesNoNonsense) {
  const std::string in = Walk(), out = folder_ / "out.bvh", weights = folder_ / "sleeping";
  clip::Clip clip = clip::ReadBvh(in).value();
  const float up = (erd::kAwake_m + 0.1F) / 0.98F;
  ASSERT_GT(clip.frames.size(), 25U);
  for (std::size_t i = 10; i < 20; ++i) clip.frames[i].translations[0].y() *= up;
  ASSERT_TRUE(clip::WriteBvh(clip, in).ok());
  WriteWeights(weights, erd::SleepingWeights(5, 1));
  EXPECT_EQ(
      Run({STYLIZE_BINARY, "--overwrite", "--weights", weights, "--style", "style2", in, out}), 3);
  EXPECT_NE(output_.find("out.bvh: 10 of " + std::to_string(clip.frames.size()) +
                         " frames are the performer's own"),
            std::string::npos)
      << output_;
  const auto styled = clip::ReadBvh(out);
  ASSERT_TRUE(styled.ok()) << styled.status().message();
  ASSERT_EQ(styled.value().frames.size(), clip.frames.size());
  for (std::size_t i = 0; i < clip.frames.size(); ++i) {
    float apart_rad = 0;
    for (std::size_t joint = 0; joint < clip.frames[i].rotations.size(); ++joint) {
      ASSERT_TRUE(styled.value().frames[i].translations[joint].allFinite()) << i;
      ASSERT_NEAR(styled.value().frames[i].rotations[joint].norm(), 1, 1e-3) << i;
      apart_rad = std::max(apart_rad, styled.value().frames[i].rotations[joint].angularDistance(
                                          clip.frames[i].rotations[joint]));
    }
    const bool high = i >= 10 && i < 20;
    EXPECT_EQ(apart_rad < 1e-3F, high || i == 20)
        << i << ": the first one after is faded in from 0";
  }
}

// Weights of another family with the same program: the spine's rotation is the style's offset.
TEST_F(ToolsTest, StylizeRunsAConstantOffset) {
  const std::string in = Walk(), out = folder_ / "out.bvh", weights = folder_ / "offset";
  offset::WriteTestWeights(weights);
  ASSERT_EQ(
      Run({STYLIZE_BINARY, "--overwrite", "--weights", weights, "--style", "stooped", in, out}), 0)
      << output_;
  const clip::Clip given = clip::ReadBvh(in).value(), styled = clip::ReadBvh(out).value();
  ASSERT_EQ(styled.frames.size(), given.frames.size());
  for (std::size_t i = 0; i < given.frames.size(); ++i) {
    EXPECT_NEAR(styled.frames[i].rotations[body::kSpine].angularDistance(
                    given.frames[i].rotations[body::kSpine]),
                offset::kBent_rad, 1e-2)
        << i;
  }
  EXPECT_EQ(
      Run({STYLIZE_BINARY, "--overwrite", "--weights", weights, "--style", "elderly", in, out}), 2);
  EXPECT_NE(output_.find("unknown style 'elderly'; expected one of neutral, bent, raised"),
            std::string::npos)
      << output_;
}

// Weights whose network needs whole clips, with the same program.
class StylizeClips : public ToolsTest {
 protected:
  StylizeClips() { UseWeights(stgcn::RandomWeights(4, 16, 1)); }
  void UseWeights(const stgcn::WeightsFile& weights) {
    const std::vector<std::byte> bytes = weights.Bytes();
    WriteText(weights_, std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
  }
  // Runs stylize with these arguments in front of the files; what it wrote, or "".
  std::string Stylize(std::vector<std::string> arguments, const std::string& in) {
    arguments.insert(arguments.begin(), {STYLIZE_BINARY, "--weights", weights_});
    arguments.insert(arguments.end(), {in, out_});
    std::filesystem::remove(out_);
    return Run(arguments) == 0 ? ReadText(out_) : "";
  }
  // The refusal of these arguments: nothing is written.
  std::string Refusal(const std::vector<std::string>& arguments, const std::string& in) {
    EXPECT_EQ(Stylize(arguments, in), "");
    EXPECT_FALSE(std::filesystem::exists(out_));
    return output_;
  }

  std::string weights_ = folder_ / "stgcn.safetensors", out_ = folder_ / "out.bvh";
};

TEST_F(StylizeClips, AWeightIsAShareOfAMeasuredStylesChange) {
  weights_ = net::FindWeights("open").value();
  const std::string in = Walk("30", "4"), example = Walk("60", "4");
  const std::string half = Stylize({"--like", example, "--strength", "0.5"}, in);
  ASSERT_NE(half, "") << output_;
  EXPECT_EQ(Stylize({"--like", example + "=0.5"}, in), half);
  EXPECT_NE(Stylize({"--like", example}, in), half);
}

TEST_F(StylizeClips, ADesignAloneIsAStyle) {
  weights_ = net::FindWeights("open").value();
  const std::string in = Walk("30", "4");
  const std::string none = Stylize({"--design", "sneaky", "--strength", "0"}, in);
  const std::string half = Stylize({"--design", "sneaky", "--strength", "0.5"}, in);
  ASSERT_NE(none, "") << output_;
  EXPECT_NE(half, none);
  EXPECT_NE(Stylize({"--design", "sneaky"}, in), half);
}

TEST_F(StylizeClips, SlidersOfWeightsWithoutAnyAreRefused) {
  weights_ = net::FindWeights("v2").value();
  EXPECT_NE(Refusal({"--design", "sneaky"}, Walk()).find("have no sliders"), std::string::npos)
      << output_;
}

TEST_F(StylizeClips, StylesByNameExampleNoiseAndMix) {
  const std::string in = Walk("30", "4"), example = Walk("60", "3");
  const std::string source = ReadText(in);
  const std::string named = Stylize({"--style", "style2"}, in);
  ASSERT_NE(named, "") << output_;
  EXPECT_NE(named, source);
  EXPECT_EQ(Stylize({"--style", "s2"}, in), named) << "the same twice, and by its alias";
  std::set<std::string> all{named};
  for (const std::vector<std::string>& arguments : std::vector<std::vector<std::string>>{
           {"--style", "style2", "--strength", "0.5"},
           {"--style", "style2", "--vary", "1"},
           {"--style", "style2", "--vary", "2"},
           {"--style", "style2", "--vary", "2", "--amount", "0.4"},
           {"--like", example},
           {"--like", example + "=0.7"},
           {"--like", example, "--like", in},
           {"--like", example + "=0.5", "--style", "style2=0.5"},
           {"--style", "style2=0.5", "--mix", "style3=0.5"},
           {"--style", "style2", "--input-style", "style1"},
           {"--style", "neutral", "--input-style", "style1"},
           {"--style", "style2", "--only", "arms"},
           {"--style", "style2", "--absolute"},
           {"--style", "style2", "--window", "overlapping", "--no-feet"}}) {
    const std::string written = Stylize(arguments, in);
    EXPECT_NE(written, "") << output_;
    EXPECT_TRUE(all.insert(written).second) << testing::PrintToString(arguments);
  }
  EXPECT_EQ(Stylize({"--style", "style2", "--vary", "9", "--amount", "0"}, in), named);
  EXPECT_EQ(Stylize({}, in), Stylize({"--style", "style2", "--strength", "0"}, in)) << "bypass";
  EXPECT_EQ(Stylize({"--style", "neutral"}, in), Stylize({}, in));
}

TEST_F(StylizeClips, StylesWithoutAWeightShareTheRestOfOne) {
  const std::string in = Walk("30", "3"), other = Walk("60", "3");
  const std::string third = "=0.33333334";
  EXPECT_EQ(Stylize({"--style", "style2", "--like", other}, in),
            Stylize({"--style", "style2=0.5", "--like", other + "=0.5"}, in));
  EXPECT_EQ(Stylize({"--like", in + "=0.75", "--like", other}, in),
            Stylize({"--like", in + "=0.75", "--like", other + "=0.25"}, in));
  EXPECT_EQ(
      Stylize({"--style", "style1", "--mix", "style2", "--like", other}, in),
      Stylize({"--style", "style1" + third, "--mix", "style2" + third, "--like", other + third},
              in));
  EXPECT_NE(Stylize({"--style", "style2", "--like", other}, in),
            Stylize({"--style", "style2"}, in));
}

TEST_F(StylizeClips, TheInputStyleAloneIsRefusedWithWhatRemovesIt) {
  const std::string in = Walk("30", "3");
  EXPECT_NE(Refusal({"--input-style", "style1"}, in)
                .find("--input-style: expected --style, --mix or --like, found none: give --style "
                      "neutral to remove style1"),
            std::string::npos)
      << output_;
}

TEST_F(StylizeClips, NumbersOfVariationsAreWholeAndInRange) {
  const std::string in = Walk("30", "3");
  for (const char* const number : {"-1", "18446744073709551616", "1e5", "1.5", ""}) {
    EXPECT_NE(Refusal({"--style", "style1", "--vary", number}, in)
                  .find("'" + std::string(number) +
                        "': expected a whole number from 0 to 18446744073709551615"),
              std::string::npos)
        << number << ": " << output_;
  }
  EXPECT_NE(Stylize({"--style", "style1", "--vary", "18446744073709551615"}, in), "") << output_;
}

TEST_F(StylizeClips, KeepsFramesAndRateOfAnyClip) {
  for (const char* const rate_hz : {"10", "30", "50", "120"}) {
    const std::string in = Walk(rate_hz, "2");
    ASSERT_NE(Stylize({"--style", "style1"}, in), "") << output_;
    const clip::Clip given = clip::ReadBvh(in).value(), styled = clip::ReadBvh(out_).value();
    EXPECT_EQ(styled.frames.size(), given.frames.size());
    EXPECT_EQ(styled.rate_hz, given.rate_hz);
  }
}

TEST_F(StylizeClips, AnExampleOfAStyleIsCalledThat) {
  const std::string in = Walk("30", "4");
  ASSERT_NE(Stylize({"--like", in}, in), "") << output_;
  EXPECT_NE(output_.find(in + ": nearest to "), std::string::npos) << output_;
  EXPECT_NE(output_.find(" of the mean distance between styles"), std::string::npos) << output_;
}

TEST_F(StylizeClips, AnExampleIsReadOnceForAllStyles) {
  const std::string in = Walk("30", "4"), example = Walk("60", "3");
  ASSERT_EQ(Run({STYLIZE_BINARY, "--overwrite", "--weights", weights_, "--style", "style1,style2",
                 "--like", example, "--out", folder_ / "{style}.bvh", in}),
            0)
      << output_;
  EXPECT_TRUE(std::filesystem::exists(folder_ / "style2.bvh"));
  const std::size_t first = output_.find("nearest to ");
  ASSERT_NE(first, std::string::npos) << output_;
  EXPECT_EQ(output_.find("nearest to ", first + 1), std::string::npos) << output_;
}

TEST_F(StylizeClips, RefusesWhatItCannotDo) {
  const std::string in = Walk("30", "3");
  const auto refuses = [&](const std::vector<std::string>& arguments, const std::string& reason) {
    const std::string said = Refusal(arguments, in);
    EXPECT_NE(said.find(reason), std::string::npos) << said;
  };
  refuses({"--style", "zombie"},
          "--style: unknown style 'zombie'; expected one of neutral, style1, style2, style3");
  refuses({"--mix", "zombie=0.2"}, "--mix: unknown style 'zombie'");
  refuses({"--from", "zombie", "--style", "style1"}, "--input-style: unknown style 'zombie'");
  refuses({"--style", "style1=x"},
          "--style: 'style1=x': expected after '=' a weight from 0 to 1.5");
  refuses({"--style", "style1=nan"}, "--style: 'style1=nan': expected after '=' a weight");
  refuses({"--style", "style1", "--mix", "s1=0.1"}, "a style is named twice");
  refuses({"--style", "style1=1", "--like", in + "=0.7", "--strength", "0.5"},
          "--style style1=1, --like " + in +
              "=0.7, --strength 0.5: the weights times the strength sum to 1.7, expected at most "
              "1.5");
  refuses(
      {"--style", "style1", "--like", in + "=1.2"},
      "--style style1, --like " + in + "=1.2: the weights given sum to 1.2, expected less than 1");
  refuses({"--style", "style1", "--strength", "2"}, "--strength is outside 0 to 1.5");
  refuses({"--vary", "3"}, "--vary: expected --style or --mix, found none");
  refuses({"--like", in + "=x"}, "--like: '" + in + "=x': expected after '=' a weight");
  refuses({"--like", in + "=2"},
          "--like: '" + in + "=2': expected after '=' a weight from 0 to 1.5");
  refuses({"--like", folder_ / "none.bvh"}, "--like: " + std::string(folder_ / "none.bvh"));
  refuses({"--style", "style1", "--parts", "tail"}, "--parts tail: expected");
  refuses({"--style", "style1", "--window", "huge"}, "--window");
  refuses({"--style", "style1", "--root", "stride"},
          "--root stride: weights that need whole clips");
  refuses({"--style", "style1", "--cadence"}, "--cadence: weights that need whole clips");
  refuses({"--style", "style1", "--amount", "1"}, "--amount");

  clip::Clip brief = clip::ReadBvh(in).value();
  brief.frames.resize(7, rig::RigPose(brief.skeleton));
  const std::string few = folder_ / "few.bvh";
  ASSERT_TRUE(clip::WriteBvh(brief, few).ok());
  EXPECT_NE(Refusal({"--style", "style1"}, few)
                .find(few + ": found 7 frames at 30 Hz, expected "
                            "at least 8"),
            std::string::npos)
      << output_;
  refuses({"--like", few}, "--like: " + few + ": found 7 frames at 30 Hz, expected at least 8");
}

TEST_F(StylizeClips, AnExampleMayBeGltf) {
  const std::string in = Walk("30", "3"), example = Walk("60", "3"), glb = folder_ / "walk.glb";
  ASSERT_EQ(Run({STYLIZE_BINARY, "-q", "--bind-only", example, glb}), 0) << output_;
  const std::string of_bvh = folder_ / "of_bvh.bvh";
  WriteText(of_bvh, Stylize({"--like", example, "--like-neutral", in}, in));
  ASSERT_NE(Stylize({"--like", glb, "--like-neutral", in}, in), "") << output_;
  const auto a = clip::ReadBvh(of_bvh), b = clip::ReadBvh(out_);
  ASSERT_TRUE(a.ok()) << a.status().message();
  ASSERT_EQ(a.value().frames.size(), b.value().frames.size());
  for (std::size_t i = 0; i < a.value().frames.size(); ++i) {
    for (std::size_t j = 0; j < a.value().frames[i].rotations.size(); ++j) {
      EXPECT_LT(a.value().frames[i].rotations[j].angularDistance(b.value().frames[i].rotations[j]),
                0.01F);
    }
  }
}

TEST_F(StylizeClips, OfALongExampleTheFirstMinuteIsUsed) {
  const std::string minute = Walk("30", "60.04"), in = folder_ / "in.bvh";
  clip::Clip clip = clip::ReadBvh(minute).value();
  ASSERT_EQ(clip.frames.size(), 1801U);
  ASSERT_TRUE(clip::WriteBvh(clip, minute).ok());  // both are written the same way
  for (int i = 0; i < 30; ++i) clip.frames.push_back(clip.frames.front());
  const std::string longer = folder_ / "longer.bvh";
  ASSERT_TRUE(clip::WriteBvh(clip, longer).ok());
  clip.frames.resize(60, rig::RigPose(clip.skeleton));
  ASSERT_TRUE(clip::WriteBvh(clip, in).ok());
  const std::string of_minute = Stylize({"--like", minute}, in);
  EXPECT_EQ(output_.find("warning"), std::string::npos) << output_;
  ASSERT_NE(of_minute, "");
  EXPECT_TRUE(Stylize({"--like", longer}, in) == of_minute) << output_;
  EXPECT_NE(output_.find("--like " + longer + ": warning: only its first 60 s are read"),
            std::string::npos)
      << output_;
}

// The same of live weights that know a space of styles.
TEST_F(StylizeClips, LiveWeightsTakeExamplesNoiseAndMixToo) {
  UseWeights(stgcn_causal::RandomWeights(4, 16, 1));
  const std::string in = Walk("30", "4"), example = Walk("60", "3");
  const std::string named = Stylize({"--style", "style2"}, in);
  ASSERT_NE(named, "") << output_;
  std::set<std::string> all{named, ReadText(in)};
  for (const std::vector<std::string>& arguments : std::vector<std::vector<std::string>>{
           {"--style", "style2", "--vary", "1"},
           {"--style", "style2", "--vary", "2", "--amount", "0.4"},
           {"--like", example},
           {"--like", example, "--strength", "0.7"},
           {"--like", example, "--absolute"},
           {"--like", example, "--like", in},
           {"--like", example + "=0.5", "--style", "style2=0.5"}}) {
    const std::string written = Stylize(arguments, in);
    EXPECT_NE(written, "") << output_;
    EXPECT_TRUE(all.insert(written).second) << testing::PrintToString(arguments);
  }
  EXPECT_EQ(Stylize({"--style", "style2", "--vary", "9", "--amount", "0"}, in), named);
  EXPECT_NE(Stylize({"--like", example}, in), "");
  EXPECT_NE(output_.find(example + ": nearest to "), std::string::npos) << output_;

  clip::Clip brief = clip::ReadBvh(in).value();
  brief.frames.resize(7, rig::RigPose(brief.skeleton));
  const std::string few = folder_ / "few.bvh";
  ASSERT_TRUE(clip::WriteBvh(brief, few).ok());
  EXPECT_NE(Refusal({"--like", few}, in)
                .find("--like: " + few + ": found 7 frames at 30 Hz, expected at least 8"),
            std::string::npos)
      << output_;
  EXPECT_NE(Refusal({"--style", "style2", "--window", "whole"}, in)
                .find("\"st-gcn-causal\" have no windows; expected weights of family \"st-gcn\""),
            std::string::npos)
      << output_;
}

TEST_F(StylizeClips, WeightsWithoutAStyleEncoderAreNamed) {
  const std::string in = Walk("30", "1");
  offset::WriteTestWeights(weights_);
  EXPECT_NE(Refusal({"--like", in}, in)
                .find("--like: the weights of family \"constant-offset\" have no style encoder; "
                      "expected weights of family \"phase\" or \"st-gcn\" or \"st-gcn-causal\""),
            std::string::npos)
      << output_;
  EXPECT_NE(Refusal({"--style", "bent", "--vary", "1"}, in).find("--vary: the weights of family"),
            std::string::npos)
      << output_;
  EXPECT_NE(Refusal({"--style", "bent", "--window", "whole"}, in).find("--window: the weights of"),
            std::string::npos)
      << output_;
  EXPECT_NE(Refusal({"--style", "bent", "--root", "stride"}, in)
                .find("--root stride: the weights have no speed of 'neutral'"),
            std::string::npos)
      << output_;
}

TEST_F(StylizeClips, WildWeightsAreRefused) {
  const std::string in = Walk("30", "1");
  stgcn::WeightsFile wild = stgcn::RandomWeights(3, 16, 1);
  for (float& value : wild.tensor("g.out.weight").values) value *= 1e38F;
  const std::vector<std::byte> bytes = wild.Bytes();
  WriteText(weights_, std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
  EXPECT_NE(Refusal({"--style", "style1"}, in).find(weights_ + ": the trial run"),
            std::string::npos)
      << output_;
}

TEST_F(ToolsTest, ShippedWeightsAreFoundByName) {
  for (const char* const name : {"st-gcn", "st-gcn.safetensors"}) {
    EXPECT_EQ(Run({STYLIZE_BINARY, "--list", "--weights", name}), 0) << output_;
    EXPECT_NE(output_.find("other weights: --weights v2"), std::string::npos) << output_;
  }
  EXPECT_EQ(Run({STYLIZE_BINARY, "--list", "--weights", "zombie"}), 1);
  EXPECT_NE(output_.find("looked for zombie, "), std::string::npos) << output_;
  EXPECT_EQ(Run({STYLIZE_BINARY, "--list", "--weights", folder_ / "st-gcn"}), 1) << "a path";
}

TEST_F(ToolsTest, LicencesOfShippedWeightsTellACompanyWhatItMayUse) {
  const std::string out = folder_ / "licence.txt";
  const auto licence_of = [&](const std::string& words) {
    EXPECT_EQ(Run({"/bin/sh", "-c", std::string(STYLIZE_BINARY) + " " + words + " >" + out}), 0)
        << output_;
    return ReadText(out);
  };
  EXPECT_THAT(
      licence_of("--licence --weights v2"),
      AllOf(HasSubstr("v2.safetensors: licence CC-BY-NC-4.0, not for commercial use\n  credit: "),
            HasSubstr("Bandai Namco Research Inc."),
            HasSubstr("other weights: open.safetensors: licence CC-BY-4.0, for commercial use")));
  EXPECT_THAT(
      licence_of("--license --weights open"),
      HasSubstr(
          "  angry, elated, rushed: licence CC BY 4.0, for commercial use too if credited; credit: "
          "The 100STYLE Dataset - Ian Mason\n"));
}

// An installation without the package styled-weights-nc.
TEST_F(ToolsTest, WithoutTheDefaultWeightsThoseForCommercialUseAreTheDefault) {
  std::filesystem::create_directories(folder_ / "share/styled/weights");
  std::filesystem::create_directories(folder_ / "bin");
  std::filesystem::copy(net::FindWeights("open").value(),
                        folder_ / "share/styled/weights/open.safetensors");
  std::filesystem::copy(STYLIZE_BINARY, folder_ / "bin/stylize");
  const std::string in = Walk(), out = folder_ / "out.bvh";
  EXPECT_EQ(Run({folder_ / "bin/stylize", "--style", "zombie", in, out}), 0) << output_;
  EXPECT_EQ(Run({folder_ / "bin/stylize", "--style", "giant", in, folder_ / "none.bvh"}), 2)
      << output_;
  EXPECT_THAT(output_, HasSubstr("giant"));
}

TEST_F(ToolsTest, BadArgumentsEndWithTwoAndBadFilesWithOne) {
  const std::string in = Walk(), out = folder_ / "out.bvh";
  for (const std::vector<std::string>& wrong : std::vector<std::vector<std::string>>{
           {STYLIZE_BINARY},
           {STYLIZE_BINARY, "--no-such-option", in, out},
           {STYLIZE_BINARY, "--strength", "much", in, out},
           {STYLIZE_BINARY, "--style", "elderly", in, folder_ / "out.fbx"},
           {STYLIZE_BINARY, "--bind-only", "--style", "elderly", in, out},
           {STYLIZE_BINARY, "--bind-only", "--vary", "3", in, out},
           {STYLIZE_BINARY, "--bind-only", "--window", "whole", in, out},
           {STYLIZE_BINARY, "--bind-only", "--input-style", "elderly", in, out},
           {STYLIZE_BINARY, "--bind-only", "--strength", "0.5", in, out},
           {STYLIZE_BINARY, "--bind-only", "--no-feet", in, out},
           {STYLIZE_BINARY, "--bind-only", "--cadence", in, out},
           {STYLIZE_BINARY, "--input-style", "elderly", in, out},
           {STYLESIM_BINARY, "--rate", "0"},
           {STYLESIM_BINARY, "--performer", "a b"},
           {STYLESIM_BINARY, "--script", "fly:3"},
           {STYLESIM_BINARY, "--faults", "loss=much"},
           {STYLESIM_BINARY, "--to", "udp://127.0.0.1"},
           {STYLESIM_BINARY, "--quirk", "lz4"},
           {STYLESIM_BINARY, "--as", "rokoko", "--quirk", "t-first"},
           {STYLESIM_BINARY, "--as", "no-such-rig"},
           {STYLESIM_BINARY, "--as", "vmc", "--faults", "oversized=0.1"},
           {STYLESIM_BINARY, "--as", "vmc", "--timecode", "10:00:00"}}) {
    EXPECT_EQ(Run(wrong), 2) << testing::PrintToString(wrong);
    EXPECT_NE(output_, "");
  }
  EXPECT_EQ(Run({STYLESIM_BINARY, "--bvh", folder_ / "none.bvh"}), 1);
  EXPECT_NE(output_.find("none.bvh"), std::string::npos) << output_;
  EXPECT_EQ(Run({STYLESIM_BINARY, "--to", "tcp://127.0.0.1:1"}), 1) << "no program listens there";
  EXPECT_EQ(Run({STYLIZE_BINARY, "--style", "zombie", in, out}), 2);
  EXPECT_NE(output_.find("unknown style 'zombie'"), std::string::npos) << output_;
  EXPECT_NE(output_.find("; with --weights open there is one"), std::string::npos) << output_;
  EXPECT_EQ(Run({STYLIZE_BINARY, "--style", "nobody-has-it", in, out}), 2);
  EXPECT_EQ(output_.find("there is one"), std::string::npos) << output_;
  WriteText(in, "HIERARCHY\n");
  EXPECT_EQ(Run({STYLIZE_BINARY, "--style", "elderly", in, out}), 1);
  EXPECT_NE(output_.find(in + ":2: found the end, expected ROOT"), std::string::npos) << output_;
}

TEST_F(ToolsTest, StylizeWritesTheFormatOfTheExtension) {
  const std::string in = Walk();
  ASSERT_EQ(Run({STYLIZE_BINARY, "--style", "elderly", in, folder_ / "out.glb"}), 0) << output_;
  EXPECT_EQ(ReadText(folder_ / "out.glb").substr(0, 4), "glTF");
  EXPECT_EQ(Run({STYLIZE_BINARY, "--style", "elderly", in, folder_ / "out"}), 2);
  EXPECT_NE(output_.find("out: found no extension, expected one of .bvh, .glb"), std::string::npos)
      << output_;
}

// Without a valid rate it would flood the receiver.
TEST_F(ToolsTest, StylesimRefusesARateThatIsNoNumber) {
  EXPECT_EQ(Run({STYLESIM_BINARY, "--to", "udp://127.0.0.1:9", "--rate", "nan"}), 2);
  EXPECT_NE(output_.find("nan"), std::string::npos) << output_;
}

}  // namespace
}  // namespace styled::support
