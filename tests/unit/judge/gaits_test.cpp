#include "model/train/judge/gaits.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "model/feet/legs.h"
#include "model/net/load.h"
#include "model/synthetic/performer.h"
#include "model/train/judge/gait_stream.h"
#include "model/train/judge/unseen_live.h"
#include "tests/unit/judge/arm_network.h"
#include "tests/unit/net/stgcn_causal/random_weights.h"
#include "tests/unit/train/walker.h"

namespace styled::judge {
namespace {

const std::vector<std::string> kContents{"walk", "run", "dash", "bow"};
enum Content { kWalk, kRun, kDash, kBow };

// Each frame's place along z is its number.
train::TrainingClip GaitClip(int style, Content content, int frames) {
  train::TrainingClip clip = train::Walker(frames);
  clip.style = style;
  clip.content = content;
  for (int i = 0; i < frames; ++i) {
    clip.poses[static_cast<std::size_t>(i)].hips_position_m.z() = static_cast<float>(i);
  }
  return clip;
}

std::pair<int, int> Range(const Poses& poses) {
  if (poses.empty()) return {0, 0};
  return {static_cast<int>(poses.front().hips_position_m.z()),
          static_cast<int>(poses.back().hips_position_m.z()) + 1};
}
using Ranges = std::vector<std::pair<int, int>>;

Ranges JudgesOf(const GaitParts& parts, int style, Content content) {
  Ranges ranges;
  for (const train::TrainingClip& clip : parts.judges) {
    if (clip.style == style && clip.content == content) ranges.push_back(Range(clip.poses));
  }
  return ranges;
}
Ranges RealOf(const GaitParts& parts, int style, Content content) {
  Ranges ranges;
  for (const RealPart& part : parts.real) {
    const bool of_content = part.content == kContents[content];
    if (part.style == style && of_content) ranges.push_back(Range(part.poses));
  }
  return ranges;
}

GaitParts Split(const std::vector<train::TrainingClip>& clips, const GaitSplitting& splitting) {
  return SplitGaits(clips, 2, kContents, splitting);
}

TEST(Gaits, AWalkIsExampleJudgesPartAndRealPartAndFoldsExchangeTheLatter) {
  const std::vector<train::TrainingClip> clips{GaitClip(1, kWalk, 200), GaitClip(1, kBow, 50)};
  const GaitParts one = Split(clips, {.fold = 0});
  EXPECT_EQ(Range(one.examples[1][0]), std::pair(0, 90));
  EXPECT_EQ(JudgesOf(one, 1, kWalk), (Ranges{{90, 145}}));
  EXPECT_EQ(RealOf(one, 1, kWalk), (Ranges{{145, 200}}));
  EXPECT_EQ(Range(one.wanted[1][0]), std::pair(0, 90));
  const GaitParts two = Split(clips, {.fold = 1});
  EXPECT_EQ(Range(two.examples[1][0]), std::pair(0, 90));
  EXPECT_EQ(JudgesOf(two, 1, kWalk), (Ranges{{145, 200}}));
  EXPECT_EQ(RealOf(two, 1, kWalk), (Ranges{{90, 145}}));
  for (const GaitParts* parts : {&one, &two}) {
    EXPECT_EQ(JudgesOf(*parts, 1, kBow), (Ranges{{0, 50}})) << "not a gait";
    EXPECT_TRUE(RealOf(*parts, 1, kBow).empty());
  }
}

TEST(Gaits, AThirdOfALongWalkIsTheExample) {
  const GaitParts parts = Split({GaitClip(1, kWalk, 480)}, {});
  EXPECT_EQ(Range(parts.examples[1][0]), std::pair(0, 160));
  EXPECT_EQ(JudgesOf(parts, 1, kWalk), (Ranges{{160, 320}}));
}

TEST(Gaits, ARestTooShortForTwoPartsIsTheJudgesOrReal) {
  const std::vector<train::TrainingClip> clips{GaitClip(1, kWalk, 143)};
  const GaitParts one = Split(clips, {.fold = 0});
  EXPECT_EQ(JudgesOf(one, 1, kWalk), (Ranges{{90, 143}}));
  EXPECT_TRUE(RealOf(one, 1, kWalk).empty());
  const GaitParts two = Split(clips, {.fold = 1});
  EXPECT_TRUE(JudgesOf(two, 1, kWalk).empty());
  EXPECT_EQ(RealOf(two, 1, kWalk), (Ranges{{90, 143}}));
  // Not a window is left.
  const GaitParts none = Split({GaitClip(1, kWalk, 120)}, {});
  EXPECT_TRUE(JudgesOf(none, 1, kWalk).empty());
  EXPECT_EQ(Range(none.examples[1][0]), std::pair(0, 90));
}

TEST(Gaits, RunsAndDashesHaveNoExampleUnlessTheRunIsOne) {
  const std::vector<train::TrainingClip> clips{GaitClip(1, kRun, 80), GaitClip(1, kDash, 70)};
  const GaitParts one = Split(clips, {.fold = 0});
  EXPECT_TRUE(one.examples[1][1].empty());
  EXPECT_EQ(JudgesOf(one, 1, kRun), (Ranges{{0, 40}}));
  EXPECT_EQ(RealOf(one, 1, kRun), (Ranges{{40, 80}}));
  EXPECT_EQ(JudgesOf(one, 1, kDash), (Ranges{{0, 35}}));
  EXPECT_EQ(RealOf(one, 1, kDash), (Ranges{{35, 70}}));
  EXPECT_EQ(Range(one.wanted[1][1]), std::pair(0, 40));
  EXPECT_EQ(Range(Split(clips, {.fold = 1}).wanted[1][1]), std::pair(40, 80));
  const GaitParts both = Split(clips, {.example_runs = true});
  EXPECT_EQ(Range(both.examples[1][1]), std::pair(0, 80));
  EXPECT_EQ(Range(both.wanted[1][1]), std::pair(0, 80));
  EXPECT_TRUE(JudgesOf(both, 1, kRun).empty());
  EXPECT_TRUE(RealOf(both, 1, kRun).empty());
  EXPECT_EQ(JudgesOf(both, 1, kDash), (Ranges{{0, 35}}));
}

// The control of the protocol: only with the leak do the judges see a frame of an example.
TEST(Gaits, TheJudgesSeeAnExampleOnlyWithALeakAndNeverARealPart) {
  const std::vector<train::TrainingClip> clips{GaitClip(0, kWalk, 195), GaitClip(1, kWalk, 200),
                                               GaitClip(1, kRun, 100), GaitClip(1, kDash, 70)};
  const auto overlaps = [](const GaitParts& parts, Content content, std::pair<int, int> with) {
    const Ranges seen = JudgesOf(parts, 1, content);
    return std::any_of(seen.begin(), seen.end(), [&](const auto& range) {
      return range.first < with.second && with.first < range.second;
    });
  };
  for (const int fold : {0, 1}) {
    for (const bool leak : {false, true}) {
      for (const bool runs : {false, true}) {
        const GaitParts parts = Split(clips, {.fold = fold, .leak = leak, .example_runs = runs});
        EXPECT_EQ(overlaps(parts, kWalk, Range(parts.examples[1][0])), leak);
        if (runs) EXPECT_EQ(overlaps(parts, kRun, Range(parts.examples[1][1])), leak);
        for (const Content content : {kWalk, kRun, kDash}) {
          for (const auto& real : RealOf(parts, 1, content)) {
            EXPECT_FALSE(overlaps(parts, content, real));
          }
        }
        EXPECT_EQ(JudgesOf(parts, 0, kWalk), (Ranges{{0, 195}})) << "all of neutral";
        EXPECT_EQ(Range(parts.examples[0][0]), std::pair(0, 195));
      }
    }
  }
}

TEST(Gaits, APartKeepsTheStateOfItsFrames) {
  const train::TrainingClip clip = GaitClip(1, kRun, 50);
  const train::TrainingClip part = Cut(clip, 10, 25);
  ASSERT_EQ(part.poses.size(), 15U);
  ASSERT_EQ(part.heading_cos.size(), 15U);
  EXPECT_EQ(part.heading_cos[3], clip.heading_cos[13]);
  EXPECT_EQ(part.heading_sin[3], clip.heading_sin[13]);
  EXPECT_TRUE(part.still_count.empty());
  EXPECT_EQ(part.content, kRun);
}

Poses Moving(float speed_mps, int frames) {
  Poses poses = train::Walker(frames).poses;
  for (int i = 0; i < frames; ++i) {
    body::Vec3& hips = poses[static_cast<std::size_t>(i)].hips_position_m;
    hips = body::Vec3(0.6F, 0, 0.8F) * (speed_mps * static_cast<float>(i) / 30.0F);
  }
  return poses;
}

TEST(Gaits, SpeedTellsRunsFromWalks) {
  EXPECT_EQ(GaitOf(Moving(1.4F, 60)), GaitKind::kWalk);
  EXPECT_EQ(GaitOf(Moving(3.0F, 60)), GaitKind::kRun);
  EXPECT_EQ(GaitOf({}), GaitKind::kWalk);
}

TEST(Gaits, TheNeutralIsOfAnotherClipOfThePersonOfTheSameGaitIfThereIsOne) {
  const auto walk = [](const char* person, int frames) {
    return GaitSource{"", person, GaitKind::kWalk, Poses(static_cast<std::size_t>(frames))};
  };
  const auto run = [](const char* person, int frames) {
    return GaitSource{"", person, GaitKind::kRun, Poses(static_cast<std::size_t>(frames))};
  };
  const std::vector<GaitSource> sources{walk("a", 10), run("a", 20),  walk("b", 40),
                                        walk("a", 80), run("b", 160), walk("c", 320)};
  EXPECT_EQ(NeutralSourceOf(sources, 0), 3);
  EXPECT_EQ(NeutralSourceOf(sources, 3), 0);
  EXPECT_EQ(NeutralSourceOf(sources, 1), 3) << "no other run";
  EXPECT_EQ(NeutralSourceOf(sources, 2), 4);
  EXPECT_EQ(NeutralSourceOf(sources, 5), -1);
  EXPECT_EQ(MeanNeutralOf(sources, 0).size(), 80U);
  EXPECT_EQ(MeanNeutralOf(sources, 1).size(), 90U);
  EXPECT_EQ(MeanNeutralOf(sources, 2).size(), 160U) << "no other walk";
  EXPECT_TRUE(MeanNeutralOf(sources, 5).empty());
}

TEST(Gaits, AnOutputLikeTheExampleHasNoDistanceAndAnUnstyledOneHasOne) {
  const Poses input = train::Walker(120).poses;
  Poses wanted = input;
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    wanted[i].rotations[body::kLeftUpperArm] = Arm(std::sin(0.4F * static_cast<float>(i)));
  }
  Recognition recognition;
  recognition.style.Add(1);
  recognition.style.Add(0);
  const GaitFigures same = MeasureGaitOutput(input, wanted, wanted, recognition);
  EXPECT_NEAR(same.movement.value(), 0, 1e-6);
  EXPECT_GT(same.jerk.value(), 1.05);
  EXPECT_EQ(same.recognized.value(), 0.5);
  EXPECT_EQ(same.recognized.count, 1) << "a clip counts once";
  EXPECT_EQ(same.moves.count, 0) << "no window";
  const GaitFigures none = MeasureGaitOutput(input, input, wanted, {});
  EXPECT_NEAR(none.movement.value(), 1, 1e-6);
  EXPECT_NEAR(none.jerk.value(), 1, 1e-6);
  EXPECT_EQ(MeasureGaitOutput(input, input, {}, {}).movement.count, 0);
  const RealPart real{1, GaitKind::kWalk, "walk", input};
  const double unchanged_m = MovementDistance_m(input, wanted);
  EXPECT_NEAR(MeasureReal(real, wanted, 2 * unchanged_m, {}).movement.value(), 0.5, 1e-6);
  EXPECT_EQ(MeasureReal(real, wanted, 0, {}).movement.count, 0);
}

TEST(Gaits, AStyleCountsOnceHoweverManyClipsItHas) {
  GaitTable table(4);
  for (int i = 0; i < 3; ++i) table[1][0].recognized.Add(1);
  table[2][0].recognized.Add(0);
  table[2][1].recognized.Add(0.2);
  const PerGait<GaitFigures> gaits = OverStyles(table);
  EXPECT_NEAR(gaits[0].recognized.value(), 0.5, 1e-9);
  EXPECT_EQ(gaits[0].recognized.count, 2) << "the fourth style was not measured";
  EXPECT_NEAR(gaits[1].recognized.value(), 0.2, 1e-9);
  EXPECT_NEAR(OverGaits(gaits).recognized.value(), 0.35, 1e-9);
  EXPECT_EQ(OverGaits(gaits).jerk.count, 0);
}

TEST(Gaits, AClipLedInByItselfIsTheSameMotion) {
  const Poses clip = train::Walker(150).poses;
  const LedIn led = WithLeadIn(clip, 3);
  EXPECT_EQ(led.begin, 90U);
  ASSERT_EQ(led.poses.size(), 240U);
  const auto knee = [](const body::Pose& pose) { return pose.rotations[body::kLeftLowerLeg]; };
  for (const std::size_t i : {kSettling, clip.size() - 1}) {
    EXPECT_LT(body::Log(knee(led.poses[led.begin + i]).conjugate() * knee(clip[i])).norm(), 1e-4F);
  }
  const auto step_m = [](const Poses& poses, std::size_t i) {
    return (poses[i].hips_position_m - poses[i - 1].hips_position_m).norm();
  };
  EXPECT_NEAR(step_m(led.poses, led.begin + 60), step_m(clip, 60), 1e-4F);
  EXPECT_EQ(WithLeadIn(Poses(10), 3).begin, 0U) << "too short for a blend";
}

// A performer who stoops, walking: what is known of it when a clip begins, and what is not.
TEST(Gaits, AKnownNeutralIsInEffectFromTheFirstFrameAndStays) {
  const auto network = net::Load(STYLED_SHIPPED "/graph.safetensors");
  ASSERT_TRUE(network.ok()) << network.status().message();
  const Styler styler{
      network.value(), std::make_shared<const rig::Binding>(feet::HumanoidBinding()), {}, 0};
  synthetic::Performer performer({.script = {{synthetic::Motion::kWalk, 5}}});
  Poses walk(480);
  for (std::size_t i = 0; i < walk.size(); ++i) {
    performer.Pose(static_cast<double>(i) / kStreamRate_hz, walk[i]);
    walk[i].rotations[body::kSpine] = body::Exp(body::Vec3(0.3F, 0, 0));
  }
  const LiveRestyler restyler(styler, {});
  const neutral::Known known = restyler.Calibrated(walk);
  EXPECT_TRUE(known.calibrated);
  EXPECT_GT(known.body_s, 1);
  net::StyleRequest request;
  request.sources.push_back({.style = 1, .seed = {}, .reference = {}, .weight = 1});
  const net::StyleCode code = styler.network->space()->MakeCode(request);
  const auto apart = [&](const Poses& a, const Poses& b, std::size_t frame) {
    float most = 0;
    for (int joint = 0; joint < body::kJointCount; ++joint) {
      const auto& from = a[frame].rotations[joint];
      most = std::max(most, body::Log(from.conjugate() * b[frame].rotations[joint]).norm());
    }
    return most;
  };
  const Poses told = restyler.RestyleBy(walk, code, &known);
  const Poses untold = restyler.RestyleBy(walk, code);
  EXPECT_GT(apart(told, untold, 40), 0.02F) << "at first";
  EXPECT_LT(apart(told, untold, 479), 0.5F * apart(told, untold, 40)) << "learned later";
  stylist::Options mean;
  mean.neutral = false;
  const LiveRestyler without(styler, mean);
  EXPECT_FALSE(without.Calibrated(walk).calibrated) << "there is none to learn";
  EXPECT_EQ(apart(without.RestyleBy(walk, code, &known), without.RestyleBy(walk, code), 40), 0);
}

// The same frames are judged whatever is known.
TEST(Gaits, AStreamGivesTheSameFramesWhateverIsKnown) {
  const auto network = net::Parse(stgcn_causal::RandomWeights(3, 16, 1).Bytes(), "random");
  ASSERT_TRUE(network.ok()) << network.status().message();
  const Styler styler{
      network.value(), std::make_shared<const rig::Binding>(feet::HumanoidBinding()), {}, 0};
  const std::vector<GaitSource> sources{{"", "a", GaitKind::kWalk, train::Walker(110).poses},
                                        {"", "a", GaitKind::kWalk, train::Walker(120).poses}};
  const net::StyleCode code = network.value()->space()->MakeCode({});
  for (const auto known :
       {NeutralKnown::kCalibrated, NeutralKnown::kLearned, NeutralKnown::kMean}) {
    const InAndOut clip = GaitStream(styler, sources, known).Style(0, code);
    ASSERT_EQ(clip.input.size(), 110 - kSettling);
    ASSERT_EQ(clip.output.size(), clip.input.size());
    const auto& from = sources[0].poses[kSettling + 5].rotations[body::kLeftFoot];
    EXPECT_LT(body::Log(from.conjugate() * clip.input[5].rotations[body::kLeftFoot]).norm(), 1e-4F);
  }
}

}  // namespace
}  // namespace styled::judge
