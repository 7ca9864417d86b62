// Network::Step compared with a scalar double-precision network written from FORMAT.md's equations;
// and its guarantees about branches, determinism and hostile input.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/unit/net/erd/reference.h"
#include "tests/unit/net/kernels/each_target.h"

namespace styled::erd {
namespace {

bool AllFinite(const net::Decoded& decoded) {
  bool finite = std::isfinite(decoded.hips_height_m);
  for (const body::Quat& q : decoded.rotations) {
    finite = finite && q.coeffs().allFinite() && std::abs(q.norm() - 1) < 1e-5F;
  }
  for (const float v : decoded.velocities_m_s) finite = finite && std::isfinite(v);
  return finite;
}

bool AllFinite(const State& state) {
  const auto finite = [](const BranchState& branch, int layers) {
    bool all = true;
    for (int l = 0; l < layers; ++l) all = all && (branch.h[l] + branch.c[l]).allFinite();
    return all;
  };
  bool all = finite(state.neutral, kNeutralLayers);
  for (int i = 0; i < kMaxBranches; ++i) {
    if (state.style[i] >= 0) all = all && finite(state.branch[i], kStyleLayers);
  }
  return all;
}

TEST(StepAgainstReference, NeutralAlone) {
  EXPECT_LT(CompareThrough({{0, 0, {}}}, 200, 1), kTolerance);
}

TEST(StepAgainstReference, OneStyle) {
  EXPECT_LT(CompareThrough({{0, 0, {{2, 1.0F}}}}, 1000, 2), kTolerance);
}

TEST(StepAgainstReference, PartialStrengthLeavesAShareToNeutral) {
  EXPECT_LT(CompareThrough({{0, 0, {{2, 0.4F}}}}, 200, 3), kTolerance);
}

TEST(StepAgainstReference, StrengthAboveOneIsNormalized) {
  EXPECT_LT(CompareThrough({{0, 0, {{1, 0.8F}, {3, 0.7F}}}}, 200, 4), kTolerance);
}

TEST(StepAgainstReference, MixOfFour) {
  const std::vector<net::StyleWeight> mix{{1, 0.3F}, {5, 0.1F}, {2, 0.2F}, {4, 0.25F}};
  EXPECT_LT(CompareThrough({{0, 0, mix}}, 200, 5), kTolerance);
}

TEST(StepAgainstReference, SwitchDropAndRestart) {
  EXPECT_LT(CompareThrough({{0, 0, {{1, 1.0F}}},
                            {40, 0, {{1, 0.5F}, {2, 0.5F}}},  // a second style begins
                            {60, 0, {{2, 1.0F}}},             // the first is dropped
                            {90, 0, {{1, 0.7F}, {2, 0.0F}}},  // restarts; weight 0: live
                            {110, 0, {{2, 1.0F}}},
                            {130, 0, {}},
                            {150, 0, {{3, 1.0F}, {1, 0.2F}}}},
                           200, 6),
            kTolerance);
}

TEST(StepAgainstReference, StyledInput) {
  EXPECT_LT(CompareThrough({{0, 3, {}},                        // to neutral
                            {50, 3, {{1, 1.0F}}},              // to another style
                            {100, 3, {{3, 0.6F}, {1, 0.4F}}},  // 3 is in the mix, too
                            {150, 0, {{1, 0.5F}}}},  // no input style any more: 3 is dropped
                           200, 7),
            kTolerance);
}

TEST(StepAgainstReference, AWideNetwork) {
  EXPECT_LT(CompareThrough<kWide>({{0, 0, {{2, 1.0F}}},
                                   {40, 0, {{1, 0.5F}, {2, 0.7F}}},
                                   {90, 3, {{3, 0.6F}, {1, 0.4F}}},
                                   {150, 0, {}}},
                                  200, 20),
            kTolerance);
}

TEST(StepAgainstReference, AnotherHistoryIsSeen) {
  // The comparison's negative control: the same network with one branch one frame older.
  const auto network = RandomNetwork(3, 8);
  const std::vector<net::StyleWeight> active{{1, 1.0F}};
  State a, b;
  network->Start(a);
  network->Start(b);
  net::Prediction out_a, out_b;
  network->Step(FeaturesAt(0), 0, active, a, out_a);
  network->Step(FeaturesAt(0), 0, {}, b, out_b);
  network->Step(FeaturesAt(1), 0, active, a, out_a);
  network->Step(FeaturesAt(1), 0, active, b, out_b);
  EXPECT_GT(Difference(out_a.styled, out_b.styled), 100 * kTolerance);
  EXPECT_EQ(Difference(out_a.reconstruction, out_b.reconstruction), 0);
}

TEST(Step, TwoRunsAreBitIdentical) {
  const auto network = RandomNetwork(4, 9);
  std::vector<net::Prediction> runs[2];
  for (auto& run : runs) {
    State state;
    network->Start(state);
    for (int frame = 0; frame < 100; ++frame) {
      const std::vector<net::StyleWeight> active{{1 + frame / 40, 0.9F}, {3, 0.2F}};
      run.emplace_back();
      network->Step(FeaturesAt(frame), 0, active, state, run.back());
    }
  }
  for (int frame = 0; frame < 100; ++frame) {
    EXPECT_EQ(Difference(runs[0][frame].styled, runs[1][frame].styled), 0);
    EXPECT_EQ(Difference(runs[0][frame].reconstruction, runs[1][frame].reconstruction), 0);
  }
}

// More performers than are processed at a time: without a style, in one, in several, switching, and
// with an input style.
template <Shape kShape>
void ExpectTogetherAsAlone(const ShapedNetwork<kShape>& network) {
  constexpr int kPerformers = 21;
  std::vector<StateOf<kShape>> alone(kPerformers), together(kPerformers);
  std::vector<net::Prediction> out_alone(kPerformers), out_together(kPerformers);
  for (auto& state : alone) network.Start(state);
  for (auto& state : together) network.Start(state);
  for (int frame = 0; frame < 12; ++frame) {
    std::vector<Features> features;
    std::vector<std::vector<net::StyleWeight>> active(kPerformers);
    for (int k = 0; k < kPerformers; ++k) {
      features.push_back(FeaturesAt(frame + 3 * k));
      for (int s = 0; s < k % 5; ++s) active[k].push_back({1 + (k + s + frame / 4) % 6, 0.4F});
    }
    std::vector<StepJobOf<kShape>> jobs;
    for (int k = 0; k < kPerformers; ++k) {
      const int own = k % 4 == 3 ? 2 : 0;
      network.Step(features[k], own, active[k], alone[k], out_alone[k]);
      jobs.push_back({&features[k], own, active[k], &together[k], &out_together[k]});
    }
    network.StepTogether(jobs);
    for (int k = 0; k < kPerformers; ++k) {
      ASSERT_EQ(Difference(out_alone[k].styled, out_together[k].styled), 0) << frame << " " << k;
      ASSERT_EQ(Difference(out_alone[k].reconstruction, out_together[k].reconstruction), 0);
      ASSERT_EQ(alone[k].style, together[k].style);
    }
  }
}

TEST(Step, TogetherIsBitForBitOneByOne) {
  net::OnEachTarget([] {
    ExpectTogetherAsAlone(*RandomNetwork(6, 19));
    ExpectTogetherAsAlone(*RandomWideNetwork(6, 19));
  });
}

TEST(Step, ACopiedStateGoesOnAlike) {
  const auto network = RandomNetwork(3, 10);
  const std::vector<net::StyleWeight> active{{1, 0.5F}, {2, 0.5F}};
  State state;
  network->Start(state);
  net::Prediction out, of_copy;
  for (int frame = 0; frame < 20; ++frame) network->Step(FeaturesAt(frame), 0, active, state, out);
  State copy = state;
  network->Step(FeaturesAt(20), 0, active, state, out);
  network->Step(FeaturesAt(20), 0, active, copy, of_copy);
  EXPECT_EQ(Difference(out.styled, of_copy.styled), 0);
}

TEST(Step, WithoutAStyleStyledIsTheReconstruction) {
  const auto network = RandomNetwork(3, 11);
  State state, other;
  network->Start(state);
  network->Start(other);
  net::Prediction none, zero;
  network->Step(FeaturesAt(0), 0, {}, state, none);
  EXPECT_EQ(Difference(none.styled, none.reconstruction), 0);
  const std::vector<net::StyleWeight> weight_zero{{1, 0.0F}};
  network->Step(FeaturesAt(0), 0, weight_zero, other, zero);
  EXPECT_EQ(Difference(zero.styled, none.styled), 0);
}

TEST(Step, ANetworkOfNeutralAloneRuns) {
  const auto network = RandomNetwork(1, 12);
  State state;
  network->Start(state);
  net::Prediction out;
  network->Step(FeaturesAt(0), 0, {}, state, out);
  EXPECT_TRUE(AllFinite(out.styled));
}

TEST(Step, BranchesLiveWhileNamed) {
  const auto network = RandomNetwork(6, 13);
  State state;
  network->Start(state);
  net::Prediction out;
  const auto alive = [&state](int style) {
    return std::count(state.style.begin(), state.style.end(), style);
  };
  EXPECT_EQ(alive(-1), kMaxBranches);
  network->Step(FeaturesAt(0), 0, std::vector<net::StyleWeight>{{2, 1.0F}, {4, 0.0F}}, state, out);
  EXPECT_EQ(alive(2), 1);
  EXPECT_EQ(alive(4), 1);
  network->Step(FeaturesAt(1), 5, std::vector<net::StyleWeight>{{2, 1.0F}}, state, out);
  EXPECT_EQ(alive(4), 0);
  EXPECT_EQ(alive(5), 1);
  network->Step(FeaturesAt(2), 0, {}, state, out);
  EXPECT_EQ(alive(-1), kMaxBranches);
}

TEST(Step, IgnoresStylesItLacksAndNeutral) {
  const auto network = RandomNetwork(3, 14);
  State state, other;
  network->Start(state);
  network->Start(other);
  net::Prediction out, expected;
  const std::vector<net::StyleWeight> odd{
      {0, 1.0F}, {-1, 1.0F}, {3, 1.0F}, {1, 0.5F}, {1 << 30, 1.0F}};
  network->Step(FeaturesAt(0), 0, odd, state, out);
  network->Step(FeaturesAt(0), 99, std::vector<net::StyleWeight>{{1, 0.5F}}, other, expected);
  EXPECT_EQ(Difference(out.styled, expected.styled), 0);
}

TEST(Step, IgnoresWhatComesAfterTheLimit) {
  const auto network = RandomNetwork(16, 15);
  State state;
  network->Start(state);
  net::Prediction out;
  std::vector<net::StyleWeight> all;
  for (int style = 1; style < 16; ++style) all.push_back({style, 0.1F});
  network->Step(FeaturesAt(0), 15, all, state, out);  // the input style has its own slot
  for (int i = 0; i < net::kMaxActive; ++i) EXPECT_EQ(state.style[i], 1 + i);
  EXPECT_EQ(state.style[net::kMaxActive], 15);
}

TEST(Step, WeightsAreClampedAndOfOneStyleAdded) {
  const auto network = RandomNetwork(3, 16);
  const auto styled = [&](const std::vector<net::StyleWeight>& active) {
    State state;
    network->Start(state);
    net::Prediction out;
    network->Step(FeaturesAt(0), 0, active, state, out);
    return out.styled;
  };
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  const net::Decoded most = styled({{1, net::kMaxStrength}});
  const net::Decoded none = styled({{1, 0.0F}});
  EXPECT_EQ(Difference(styled({{1, 1e9F}}), most), 0);
  EXPECT_EQ(Difference(styled({{1, kInfinity}}), most), 0);
  EXPECT_EQ(Difference(styled({{1, -1.0F}}), none), 0);
  EXPECT_EQ(Difference(styled({{1, kNan}}), none), 0);
  EXPECT_EQ(Difference(styled({{1, 0.25F}, {1, 0.5F}}), styled({{1, 0.75F}})), 0);
  EXPECT_EQ(Difference(styled({{1, 1.0F}, {1, 1.0F}}), most), 0) << "together not above the limit";
  EXPECT_GT(Difference(most, none), kTolerance);
}

TEST(Step, NoInputLeavesANonFiniteState) {
  const auto network = RandomNetwork(3, 17);
  const std::vector<net::StyleWeight> active{{1, 1.0F}, {2, 0.5F}};
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  constexpr float kHuge = std::numeric_limits<float>::max();
  constexpr float kTiny = std::numeric_limits<float>::denorm_min();
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  State state;
  network->Start(state);
  net::Prediction out;
  int frame = 0;
  for (const float value :
       {0.0F, kTiny, 1e6F, -1e20F, kHuge, -kHuge, kInfinity, -kInfinity, kNan}) {
    for (int repeat = 0; repeat < 5; ++repeat) {
      Features features = FeaturesAt(frame++);
      for (int i = 0; i < kFeatureCount; i += 1 + repeat) features[i] = value;
      network->Step(features, repeat == 3 ? 2 : 0, active, state, out);
      EXPECT_TRUE(AllFinite(out.styled)) << value;
      EXPECT_TRUE(AllFinite(out.reconstruction)) << value;
      EXPECT_TRUE(AllFinite(state)) << value;
    }
  }
}

TEST(Step, RecoversFromANotANumberFrame) {
  // A frame of NaN counts as the mean; 300 frames later its effect has faded.
  const auto network = RandomNetwork(3, 18);
  const std::vector<net::StyleWeight> active{{1, 1.0F}};
  State state, undisturbed;
  network->Start(state);
  network->Start(undisturbed);
  net::Prediction out, expected;
  Features nothing;
  nothing.fill(std::numeric_limits<float>::quiet_NaN());
  network->Step(nothing, 0, active, state, out);
  network->Step(FeaturesAt(0), 0, active, undisturbed, expected);
  EXPECT_GT(Difference(out.styled, expected.styled), 1e-3);
  for (int frame = 1; frame < 300; ++frame) {
    network->Step(FeaturesAt(frame), 0, active, state, out);
    network->Step(FeaturesAt(frame), 0, active, undisturbed, expected);
  }
  EXPECT_LT(Difference(out.styled, expected.styled), 1e-3);
}

}  // namespace
}  // namespace styled::erd
