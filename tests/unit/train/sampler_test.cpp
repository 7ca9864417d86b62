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
