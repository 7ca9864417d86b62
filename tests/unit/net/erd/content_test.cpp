// The content input of Network::Step, compared with the reference; and the guarantees of the
// recognizer.
#include <gtest/gtest.h>

#include <cstddef>
#include <iostream>
#include <memory>
#include <numeric>
#include <vector>

#include "model/base/checkpoint.h"
#include "model/net/weights_file.h"
#include "tests/unit/net/erd/reference.h"
#include "tests/unit/net/kernels/each_target.h"

namespace styled::erd {
namespace {

constexpr int kContents = 5;
constexpr int kFrames = 300;
using net::kContentRecognized;
using net::kContentUnknown;

std::shared_ptr<const Network> NetworkWithContents(unsigned seed, int contents = kContents) {
  return NetworkOf(RandomWeightsWithContents(4, contents, seed));
}

// The outputs of a network for FeaturesAt.
struct ContentRun {
  std::vector<net::Prediction> out;
  std::vector<std::vector<float>> shares;  // P of each frame
};
ContentRun RunContents(const Network& network, State& state, int frames, int content,
                       int first_frame = 0, unsigned seed = 7) {
  ContentRun run;
  const std::vector<net::StyleWeight> active{{1, 0.7F}, {3, 0.3F}};
  for (int frame = first_frame; frame < first_frame + frames; ++frame) {
    network.Step(FeaturesAt(frame, seed), 0, active, state, run.out.emplace_back(), content);
    run.shares.emplace_back(static_cast<std::size_t>(network.content_count()));
    network.Recognized(state, run.shares.back());
  }
  return run;
}
ContentRun RunContents(const Network& network, int frames, int content) {
  State state;
  network.Start(state);
  return RunContents(network, state, frames, content);
}

// The largest difference of any frame that both have.
double RunDifference(const ContentRun& a, const ContentRun& b) {
  double largest = 0;
  for (std::size_t i = 0; i < std::min(a.out.size(), b.out.size()); ++i) {
    largest = std::max({largest, Difference(a.out[i].styled, b.out[i].styled),
                        Difference(a.out[i].reconstruction, b.out[i].reconstruction)});
  }
  return largest;
}

TEST(ContentAgainstReference, Recognized) {
  const double largest =
      CompareThrough({{0, 0, {{2, 1.0F}}, kContentRecognized}}, kFrames, 31, kContents);
  std::cout << "largest difference " << largest << '\n';
  EXPECT_LT(largest, kTolerance);
}

TEST(ContentAgainstReference, Labelled) {
  for (int content = 0; content < kContents; ++content) {
    EXPECT_LT(CompareThrough({{0, 0, {{1, 0.5F}, {4, 0.5F}}, content}}, kFrames, 32, kContents),
              kTolerance)
        << content;
  }
}

TEST(ContentAgainstReference, Unknown) {
  EXPECT_LT(CompareThrough({{0, 0, {{3, 1.0F}}, kContentUnknown}}, kFrames, 33, kContents),
            kTolerance);
}

TEST(ContentAgainstReference, ChangesOnTheWay) {
  EXPECT_LT(CompareThrough({{0, 0, {{1, 1.0F}}, 4},
                            {40, 0, {{1, 1.0F}}, 0},
                            {80, 2, {{1, 0.7F}}, kContentRecognized},
                            {120, 0, {}, kContentUnknown},
                            {160, 0, {{5, 1.0F}}, kContentRecognized}},
                           kFrames, 34, kContents),
            kTolerance);
}

TEST(ContentAgainstReference, AWideNetworkOfOneContentAndOfTheMost) {
  EXPECT_LT(
      CompareThrough<kWide>({{0, 0, {{1, 1.0F}}, kContentRecognized}, {50, 0, {}, 0}}, 100, 35, 1),
      kTolerance);
  EXPECT_LT(CompareThrough<kWide>({{0, 0, {{1, 1.0F}}, kContentRecognized}, {50, 0, {}, 63}}, 100,
                                  36, net::kMaxContents),
            kTolerance);
}

// The comparison's negative controls: modes differ, and so do labels from the first frame on.
TEST(ContentAgainstReference, AnotherContentIsSeen) {
  const auto network = NetworkWithContents(37);
  const ContentRun recognized = RunContents(*network, 60, kContentRecognized);
  const ContentRun unknown = RunContents(*network, 60, kContentUnknown);
  const ContentRun first = RunContents(*network, 60, 0), last = RunContents(*network, 60, 4);
  EXPECT_GT(RunDifference(recognized, unknown), 1e-3);
  EXPECT_GT(RunDifference(recognized, first), 1e-3);
  EXPECT_GT(Difference(first.out[0].styled, last.out[0].styled), 1e-3);
  EXPECT_GT(Difference(first.out[0].styled, unknown.out[0].styled), 1e-3);
}

// c = 0 in the first frame, and the initial state is that of an unknown content.
TEST(Content, ARecognizedStartIsAnUnknownOne) {
  const auto network = NetworkWithContents(38);
  const ContentRun recognized = RunContents(*network, 2, kContentRecognized);
  const ContentRun unknown = RunContents(*network, 2, kContentUnknown);
  EXPECT_EQ(Difference(recognized.out[0].styled, unknown.out[0].styled), 0);
  EXPECT_GT(Difference(recognized.out[1].styled, unknown.out[1].styled), 0);
}

TEST(Content, IdleContentsChangeNothing) {
  WeightsFile file = RandomWeights(4, 39);
  const auto without = NetworkOf(file);
  AddContents(file, kContents, 40, true);
  const auto with = NetworkOf(file);
  const ContentRun expected = RunContents(*without, kFrames, kContentRecognized);
  for (const int content : {kContentRecognized, kContentUnknown, 0, kContents - 1}) {
    EXPECT_EQ(RunDifference(RunContents(*with, kFrames, content), expected), 0) << content;
  }
}

TEST(Content, ANetworkWithoutContentsIgnoresIt) {
  const auto network = RandomNetwork(4, 41);
  const ContentRun expected = RunContents(*network, 50, kContentRecognized);
  EXPECT_EQ(RunDifference(RunContents(*network, 50, 3), expected), 0);
  EXPECT_EQ(RunDifference(RunContents(*network, 50, kContentUnknown), expected), 0);
}

TEST(Content, ANumberThatTheNetworkLacksCountsAsUnknown) {
  const auto network = NetworkWithContents(42);
  const ContentRun expected = RunContents(*network, 50, kContentUnknown);
  for (const int content : {kContents, 1 << 30, -3, -(1 << 30)}) {
    EXPECT_EQ(RunDifference(RunContents(*network, 50, content), expected), 0) << content;
  }
}

TEST(Content, SharesSumToOneAndAreTheReferences) {
  const WeightsFile file = RandomWeightsWithContents(4, kContents, 43);
  const auto network = NetworkOf(file);
  const ContentRun run = RunContents(*network, kFrames, 2);  // whatever the label
  Reference reference(file);
  double most = 0, least = 1;
  for (int frame = 0; frame < kFrames; ++frame) {
    const std::vector<float>& shares = run.shares[static_cast<std::size_t>(frame)];
    EXPECT_NEAR(std::accumulate(shares.begin(), shares.end(), 0.0), 1, 1e-6);
    ReferenceOutput reconstruction, styled;
    reference.Step(FeaturesAt(frame), 0, {{1, 0.7}, {3, 0.3}}, reconstruction, styled);
    for (std::size_t i = 0; i < shares.size(); ++i) {
      EXPECT_NEAR(shares[i], reference.recognized()[i], 1e-5) << frame;
      most = std::max(most, static_cast<double>(shares[i]));
      least = std::min(least, static_cast<double>(shares[i]));
    }
  }
  EXPECT_GT(most, 0.5);  // the weights recognize something, and other than all alike
  EXPECT_LT(least, 0.1);
}

TEST(Content, LaterFramesDoNotChangeEarlierOnes) {
  const auto network = NetworkWithContents(44);
  State state, other;
  network->Start(state);
  network->Start(other);
  ContentRun run = RunContents(*network, state, 40, kContentRecognized);
  ContentRun same = RunContents(*network, other, 40, kContentRecognized);
  EXPECT_EQ(RunDifference(run, same), 0);
  EXPECT_EQ(run.shares, same.shares);
  run = RunContents(*network, state, 10, kContentRecognized, 40, 7);
  same = RunContents(*network, other, 10, kContentRecognized, 40, 8);  // other motion
  EXPECT_GT(RunDifference(run, same), 1e-3);
  EXPECT_NE(run.shares, same.shares);
}

TEST(Content, AStartBringsTheFirstFrameBack) {
  const auto network = NetworkWithContents(45);
  State state;
  for (const int content : {kContentRecognized, 1, kContentUnknown, 3}) {
    network->Start(state);
    const ContentRun again = RunContents(*network, state, 30, content);
    const ContentRun fresh = RunContents(*network, 30, content);
    EXPECT_EQ(RunDifference(again, fresh), 0) << content;
    EXPECT_EQ(again.shares, fresh.shares) << content;
  }
}

// The recognizer has followed the frames in which a label was given.
TEST(Content, ALabelDoesNotStopTheRecognizer) {
  const auto network = NetworkWithContents(46);
  EXPECT_EQ(RunContents(*network, 50, 2).shares,
            RunContents(*network, 50, kContentRecognized).shares);
}

TEST(Content, TogetherIsBitForBitOneByOne) {
  net::OnEachTarget([] {
    const auto network = NetworkWithContents(47);
    constexpr int kPerformers = 21;
    std::vector<State> alone(kPerformers), together(kPerformers);
    std::vector<net::Prediction> out_alone(kPerformers), out_together(kPerformers);
    for (State& state : alone) network->Start(state);
    for (State& state : together) network->Start(state);
    const std::vector<net::StyleWeight> active{{2, 1.0F}};
    for (int frame = 0; frame < 12; ++frame) {
      std::vector<Features> features;
      for (int k = 0; k < kPerformers; ++k) features.push_back(FeaturesAt(frame + 3 * k));
      std::vector<StepJob> jobs;
      for (int k = 0; k < kPerformers; ++k) {
        const int content = k % (kContents + 2) - 2;
        network->Step(features[k], 0, active, alone[k], out_alone[k], content);
        jobs.push_back({&features[k], 0, active, &together[k], &out_together[k], content});
      }
      network->StepTogether(jobs);
      for (int k = 0; k < kPerformers; ++k) {
        ASSERT_EQ(Difference(out_alone[k].styled, out_together[k].styled), 0) << frame << " " << k;
      }
    }
  });
}

TEST(Content, ACheckpointContinuesBitForBit) {
  const auto network = NetworkWithContents(48);
  State state;
  network->Start(state);
  (void)RunContents(*network, state, 5, kContentRecognized);
  Checkpoint count;
  state.Carry(count, network->style_count(), true);
  std::vector<std::byte> bytes(count.size());
  Checkpoint to = Checkpoint::Into(bytes);
  state.Carry(to, network->style_count(), true);
  State copy;
  network->Start(copy);
  Checkpoint from = Checkpoint::From(bytes);
  copy.Carry(from, network->style_count(), true);
  ASSERT_TRUE(from.complete());
  const ContentRun expected = RunContents(*network, state, 40, kContentRecognized, 5);
  const ContentRun found = RunContents(*network, copy, 40, kContentRecognized, 5);
  EXPECT_EQ(RunDifference(found, expected), 0);
  EXPECT_EQ(found.shares, expected.shares);
  // Without contents a state has no bytes of the recognizer.
  Checkpoint without;
  copy.Carry(without, network->style_count(), false);
  EXPECT_EQ(count.size() - without.size(), (2 * 32 + 1) * sizeof(float));
}

TEST(Content, AStateOfManyDaysIsStillSound) {
  const auto network = NetworkWithContents(49);
  State state;
  network->Start(state);
  state.recognizer.frames = RecognizerStateOf<kPaper>::kMostFrames - 1;
  const ContentRun run = RunContents(*network, state, 3, kContentRecognized);
  EXPECT_EQ(state.recognizer.frames, RecognizerStateOf<kPaper>::kMostFrames);
  for (const auto& shares : run.shares) {
    EXPECT_NEAR(std::accumulate(shares.begin(), shares.end(), 0.0), 1, 1e-6);
  }
}

// As far from float32 as without contents.
TEST(Content, RunsInInt8) {
  const auto largest = [](const WeightsFile& file) {
    const std::vector<std::byte> bytes = file.Bytes();
    auto parsed = net::ParseWeights(bytes, "random");
    EXPECT_TRUE(parsed.ok());
    parsed.value().precision = net::Precision::kInt8;
    const auto rounded = Network::Read(parsed.value());
    EXPECT_TRUE(rounded.ok()) << rounded.status().message();
    return RunDifference(RunContents(*rounded.value(), kFrames, kContentRecognized),
                         RunContents(*NetworkOf(file), kFrames, kContentRecognized));
  };
  const double without = largest(RandomWeights(4, 50));
  const double with = largest(RandomWeightsWithContents(4, kContents, 50));
  EXPECT_GT(with, 0);
  EXPECT_LT(with, 3 * without);
}

}  // namespace
}  // namespace styled::erd
