#include "model/train/sampler.h"

#include <gtest/gtest.h>

#include "tests/unit/train/walker.h"

namespace styled::train {
namespace {

std::vector<TrainingClip> Clips() {
  std::vector<TrainingClip> clips;
  for (int style = 0; style < 3; ++style) {
    for (int content = 0; content < 2; ++content) {
      TrainingClip clip = Walker(80 + 40 * style);
      clip.style = style;
      clip.content = content;
      clips.push_back(clip);
    }
  }
  return clips;
}

constexpr Sampler::Options kOptions{
    .styles = 3, .contents = 2, .per_style = 2, .length = 25, .seed = 7};

TEST(Sampler, SlotsKeepTheirRolesAndWindowsFitTheirClips) {
  const std::vector<TrainingClip> clips = Clips();
  Sampler sampler(clips, kOptions);
  ASSERT_EQ(sampler.slots(), 8);
  int carried = 0;
  for (int i = 0; i < 200; ++i) {
    const auto before = i == 0 ? std::vector<Sampler::Window>(8) : sampler.Next();
    const auto windows = sampler.Next();
    for (int slot = 0; slot < 8; ++slot) {
      const Sampler::Window& w = windows[slot];
      EXPECT_EQ(clips[w.clip].style, sampler.InputStyle(slot));
      EXPECT_NE(sampler.InputStyle(slot), sampler.TargetStyle(slot));
      EXPECT_LE(w.start + 25, static_cast<int>(clips[w.clip].poses.size()));
      EXPECT_FALSE(w.carried && w.session_start);
      carried += w.carried ? 1 : 0;
    }
  }
  EXPECT_NEAR(carried, 800, 100);
}

// Style 2 was never recorded in content 1: its neutral windows are seldom of it, and are then
// marked.
TEST(Sampler, NeutralWindowsHaveContentsOfTheirTargetOrAreUnpaired) {
  std::vector<TrainingClip> clips = Clips();
  clips.pop_back();
  Sampler sampler(clips, kOptions);
  int foreign = 0, count = 0;
  for (int i = 0; i < 500; ++i) {
    const auto windows = sampler.Next();
    for (int slot = 0; slot < 8; ++slot) {
      if (sampler.TargetStyle(slot) != 2) {
        EXPECT_TRUE(windows[slot].paired);
        continue;
      }
      EXPECT_EQ(windows[slot].paired, windows[slot].content == 0);
      EXPECT_EQ(windows[slot].content, clips[windows[slot].clip].content);
      foreign += windows[slot].paired ? 0 : 1;
      ++count;
    }
  }
  EXPECT_NEAR(static_cast<double>(foreign) / count, 0.05, 0.03);
}

// One long clip in one folder, ten short ones in another: both folders are drawn alike.
TEST(Sampler, FoldersCountAlikeHoweverMuchTheyHold) {
  std::vector<TrainingClip> clips = Clips();
  for (int i = 0; i < 10; ++i) {
    TrainingClip clip = Walker(400);
    clip.source = 1;
    clips.push_back(clip);  // neutral, content 0
  }
  Sampler sampler(clips, kOptions);
  int from_first = 0;
  for (int i = 0; i < 1000; ++i) {
    Sampler::Window window = sampler.Draw(0);
    while (window.content != 0) window = sampler.Draw(0);
    from_first += clips[window.clip].source == 0 ? 1 : 0;
  }
  EXPECT_NEAR(from_first, 500, 80);
}

TEST(Sampler, AMiscalibrationLastsAsLongAsItsClip) {
  const std::vector<TrainingClip> clips = Clips();
  Sampler::Options options = kOptions;
  options.miscalibrated = 0.5;
  Sampler sampler(clips, options);
  int wrong = 0;
  std::vector<Sampler::Window> before = sampler.Next();
  for (int i = 0; i < 200; ++i) {
    const std::vector<Sampler::Window>& windows = sampler.Next();
    for (int slot = 0; slot < 8; ++slot) {
      const bool continued = windows[slot].carried && windows[slot].clip == before[slot].clip &&
                             windows[slot].start == before[slot].start + options.length;
      if (continued) EXPECT_EQ(windows[slot].miscalibration, before[slot].miscalibration);
      wrong += windows[slot].miscalibration != 0 ? 1 : 0;
    }
    before = windows;
  }
  EXPECT_NEAR(wrong, 800, 120);
}

TEST(Sampler, AnIdleWindowHoldsAFrameOfANeutralStanceOfSeconds) {
  std::vector<TrainingClip> clips = Clips();
  clips.push_back(clips[0]);
  for (int frame : {40, 45}) clips.back().poses[frame] = HandsDown();
  for (TrainingClip& clip : clips) {
    clip.still_content = 2;
    clip.still_count.assign(clip.poses.size(), 0);
  }
  Sampler::Options options = kOptions;
  options.contents = 3;
  options.idle = 0.3;
  Sampler sampler(clips, options);
  int idle = 0, neutral = 0, ended = 0, begun = 0;
  std::vector<Sampler::Window> before(8);
  for (int i = 0; i < 2000; ++i) {
    const std::vector<Sampler::Window> windows = sampler.Next();
    for (int slot = 0; slot < 8; ++slot) {
      const Sampler::Window& w = windows[slot];
      neutral += sampler.InputStyle(slot) == 0 ? 1 : 0;
      ended += before[slot].idle && !w.idle ? 1 : 0;
      if (!w.idle) continue;
      ++idle;
      EXPECT_EQ(sampler.InputStyle(slot), 0);
      EXPECT_EQ(w.clip, static_cast<int>(clips.size()) - 1);
      EXPECT_TRUE(w.start == 40 || w.start == 45) << w.start;
      EXPECT_EQ(w.content, 2);
      EXPECT_FALSE(w.paired);
      EXPECT_NE(w.carried, w.session_start);
      EXPECT_TRUE(w.carried || !before[slot].idle);
      begun += w.session_start ? 1 : 0;
    }
    before = windows;
  }
  EXPECT_NEAR(static_cast<double>(idle) / neutral, 0.3, 0.05);
  EXPECT_NEAR(static_cast<double>(idle) / ended, 10, 2);
  EXPECT_NEAR(static_cast<double>(begun) / ended, 0.5, 0.1);
}

TEST(Sampler, SaveAndRestoreAreExact) {
  const std::vector<TrainingClip> clips = Clips();
  Sampler sampler(clips, kOptions);
  for (int i = 0; i < 5; ++i) sampler.Next();
  Sampler other(clips, kOptions);
  other.Restore(sampler.Save());
  for (int i = 0; i < 5; ++i) {
    sampler.Next();
    other.Next();
    EXPECT_EQ(sampler.Save(), other.Save());
  }
}

// Style 2 was never recorded in content 1, and content 1 of style 1 has twice the windows.
TEST(Sampler, PairsAreOfOneContentAndEachTheOthersTarget) {
  std::vector<TrainingClip> clips = Clips();
  clips.pop_back();
  clips.push_back(clips[3]);
  Sampler::Options options = kOptions;
  options.pairs = 3;
  Sampler sampler(clips, options);
  ASSERT_EQ(sampler.slots(), 6);
  std::array<int, 4> count{};  // by style and content: 1/0, 1/1, 2/0, 2/1
  for (int i = 0; i < 2000; ++i) {
    const std::vector<Sampler::Window>& windows = sampler.Next();
    ASSERT_EQ(windows.size(), 6U);
    for (std::size_t pair = 0; pair < 6; pair += 2) {
      const Sampler::Window& neutral = windows[pair];
      const Sampler::Window& styled = windows[pair + 1];
      EXPECT_EQ(clips[neutral.clip].style, 0);
      EXPECT_EQ(neutral.style, 0);
      EXPECT_EQ(styled.target, 0);
      EXPECT_EQ(clips[styled.clip].style, styled.style);
      EXPECT_EQ(neutral.target, styled.style);
      EXPECT_EQ(neutral.content, styled.content);
      EXPECT_EQ(clips[styled.clip].content, styled.content);
      EXPECT_TRUE(neutral.paired && styled.paired && !styled.carried && !neutral.mirrored);
      ++count[static_cast<std::size_t>(2 * (styled.style - 1) + styled.content)];
    }
  }
  // Windows: 120 - 24 of each clip of style 1, 160 - 24 of style 2.
  const double all = 96 + 2 * 96 + 136;
  EXPECT_NEAR(count[0], 6000 * 96 / all, 150);
  EXPECT_NEAR(count[1], 6000 * 192 / all, 150);
  EXPECT_NEAR(count[2], 6000 * 136 / all, 150);
  EXPECT_EQ(count[3], 0);

  Sampler resumed(clips, options);
  resumed.Restore(sampler.Save());
  const std::vector<Sampler::Window>& next = sampler.Next();
  const std::vector<Sampler::Window>& same = resumed.Next();
  for (std::size_t i = 0; i < next.size(); ++i) {
    EXPECT_EQ(next[i].clip, same[i].clip);
    EXPECT_EQ(next[i].start, same[i].start);
  }
}

}  // namespace
}  // namespace styled::train
