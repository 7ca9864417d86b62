#include "model/train/judge/restyler.h"

#include <gtest/gtest.h>

#include <set>

#include "model/feet/legs.h"
#include "model/net/load.h"
#include "model/synthetic/performer.h"
#include "model/train/judge/clip_restyler.h"
#include "model/train/judge/live_restyler.h"
#include "model/train/judge/stream.h"
#include "tests/unit/net/stgcn_causal/random_weights.h"

namespace styled::judge {
namespace {

// Lifts the hips by as many centimetres as the style's number and the noise say.
class Lifter final : public Restyler {
 public:
  double rate_hz() const override { return kJudgeRate_hz; }
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
  for (const std::size_t frames : {121, 123}) {  // the latter is not a whole number of periods
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

// A network whose code is the requested one: style, seed, weight and length of each source.
class AskedClips final : public net::ClipStylizer {
 public:
  AskedClips() { model_.styles = {{"neutral", {}}, {"odd", {}}}; }
  const net::Model& model() const noexcept override { return model_; }
  int least_frames() const noexcept override { return 4; }
  net::StyleCode MakeCode(const net::StyleRequest& request) const override {
    net::StyleCode code;
    for (const net::StyleSource& source : request.sources) {
      code.insert(code.end(),
                  {static_cast<float>(source.style), static_cast<float>(source.seed.value_or(0)),
                   source.weight, static_cast<float>(source.reference.size())});
    }
    return code;
  }
  net::NearestStyle Nearest(const net::StyleCode&) const override { return {}; }
  std::unique_ptr<net::ClipStream> MakeStream(const net::StyleCode&, int,
                                              net::Extent) const override {
    return nullptr;
  }

 private:
  net::Model model_;
};

TEST(ClipRestyler, CodesAreRequestedByMeanNoiseOrExamples) {
  // The manifest's style 2 is the network's 1; it lacks the manifest's 1.
  const ClipRestyler restyler(std::make_shared<AskedClips>(), {kAbsent, kAbsent, 1}, {}, {});
  EXPECT_FALSE(restyler.Has(1));
  EXPECT_TRUE(restyler.Has(2));
  const Poses first(70);
  const Poses second(80);
  EXPECT_EQ(restyler.CodeOf({.style = 2}), (net::StyleCode{1, 0, 1, 0}));
  EXPECT_EQ(restyler.CodeOf({.style = 2, .noise = 9}), (net::StyleCode{1, 9, 1, 0}));
  EXPECT_EQ(restyler.CodeOf({.style = 2, .references = {first, second}}),
            (net::StyleCode{1, 0, 0.5F, 70, 1, 0, 0.5F, 80}));
  EXPECT_EQ(restyler.CodeOf({.style = 2, .references = {first}, .labelled = false}),
            (net::StyleCode{-1, 0, 1, 70}));
}

TEST(LiveRestyler, GivesATargetAsTheStylistWouldPublishItsStyle) {
  const auto network = net::Parse(stgcn_causal::RandomWeights(3, 16, 1).Bytes(), "random");
  ASSERT_TRUE(network.ok()) << network.status().message();
  const Styler styler{network.value(),
                      std::make_shared<const rig::Binding>(feet::HumanoidBinding()),
                      {kAbsent, 2, kAbsent},
                      0};
  const LiveRestyler restyler(styler, {});
  EXPECT_TRUE(restyler.Has(1));
  EXPECT_FALSE(restyler.Has(0) || restyler.Has(2));
  synthetic::Performer performer({.script = {{synthetic::Motion::kWalk, 5}}});
  Poses walk(240), example(80);
  for (std::size_t i = 0; i < walk.size(); ++i) {
    performer.Pose(static_cast<double>(i) / kStreamRate_hz, walk[i]);
  }
  for (std::size_t i = 0; i < example.size(); ++i) {
    performer.Pose(static_cast<double>(i) / kJudgeRate_hz, example[i]);
  }
  const auto same = [](const Poses& a, const Poses& b) {
    bool same = a.size() == b.size();
    for (std::size_t i = 0; same && i < a.size(); ++i) {
      for (std::size_t j = 0; j < a[i].rotations.size(); ++j) {
        same = same && a[i].rotations[j].coeffs() == b[i].rotations[j].coeffs();
      }
    }
    return same;
  };
  // The network's style 2, by its number and as the mean of the manifest's style 1.
  const Switch named{.frame = 0, .settings = OneStyle(2, false)};
  const Poses expected =
      StyleStream(network.value(), styler.binding, {}, {&named, 1}, walk, kStreamRate_hz);
  EXPECT_TRUE(same(restyler.Restyle(walk, {.style = 1}), expected));
  // An example is another style, and its label counts.
  Target target{.style = 1, .references = {example}};
  const Poses told = restyler.Restyle(walk, target);
  EXPECT_FALSE(same(told, expected));
  const auto untold = Unlabelled([&](int, int) { return target; })(0, 1);
  EXPECT_FALSE(untold.labelled);
  EXPECT_FALSE(same(restyler.Restyle(walk, untold), told));
}

TEST(Targets, AreExamplesOfTheStyleAndNoiseOfItsOwn) {
  Data data;
  data.manifest.styles = {{"neutral", {}, {}}, {"long", {}, {}}, {"short", {}, {}}};
  for (const auto& [style, frames] : {std::pair{1, 30}, {1, 64}, {1, 90}, {2, 20}, {0, 100}}) {
    train::TrainingClip& clip = data.validation.emplace_back();
    clip.style = style;
    clip.poses.resize(static_cast<std::size_t>(frames));
  }
  const auto example = TargetsOf(data, CodeFrom::kReference);
  std::set<std::size_t> lengths;
  for (int input = 0; input < 40; ++input) {
    const Target target = example(input, 1);
    ASSERT_EQ(target.references.size(), 1U);
    lengths.insert(target.references[0].size());
    EXPECT_FALSE(target.noise);
    ASSERT_EQ(example(input, 2).references.size(), 1U);
    EXPECT_EQ(example(input, 2).references[0].size(), 20U) << "a short one where there is no other";
    EXPECT_EQ(target.references[0].data(), example(input, 1).references[0].data());
  }
  EXPECT_EQ(lengths, (std::set<std::size_t>{64, 90}));
  const auto noise = TargetsOf(data, CodeFrom::kNoise);
  EXPECT_EQ(*noise(3, 1).noise, *noise(3, 1).noise);
  EXPECT_NE(*noise(3, 1).noise, *noise(4, 1).noise);
  EXPECT_NE(*noise(3, 1).noise, *noise(3, 2).noise);
  EXPECT_NE(*noise(3, 1).noise, *TargetsOf(data, CodeFrom::kNoise, 2)(3, 1).noise);
  const Target mean = TargetsOf(data, CodeFrom::kMean)(0, 2);
  EXPECT_EQ(mean.style, 2);
  EXPECT_TRUE(mean.references.empty());
  EXPECT_FALSE(mean.noise);
}

}  // namespace
}  // namespace styled::judge
