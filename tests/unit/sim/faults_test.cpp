#include "sim/faults/faults.h"

#include <gtest/gtest.h>

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
  EXPECT_FALSE(SpecOf("").any());
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
