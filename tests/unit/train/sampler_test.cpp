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
      EXPECT_EQ(clips[w.clip].style, sampler.OwnStyle(slot));
      EXPECT_NE(sampler.OwnStyle(slot), sampler.TargetStyle(slot));
      EXPECT_LE(w.start + 25, static_cast<int>(clips[w.clip].poses.size()));
      EXPECT_FALSE(w.carried && w.session_start);
      carried += w.carried ? 1 : 0;
    }
  }
  EXPECT_NEAR(carried, 800, 100);
}

// Style 2 was never recorded in content 1: its neutral windows seldom are of it, and then say so.
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

}  // namespace
}  // namespace styled::train
