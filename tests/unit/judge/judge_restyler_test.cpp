#include "model/train/judge/judge_restyler.h"

#include <gtest/gtest.h>

namespace styled::judge {
namespace {

// Lifts the hips by as many centimetres as the style's number and the noise say.
class Lifter final : public Restyler {
 public:
  bool Has(int style) const override { return style != 2; }
  Poses Restyle(std::span<const body::Pose> clip, const Target& target) const override {
    Poses out(clip.begin(), clip.end());
    const auto by = static_cast<float>(target.style + static_cast<int>(target.noise.value_or(0)));
    for (body::Pose& pose : out) pose.hips_position_m.y() += 0.01F * by;
    return out;
  }
};

TEST(Restyler, GetsClipsAtTheJudgesRateAndReturnsThemAtTheStreams) {
  Data data;
  data.manifest.styles = {
      {"neutral", {}, {}}, {"one", {}, {}}, {"absent", {}, {}}, {"three", {}, {}}};
  data.manifest.contents = {"walk"};
  data.contents = {0, 0};
  for (const std::size_t frames : {121, 123}) {  // the latter is no whole number of periods
    Poses input(frames);
    for (std::size_t i = 0; i < frames; ++i) {
      input[i].hips_position_m.z() = 0.01F * static_cast<float>(i);
    }
    data.inputs.push_back(std::move(input));
  }
  const auto out = Restyle(data, Lifter(), [](int input, int style) {
    return Target{.style = style, .references = {}, .noise = 10 * input};
  });
  ASSERT_EQ(out.size(), 4U);  // two clips in two styles
  for (const Transferred& clip : out) {
    ASSERT_EQ(clip.output.size(), clip.input.size());
    const float lifted_m = 0.01F * static_cast<float>(clip.style + 10 * clip.clip);
    for (std::size_t i = 0; i < 120; ++i) {
      EXPECT_NEAR(clip.output[i].hips_position_m.y(), 0.98F + lifted_m, 1e-4F);
      EXPECT_NEAR(clip.output[i].hips_position_m.z(), clip.input[i].hips_position_m.z(), 1e-3F);
    }
  }
  EXPECT_EQ(out[1].style, 3);
}

}  // namespace
}  // namespace styled::judge
