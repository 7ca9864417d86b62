// Network::Step compared with a scalar double-precision network written from FORMAT.md's equations;
// and its guarantees about styles, determinism and hostile input.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/unit/net/kernels/each_target.h"
#include "tests/unit/net/stgcn_causal/reference.h"

namespace styled::stgcn_causal {
namespace {

using net::StyleWeight;
using Styles = std::vector<StyleWeight>;

double Difference(const Features& a, const Doubles& b) {
  double largest = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const double apart = std::abs(static_cast<double>(a[i]) - b[i]);
    if (!(apart <= largest)) largest = apart;
  }
  return largest;
}
double Difference(const Features& a, const Features& b) {
  return Difference(a, Doubles(b.begin(), b.end()));
}
double Difference(const Output& a, const Output& b) {
  return std::max(Difference(a.reconstruction, b.reconstruction), Difference(a.styled, b.styled));
}

// The sizes of the network and its state.
bool AllFinite(const State& state) {
  bool finite = std::isfinite(state.count);
  for (std::size_t i = 0; i < state.memory.size(); ++i) {
    finite = finite && std::isfinite(state.memory.data()[i]);
  }
  return finite;
}
bool AllFinite(const Output& out) {
  bool finite = true;
  for (const float value : out.reconstruction) finite = finite && std::isfinite(value);
  for (const float value : out.styled) finite = finite && std::isfinite(value);
  return finite;
}

std::vector<Features> Walk(int frames) { return stgcn::WalkFeatures(frames, {}); }

// float32 against double, in metres and quaternion components; measured: 1e-6
constexpr double kTolerance = 5e-6;

struct Command {
  int from_frame;
  int input_style;
  Styles active;
};

struct StepAgainstReference : testing::Test {
  // Runs the reference and the network of every SIMD target through `commands` for `frames`;
  // returns the largest difference of any output.
  double CompareThrough(const std::vector<Command>& commands, int frames) {
    struct Run {
      std::shared_ptr<const Network> network;
      State state;
    };
    std::vector<Run> runs;
    net::OnEachTarget([&] {
      const auto network = CausalNetwork(file);
      runs.push_back({network, network->MakeState()});
    });
    EXPECT_FALSE(runs.empty());
    const std::vector<Features> walk = stgcn::WalkFeatures(frames, runs[0].network->features());
    Reference reference(of_reference.tensors.empty() ? file : of_reference);
    double largest = 0;
    std::size_t command = 0;
    for (int frame = 0; frame < frames; ++frame) {
      while (command + 1 < commands.size() && commands[command + 1].from_frame <= frame) ++command;
      const Command& now = commands[command];
      std::map<int, double> active;
      for (const StyleWeight& style : now.active) active[style.style] = style.weight;
      const Features& features = walk[static_cast<std::size_t>(frame)];
      const Reference::Output expected = reference.Step(features, now.input_style, active);
      for (Run& run : runs) {
        Output out;
        run.network->Step(features, now.input_style, now.active, run.state, out);
        largest = std::max({largest, Difference(out.reconstruction, expected.reconstruction),
                            Difference(out.styled, expected.styled)});
      }
    }
    RecordProperty("largest", std::to_string(largest));
    return largest;
  }

  WeightsFile file = RandomWeights(6, 16, 1);
  WeightsFile of_reference;  // no tensors: file
};

TEST_F(StepAgainstReference, NeutralAlone) {
  EXPECT_LT(CompareThrough({{0, 0, {}}}, 120), kTolerance);
}

TEST_F(StepAgainstReference, OneStyle) {
  EXPECT_LT(CompareThrough({{0, 0, {{2, 1.0F}}}}, 200), kTolerance);
}

TEST_F(StepAgainstReference, PartialStrengthLeavesAShareToNeutral) {
  EXPECT_LT(CompareThrough({{0, 0, {{2, 0.4F}}}}, 60), kTolerance);
}

TEST_F(StepAgainstReference, StrengthAboveOneExtrapolates) {
  EXPECT_LT(CompareThrough({{0, 0, {{1, 0.8F}, {3, 0.7F}}}}, 60), kTolerance);
}

TEST_F(StepAgainstReference, TheSumOfWeightsIsLimited) {
  EXPECT_LT(CompareThrough({{0, 0, {{1, 1.5F}, {3, 1.2F}, {4, 0.6F}}}}, 60), kTolerance);
}

TEST_F(StepAgainstReference, AStyleBeginsMixesEndsAndBeginsAnew) {
  file.metadata["memory"] = 5;  // after 40 frames the second decoder follows again
  EXPECT_LT(CompareThrough({{0, 0, {}},
                            {20, 0, {{1, 1.0F}}},
                            {40, 0, {{1, 0.3F}, {5, 0.1F}, {2, 0.2F}, {4, 0.25F}}},
                            {60, 0, {{2, 1.0F}}},
                            {80, 0, {{2, 0.0F}}},  // it ends; continues alone up to frame 119
                            {90, 0, {}},
                            {130, 0, {{3, 1.0F}, {1, 0.2F}}},
                            {150, 0, {}},
                            {160, 0, {{4, 1.0F}}}},  // before it follows again
                           180),
            kTolerance);
}

TEST_F(StepAgainstReference, StyledInput) {
  EXPECT_LT(CompareThrough({{0, 3, {}},                       // to neutral
                            {30, 3, {{1, 1.0F}}},             // to another style
                            {60, 3, {{3, 0.6F}, {1, 0.4F}}},  // 3 is in the mix, too
                            {90, 0, {{1, 0.5F}}}},
                           120),
            kTolerance);
}

TEST_F(StepAgainstReference, OtherSpacingsAndMemories) {
  file.metadata["spacing"] = {1, 3, 7, 2};
  file.metadata["memory"] = 9;
  file.metadata["start_frames"] = 40;
  EXPECT_LT(CompareThrough({{0, 0, {{2, 1.0F}}}}, 80), kTolerance);
}

TEST_F(StepAgainstReference, AWiderNetwork) {
  file = RandomWeights(3, 48, 2);
  EXPECT_LT(CompareThrough({{0, 0, {{2, 1.0F}}}}, 30), kTolerance);
}

TEST_F(StepAgainstReference, StatisticsThatStartWithoutVarianceAreNotDividedByZero) {
  for (net::NamedTensor& tensor : file.tensors) {
    if (tensor.name.ends_with(".start_square")) tensor.values.assign(tensor.values.size(), -0.1F);
  }
  EXPECT_LT(CompareThrough({{0, 0, {{2, 1.0F}}}}, 30), 50 * kTolerance);
}

// The comparison's negative controls: a reference that differs in one place.
TEST_F(StepAgainstReference, AnotherSpacingIsSeen) {
  of_reference = file;
  of_reference.metadata["spacing"] = {2, 4, 2, 2};
  EXPECT_GT(CompareThrough({{0, 0, {}}}, 30), 100 * kTolerance);
}

TEST_F(StepAgainstReference, AnotherMemoryIsSeen) {
  of_reference = file;
  of_reference.metadata["memory"] = 22;
  EXPECT_GT(CompareThrough({{0, 0, {}}}, 30), 100 * kTolerance);
}

TEST_F(StepAgainstReference, AnotherStartIsSeen) {
  of_reference = file;
  of_reference.tensor("g.dec2.adain2.start_mean").values[3] += 0.3F;
  EXPECT_GT(CompareThrough({{0, 0, {}}}, 30), 20 * kTolerance);
}

TEST_F(StepAgainstReference, AnotherTapIsSeen) {
  of_reference = file;
  std::vector<float>& weight = of_reference.tensor("g.enc2.tconv1.weight").values;
  for (std::size_t i = 0; i < weight.size(); i += 3) std::swap(weight[i], weight[i + 1]);
  EXPECT_GT(CompareThrough({{0, 0, {}}}, 30), 100 * kTolerance);
}

struct Step : testing::Test {
  // The outputs of a stream that starts in `state`.
  std::vector<Output> Run(State& state, int begin, int end, const Styles& active,
                          int input_style = 0) const {
    std::vector<Output> all;
    for (int frame = begin; frame < end; ++frame) {
      network->Step(walk[static_cast<std::size_t>(frame)], input_style, active, state,
                    all.emplace_back());
    }
    return all;
  }
  Output First(const Styles& active, int input_style = 0) const {
    State state = network->MakeState();
    return Run(state, 0, 1, active, input_style)[0];
  }

  std::shared_ptr<const Network> network = CausalNetwork(RandomWeights(16, 16, 3));
  std::vector<Features> walk = Walk(400);
};

TEST_F(Step, TwoRunsAreBitIdentical) {
  State one = network->MakeState(), two = network->MakeState();
  for (const Styles& active : {Styles{}, Styles{{1, 0.9F}, {3, 0.2F}}, Styles{{2, 1.0F}}}) {
    const auto first = Run(one, 0, 40, active), second = Run(two, 0, 40, active);
    for (std::size_t i = 0; i < first.size(); ++i) EXPECT_EQ(Difference(first[i], second[i]), 0);
  }
}

TEST_F(Step, ACopiedStateGoesOnAlike) {
  const Styles active{{1, 0.5F}, {2, 0.5F}};
  State state = network->MakeState();
  Run(state, 0, 15, {});
  Run(state, 15, 40, active);
  State copy = state;
  const auto expected = Run(state, 40, 80, active), found = Run(copy, 40, 80, active);
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_EQ(Difference(expected[i], found[i]), 0) << i;
  }
}

TEST_F(Step, AStartedStateIsAsANewOne) {
  const Styles active{{1, 1.0F}};
  State used = network->MakeState(), fresh = network->MakeState();
  Run(used, 100, 200, {{5, 1.0F}}, 2);
  network->Start(used);
  for (const Styles& now : {Styles{}, active}) {
    const auto found = Run(used, 0, 30, now), expected = Run(fresh, 0, 30, now);
    for (std::size_t i = 0; i < found.size(); ++i) {
      EXPECT_EQ(Difference(found[i], expected[i]), 0) << i;
    }
  }
}

TEST_F(Step, WithoutAStyleStyledIsTheReconstruction) {
  State none = network->MakeState(), zero = network->MakeState();
  const auto expected = Run(none, 0, 30, {}), found = Run(zero, 0, 30, {{1, 0.0F}});
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_EQ(Difference(expected[i].styled, expected[i].reconstruction), 0);
    EXPECT_EQ(Difference(found[i], expected[i]), 0);
  }
}

TEST_F(Step, TheReconstructionDoesNotDependOnTheStyle) {
  State none = network->MakeState(), styled = network->MakeState();
  Run(none, 0, 20, {});
  Run(styled, 0, 20, {});
  const auto expected = Run(none, 20, 60, {}), found = Run(styled, 20, 60, {{2, 1.0F}});
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_EQ(Difference(found[i].reconstruction, expected[i].reconstruction), 0);
    EXPECT_GT(Difference(found[i].styled, expected[i].styled), 1e-3);
  }
}

// The second decoder has followed the first, so that a style of nearly no strength changes nearly
// nothing. A decoder that restarted would be as far off as the control.
TEST_F(Step, AStyleBeginsWithoutAJump) {
  State state = network->MakeState(), late = network->MakeState();
  Run(state, 0, 100, {});
  const Output begun = Run(state, 100, 101, {{1, 1e-5F}})[0];
  EXPECT_GT(Difference(begun.styled, begun.reconstruction), 0);
  EXPECT_LT(Difference(begun.styled, begun.reconstruction), 1e-4);
  const Output anew = Run(late, 100, 101, {})[0];
  EXPECT_GT(Difference(anew.styled, begun.reconstruction), 1e-2);
}

TEST_F(Step, AStyleEndsWithoutAJump) {
  State state = network->MakeState();
  Run(state, 0, 60, {{1, 1.0F}});
  const int alone = kMemoriesAlone * 21;
  const auto after = Run(state, 60, 60 + alone + 2, {});
  const auto apart = [&](int frame) {
    const Output& out = after[static_cast<std::size_t>(frame)];
    return Difference(out.styled, out.reconstruction);
  };
  EXPECT_GT(apart(0), 1e-2);
  // The last frame that the second decoder makes: what is left is gone in the next one.
  EXPECT_GT(apart(alone - 1), 0);
  EXPECT_LT(apart(alone - 1), 5e-3 * apart(0));
  EXPECT_EQ(apart(alone), 0);
}

TEST_F(Step, TheInputStyleAloneIsStyledToNeutral) {
  State styled = network->MakeState(), neutral = network->MakeState();
  const auto found = Run(styled, 0, 30, {}, 2), expected = Run(neutral, 0, 30, {});
  for (std::size_t i = 0; i < found.size(); ++i) {
    EXPECT_EQ(Difference(found[i].styled, expected[i].styled), 0);
    EXPECT_GT(Difference(found[i].reconstruction, expected[i].reconstruction), 1e-3);
  }
}

TEST_F(Step, IgnoresStylesItLacksAndNeutral) {
  const Styles odd{{0, 1.0F}, {-1, 1.0F}, {16, 1.0F}, {1, 0.5F}, {1 << 30, 1.0F}};
  EXPECT_EQ(Difference(First(odd), First({{1, 0.5F}}, 99)), 0);
  EXPECT_EQ(Difference(First({{0, 1.0F}}), First({}, -5)), 0);
}

TEST_F(Step, IgnoresWhatComesAfterTheLimit) {
  Styles most, more;
  for (int style = 1; style < 16; ++style) {
    if (style <= net::kMaxActive) most.push_back({style, 0.1F});
    more.push_back({style, 0.1F});
  }
  EXPECT_EQ(Difference(First(more), First(most)), 0);
  most.pop_back();
  EXPECT_GT(Difference(First(more), First(most)), kTolerance);
}

TEST_F(Step, WeightsAreClampedAndOfOneStyleAdded) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  const Output most = First({{1, net::kMaxStrength}}), none = First({});
  EXPECT_EQ(Difference(First({{1, 1e9F}}), most), 0);
  EXPECT_EQ(Difference(First({{1, kInfinity}}), most), 0);
  EXPECT_EQ(Difference(First({{1, -1.0F}}), none), 0);
  EXPECT_EQ(Difference(First({{1, kNan}}), none), 0);
  EXPECT_EQ(Difference(First({{1, 0.25F}, {1, 0.5F}}), First({{1, 0.75F}})), 0);
  EXPECT_GT(Difference(most, none), 1e-3);
}

TEST_F(Step, NoInputLeavesANonFiniteState) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  constexpr float kHuge = std::numeric_limits<float>::max();
  constexpr float kTiny = std::numeric_limits<float>::denorm_min();
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  State state = network->MakeState();
  Output out;
  std::size_t frame = 0;
  for (const float value :
       {kNan, 1e30F, 0.0F, kTiny, 1e6F, -1e30F, kHuge, -kHuge, kInfinity, -kInfinity, kNan}) {
    for (std::size_t repeat = 0; repeat < 5; ++repeat) {
      Features features = walk[frame++];
      for (std::size_t i = 0; i < features.size(); i += 1 + repeat) features[i] = value;
      network->Step(features, repeat == 3 ? 2 : 0, Styles{{1, 1.0F}, {2, 0.5F}}, state, out);
      EXPECT_TRUE(AllFinite(out)) << value;
      EXPECT_TRUE(AllFinite(state)) << value;
    }
  }
}

TEST_F(Step, RecoversFromANotANumberFrame) {
  State state = network->MakeState(), undisturbed = network->MakeState();
  const Styles active{{1, 1.0F}};
  Run(state, 0, 30, active);
  Run(undisturbed, 0, 30, active);
  Features nothing;
  nothing.fill(std::numeric_limits<float>::quiet_NaN());
  Output out, expected;
  network->Step(nothing, 0, active, state, out);
  network->Step(walk[30], 0, active, undisturbed, expected);
  EXPECT_GT(Difference(out.styled, expected.styled), 1e-2);
  const auto found = Run(state, 31, 400, active), wanted = Run(undisturbed, 31, 400, active);
  EXPECT_LT(Difference(found.back(), wanted.back()), 1e-4);
}

TEST_F(Step, ANetworkOfNeutralAloneRuns) {
  network = CausalNetwork(RandomWeights(1, 16, 4));
  EXPECT_TRUE(AllFinite(First({{1, 1.0F}})));
}

}  // namespace
}  // namespace styled::stgcn_causal
