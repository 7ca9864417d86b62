#include "sim/faults/faults.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "proto/rigs/native/datagram.h"
#include "tests/unit/native/decode_cases.h"

namespace styled::faults {
namespace {

Spec SpecOf(std::string_view text) {
  const auto spec = Parse(text);
  EXPECT_TRUE(spec.ok()) << spec.status().message();
  return spec.value();
}

TEST(Faults, SpecIsRefusedWithItsWordAndWhatWasExpected) {
  for (const auto& [text, expected] : {std::pair{"los=0.1", "expected loss, duplicate"},
                                       {"loss", "expected word=value"},
                                       {"loss=", "probability from 0 to 1"},
                                       {"loss=1.1", "probability from 0 to 1"},
                                       {"loss=-0.1", "probability from 0 to 1"},
                                       {"loss=nan", "probability from 0 to 1"},
                                       {"loss=0.1x", "probability from 0 to 1"},
                                       {"none=0.1", "expected loss, duplicate"},
                                       {"seed=-1", "whole number"},
                                       {"seed=1.5", "whole number"},
                                       {"late-ms=-1", "milliseconds"},
                                       {"late-ms=60001", "milliseconds"},
                                       {"burst-frames=1", "whole number from 2"},
                                       {"burst-frames=2.5", "whole number from 2"},
                                       {"occlude-frames=0", "whole number from 1"},
                                       {"step-s=nan", "seconds"},
                                       {"step-s=86401", "seconds"},
                                       {"jitter-ms=-1", "milliseconds from 0 to 1000"},
                                       {"drift-ppm=100001", "-100000 to 100000"},
                                       {"drift-ppm=", "-100000 to 100000"},
                                       {"loss=0.6,late=0.6", "at most 1"}}) {
    const auto spec = Parse(text);
    ASSERT_FALSE(spec.ok()) << text;
    EXPECT_NE(spec.status().message().find(expected), std::string::npos) << spec.status().message();
  }
}

TEST(Faults, SpecIsReadWhole) {
  const Spec spec = SpecOf("loss=0.1,late=0.25,seed=7,late-ms=20,restart-pause-ms=300");
  EXPECT_EQ(spec.probability[static_cast<std::size_t>(Fault::kLoss)], 0.1);
  EXPECT_EQ(spec.probability[static_cast<std::size_t>(Fault::kLate)], 0.25);
  EXPECT_EQ(spec.seed, 7U);
  EXPECT_EQ(spec.late_ms, 20);
  EXPECT_EQ(spec.restart_pause_ms, 300);
  const Spec other =
      SpecOf("burst-frames=8,step-s=-2.5,occlude-frames=60,jitter-ms=4,drift-ppm=-50");
  EXPECT_EQ(other.burst_frames, 8);
  EXPECT_EQ(other.step_s, -2.5);
  EXPECT_EQ(other.occlude_frames, 60);
  EXPECT_EQ(other.jitter_ms, 4);
  EXPECT_EQ(other.drift_ppm, -50);
  EXPECT_FALSE(SpecOf("").any());
  EXPECT_TRUE(SpecOf("jitter-ms=1").any());
  EXPECT_TRUE(SpecOf("drift-ppm=-1").any());
  EXPECT_TRUE(spec.any());
}

TEST(Faults, CountsWhatItDrawsAndDrawsWhatWasAskedFor) {
  Faults faults(SpecOf("loss=0.1,duplicate=0.05,nan=0.01,restart=0.001,seed=3"));
  Counts seen{};
  constexpr int kDraws = 100000;
  for (int i = 0; i < kDraws; ++i) ++seen[static_cast<std::size_t>(faults.Draw())];
  EXPECT_EQ(seen, faults.counts());
  const auto share = [&seen](Fault fault) {
    return static_cast<double>(seen[static_cast<std::size_t>(fault)]) / kDraws;
  };
  EXPECT_NEAR(share(Fault::kLoss), 0.1, 0.005);
  EXPECT_NEAR(share(Fault::kDuplicate), 0.05, 0.004);
  EXPECT_NEAR(share(Fault::kNan), 0.01, 0.002);
  EXPECT_NEAR(share(Fault::kRestart), 0.001, 0.0005);
  EXPECT_EQ(share(Fault::kCorrupt), 0);
}

TEST(Faults, AreTheSameForASeedAndOthersForAnotherOrAnotherPerformer) {
  const auto draws = [](const Spec& spec, std::uint64_t stream) {
    Faults faults(spec, stream);
    std::vector<Fault> all;
    for (int i = 0; i < 200; ++i) all.push_back(faults.Draw());
    return all;
  };
  const Spec one = SpecOf("loss=0.5,seed=1"), two = SpecOf("loss=0.5,seed=2");
  EXPECT_EQ(draws(one, 0), draws(one, 0));
  EXPECT_NE(draws(one, 0), draws(two, 0));
  EXPECT_NE(draws(one, 0), draws(one, 1));
}

TEST(Faults, SpareTheFrameBehindAReorderedOne) {
  Faults faults(SpecOf("reorder=0.5,loss=0.5"));
  bool reordered = false;
  for (int i = 0; i < 1000; ++i) {
    const Fault fault = faults.Draw();
    EXPECT_EQ(fault == Fault::kNone, reordered);
    reordered = fault == Fault::kReorder;
  }
}

TEST(Faults, SpareTheFramesOfABurst) {
  Faults faults(SpecOf("burst=0.1,loss=0.9,burst-frames=4"));
  int spared = 0;
  for (int i = 0; i < 1000; ++i) {
    const Fault fault = faults.Draw();
    EXPECT_EQ(fault == Fault::kNone, spared > 0);
    spared = fault == Fault::kBurst ? 3 : std::max(0, spared - 1);
  }
  EXPECT_GT(faults.counts()[static_cast<std::size_t>(Fault::kBurst)], 10U);
}

TEST(Faults, JitterIsUniformAndLeavesTheOtherDrawsAlone) {
  Faults jittery(SpecOf("loss=0.3,jitter-ms=10,seed=4")), steady(SpecOf("loss=0.3,seed=4"));
  Faults again(SpecOf("jitter-ms=10,seed=4")), other(SpecOf("jitter-ms=10,seed=5"));
  constexpr int kDraws = 10000;
  double sum = 0;
  int same = 0;
  for (int i = 0; i < kDraws; ++i) {
    const double jitter_s = jittery.DrawJitter_s();
    EXPECT_GE(jitter_s, 0);
    EXPECT_LE(jitter_s, 0.010);
    sum += jitter_s;
    EXPECT_EQ(again.DrawJitter_s(), jitter_s);
    same += other.DrawJitter_s() == jitter_s;
    EXPECT_EQ(steady.DrawJitter_s(), 0);
    EXPECT_EQ(jittery.Draw(), steady.Draw());
  }
  EXPECT_NEAR(sum / kDraws, 0.005, 0.0002);
  EXPECT_LT(same, 10);
}

TEST(Faults, ClockDriftsStepsAndNeverShowsLessThanZero) {
  Faults drifting(SpecOf("drift-ppm=100"));
  EXPECT_NEAR(drifting.ClockError_s(1000, Fault::kNone), 0.1, 1e-9);
  EXPECT_NEAR(drifting.ClockError_s(2000, Fault::kNone), 0.2, 1e-9);
  Faults stepping(SpecOf("step-s=-3"));
  EXPECT_EQ(stepping.ClockError_s(9, Fault::kNone), 0);
  EXPECT_EQ(stepping.ClockError_s(10, Fault::kStep), -3);
  EXPECT_EQ(stepping.ClockError_s(11, Fault::kNone), -3);
  EXPECT_EQ(stepping.ClockError_s(12, Fault::kStep), -6);
  stepping.ResetClock();
  EXPECT_EQ(stepping.ClockError_s(1, Fault::kStep), -1);  // to 0, and on from there
  EXPECT_EQ(stepping.ClockError_s(2, Fault::kNone), -1);
  Faults exact(SpecOf("loss=0.5"));
  EXPECT_EQ(exact.ClockError_s(1234.567, Fault::kLoss), 0);
}

TEST(Faults, DamageIsAlwaysSeenAsWhatItIs) {
  using native::DecodeResult;
  Faults faults(SpecOf("seed=5"));
  const auto good =
      native::testing::MakeDatagram(native::Kind::kSourceFrame, 9, 1, native::testing::Bytes(50));
  for (int i = 0; i < 2000; ++i) {
    native::Datagram datagram;
    auto bytes = good;
    bytes.resize(faults.Damage(Fault::kCorrupt, bytes.data(), bytes.size()));
    EXPECT_EQ(native::Decode(bytes, datagram), DecodeResult::kBadChecksum);
    bytes = good;
    bytes.resize(faults.Damage(Fault::kTruncate, bytes.data(), bytes.size()));
    EXPECT_EQ(native::Decode(bytes, datagram), DecodeResult::kLengthMismatch);
    bytes = good;
    EXPECT_EQ(faults.Damage(Fault::kNone, bytes.data(), bytes.size()), good.size());
    EXPECT_EQ(bytes, good);
  }
}

}  // namespace
}  // namespace styled::faults
