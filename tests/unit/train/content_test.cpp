// The content input of Style-ERD's generator: label, learned initial states, recognizer.
#include <gtest/gtest.h>

#include "model/train/erd/batch.h"
#include "model/train/erd/networks.h"

namespace styled::train::style_erd {
namespace {

using torch::Tensor;

constexpr int64_t kStyles = 3, kContents = 2, kWindowFrames = 6;

GeneratorShape ShapeWith(int64_t contents) {
  GeneratorShape shape;
  shape.styles = kStyles;
  shape.contents = contents;
  return shape;
}

Generator MakeGenerator(int64_t contents) {
  torch::manual_seed(5);
  return {ShapeWith(contents), torch::zeros({erd::kFeatureCount}),
          torch::ones({erd::kFeatureCount})};
}

// Any windows, in any order of styles; their content input is zeros, unless it is set.
struct Example {
  Tensor u = torch::randn({kWindowFrames, 4, erd::kFeatureCount});
  Slots slots = PlacedSlots({0, 2, 1, 0}, {2, 0, 0, 1}, kStyles);
  ContentInput content{torch::zeros({kWindowFrames, 4, kContents}),
                       torch::full({4}, kContents, torch::kInt64)};
  Tensor goes_on = torch::zeros({4}, torch::kBool);

  Decoded Run(const Generator& generator) const {
    const torch::NoGradGuard no_grad;
    Carried carried = generator.Start(slots);
    return generator.Transfer(u, slots, generator.shape.contents > 0 ? content : ContentInput{},
                              goes_on, carried);
  }
};

TEST(ContentInputTest, PlacedWindowsGoThroughTheirBranches) {
  const Generator generator = MakeGenerator(0);
  const Example example;
  const Tensor placed = example.Run(generator).rotations;
  // By itself, each window's branch is the one of the style that is not neutral.
  for (int64_t i = 0; i < 4; ++i) {
    const torch::NoGradGuard no_grad;
    const Tensor u = example.u.narrow(1, i, 1);
    const Tensor in = example.slots.input_one_hot.narrow(0, i, 1);
    const Tensor out = example.slots.target_one_hot.narrow(0, i, 1);
    const int64_t branch = (example.slots.input + example.slots.target)[i].item<int64_t>() - 1;
    const Tensor z = generator.Encode(u, in, {});
    StackState neutral = generator.neutral.Initial(1), branches = generator.branches.Initial(1);
    const Tensor r0 = generator.Neutral(z, neutral);
    const Tensor all = generator.Branches(z.repeat({1, kStyles - 1, 1}), branches);
    const Tensor residual = all.narrow(1, branch, 1);
    const bool styled = example.slots.input[i].item<int64_t>() > 0;
    const Tensor rec = generator.Decode(styled ? r0 + residual : r0, in).rotations;
    const Tensor sty = generator.Decode(styled ? r0 : r0 + residual, out).rotations;
    EXPECT_TRUE(torch::allclose(placed.narrow(1, i, 1), rec, 1e-5, 1e-6)) << "window " << i;
    EXPECT_TRUE(torch::allclose(placed.narrow(1, 4 + i, 1), sty, 1e-5, 1e-6)) << "window " << i;
  }
}

TEST(ContentInputTest, LabelAndInitialStateChangeTheOutputOfTheirWindowAlone) {
  const Generator generator = MakeGenerator(kContents);
  Example example;
  const Tensor unknown = example.Run(generator).rotations;
  example.content.content.select(1, 1).select(1, 0).fill_(1);
  const Tensor labelled = example.Run(generator).rotations;
  example.content.content.zero_();
  example.content.start[1] = 0;
  const Tensor started = example.Run(generator).rotations;
  for (const Tensor& changed : {labelled, started}) {
    for (int64_t i = 0; i < 8; ++i) {
      const bool same = torch::equal(changed.select(1, i), unknown.select(1, i));
      EXPECT_EQ(same, i % 4 != 1) << "window " << i;
    }
  }
  EXPECT_FALSE(torch::equal(labelled, started));
}

// The loss of a window that starts from content 1 reaches that row of the initial states alone.
TEST(ContentInputTest, InitialStatesOfTheContentLearn) {
  const Generator generator = MakeGenerator(kContents);
  Example example;
  example.content.start.fill_(1);
  Carried carried = generator.Start(example.slots);
  const Decoded out =
      generator.Transfer(example.u, example.slots, example.content, example.goes_on, carried);
  out.velocities.square().sum().backward();
  for (const Tensor& h0 : generator.neutral.h0) {
    EXPECT_GT(h0.grad()[1].abs().sum().item<double>(), 0);
    EXPECT_EQ(h0.grad()[0].abs().sum().item<double>(), 0);
    EXPECT_EQ(h0.grad()[2].abs().sum().item<double>(), 0);
  }
}

TEST(ContentInputTest, TheRecognizerIsCausal) {
  const torch::NoGradGuard no_grad;
  const Generator generator = MakeGenerator(kContents);
  Tensor u = torch::randn({kWindowFrames, 2, erd::kFeatureCount});
  StackState state = generator.recognizer.Initial(2);
  const Tensor before = generator.Recognize(u, state);
  ASSERT_EQ(before.sizes(), torch::IntArrayRef({kWindowFrames, 2, kContents}));
  u = u.clone();
  u[4].zero_();
  state = generator.recognizer.Initial(2);
  const Tensor after = generator.Recognize(u, state);
  EXPECT_TRUE(torch::equal(before.narrow(0, 0, 4), after.narrow(0, 0, 4)));
  EXPECT_FALSE(torch::equal(before[4], after[4]));
  EXPECT_FALSE(torch::equal(before[5], after[5])) << "it remembers";
}

// Weights without contents give a generator that ignores them at first.
TEST(ContentInputTest, AGeneratorWithoutContentsCanBeGivenSome) {
  const Generator from = MakeGenerator(0);
  Generator to = MakeGenerator(kContents);
  ASSERT_TRUE(to.CopyStyles(from, {0, 1, 2}).ok());
  Example example;
  const Tensor expected = example.Run(from).rotations;
  example.content.content.fill_(0.5);
  example.content.start[2] = 0;
  EXPECT_TRUE(torch::allclose(example.Run(to).rotations, expected, 1e-6, 1e-6));
}

}  // namespace
}  // namespace styled::train::style_erd
