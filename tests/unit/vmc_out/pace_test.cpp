#include "clients/vmc/pace.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "tests/support/units.h"

namespace styled::stylevmc {
namespace {

using support::kSecond_ns;

// Source times of the frames taken of `count` at `rate_hz`, arriving on time.
std::vector<std::uint64_t> Admitted(RateCap& cap, double rate_hz, int count) {
  std::vector<std::uint64_t> taken;
  for (int i = 0; i < count; ++i) {
    const auto at_ns = static_cast<std::uint64_t>(std::llround(i * 1e9 / rate_hz));
    const std::uint64_t source_ns = 5'000'000'000 + at_ns;
    if (cap.Admit(source_ns, static_cast<std::int64_t>(at_ns) + 1)) taken.push_back(source_ns);
  }
  return taken;
}

TEST(RateCap, PassesWhatIsNotFaster) {
  for (const double rate_hz : {24.0, 59.94, 60.0, 100.0, 119.88, 120.0}) {
    RateCap cap(120);
    EXPECT_EQ(Admitted(cap, rate_hz, 1200).size(), 1200U) << rate_hz;
  }
}

TEST(RateCap, ThinsAMultipleEvenly) {
  for (const auto& [rate_hz, cap_hz] :
       {std::pair{240.0, 120.0}, std::pair{120.0, 60.0}, std::pair{240.0, 60.0}}) {
    RateCap cap(cap_hz);
    const auto taken = Admitted(cap, rate_hz, 2400);
    EXPECT_EQ(taken.size(), static_cast<std::size_t>(2400 * cap_hz / rate_hz));
    for (std::size_t i = 1; i < taken.size(); ++i) {
      EXPECT_NEAR(static_cast<double>(taken[i] - taken[i - 1]), 1e9 / cap_hz, 2) << i;
    }
  }
}

TEST(RateCap, KeepsTheMeanWhereTheRatesDoNotDivide) {
  RateCap cap(90);
  EXPECT_NEAR(static_cast<double>(Admitted(cap, 120, 1200).size()), 900, 2);
}

TEST(RateCap, PassesAJitteringStreamOfItsOwnRate) {
  RateCap cap(120);
  std::mt19937 random(1);
  int taken = 0;
  for (int i = 0; i < 1200; ++i) {
    const std::int64_t at_ns = i * kSecond_ns / 120;
    const auto late_ns = static_cast<std::int64_t>(random() % 6'000'000);
    if (cap.Admit(static_cast<std::uint64_t>(at_ns), at_ns + late_ns + 1)) ++taken;
  }
  EXPECT_EQ(taken, 1200);
}

// A recording played at full speed: source time says 120 Hz, arrival says otherwise.
TEST(RateCap, HoldsAgainstAReplayFasterThanLife) {
  RateCap cap(120);
  int taken = 0;
  for (int i = 0; i < 12000; ++i) {
    const std::uint64_t source_ns = static_cast<std::uint64_t>(i) * kSecond_ns / 120;
    if (cap.Admit(source_ns, 1 + i * kSecond_ns / 6000)) ++taken;  // 2 s in all
  }
  EXPECT_LE(taken, 2 * 150 + 4);
  EXPECT_GE(taken, 290);
}

TEST(RateCap, BeginsAnewWhereTheSourceDoes) {
  RateCap cap(60);
  EXPECT_TRUE(cap.Admit(9'000'000'000, 1));
  EXPECT_FALSE(cap.Admit(9'004'000'000, 4'000'000));
  EXPECT_TRUE(cap.Admit(1'000'000, 20'000'000));
  EXPECT_TRUE(cap.Admit(8'000'000'000, 40'000'000));
}

TEST(Timeline, IsTheSourcesClockFromTheFirstFrameOn) {
  Timeline timeline;
  EXPECT_EQ(timeline.Seconds(77'000'000'000, 5), 0);
  EXPECT_FLOAT_EQ(timeline.Seconds(77'008'000'000, 3'000'000), 0.008F);
  EXPECT_FLOAT_EQ(timeline.Seconds(77'508'000'000, 400'000'000), 0.508F);
}

TEST(Timeline, GoesOnOverARestartAndAJump) {
  Timeline timeline;
  timeline.Seconds(77'000'000'000, 0);
  EXPECT_FLOAT_EQ(timeline.Seconds(1'000'000, 2 * kSecond_ns), 2);
  EXPECT_FLOAT_EQ(timeline.Seconds(11'000'000, 2 * kSecond_ns + 9'000'000), 2.01F);
  EXPECT_FLOAT_EQ(timeline.Seconds(900'011'000'000, 3 * kSecond_ns + 9'000'000), 3.01F);
  const float before = timeline.Seconds(900'021'000'000, 3 * kSecond_ns + 9'000'000);
  EXPECT_GT(timeline.Seconds(900'021'000'000, 3 * kSecond_ns + 9'000'000), before);
}

}  // namespace
}  // namespace styled::stylevmc
