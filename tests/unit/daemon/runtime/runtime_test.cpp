#include <gtest/gtest.h>

#include <memory>
#include <thread>

#include "daemon/runtime/counters.h"
#include "daemon/runtime/histogram.h"
#include "daemon/runtime/ring.h"

namespace styled::runtime {
namespace {

TEST(HistogramTest, PercentilesAreWithinSixPercentAndNeverAboveTheMaximum) {
  Histogram histogram;
  EXPECT_EQ(histogram.Percentile_us(0.5F), 0);
  for (int i = 1; i <= 1000; ++i) histogram.Add(i * 1000);
  EXPECT_NEAR(histogram.Percentile_us(0.5F), 500, 35);
  EXPECT_NEAR(histogram.Percentile_us(0.99F), 990, 65);
  EXPECT_FLOAT_EQ(histogram.Percentile_us(1), 1000);
  EXPECT_FLOAT_EQ(histogram.Max_us(), 1000);
  histogram.Add(-5);
  histogram.Add(INT64_MAX);
  EXPECT_GT(histogram.Percentile_us(1), 1e6F);
  histogram.Clear();
  EXPECT_EQ(histogram.count(), 0U);
}

TEST(RingTest, RefusesWhenFullAndKeepsOrderAcrossThreads) {
  Ring<std::unique_ptr<int>, 8> ring;
  for (int i = 0; i < 8; ++i) ASSERT_TRUE(ring.Push(std::make_unique<int>(i)));
  auto ninth = std::make_unique<int>(8);
  EXPECT_FALSE(ring.Push(std::move(ninth)));
  EXPECT_NE(ninth, nullptr) << "what was not taken is still the caller's";
  std::thread producer([&ring] {
    for (int i = 8; i < 5000;) {
      auto value = std::make_unique<int>(i);
      if (ring.Push(std::move(value))) {
        ++i;
      } else {
        std::this_thread::yield();
      }
    }
  });
  for (int expected = 0; expected < 5000;) {
    std::unique_ptr<int> value;
    if (!ring.Pop(value)) {
      std::this_thread::yield();
      continue;
    }
    ASSERT_EQ(*value, expected++);
  }
  producer.join();
}

TEST(CountersTest, EveryRefusalOfTheDecoderHasItsCounter) {
  for (int i = 1; i < static_cast<int>(native::DecodeResult::kCount); ++i) {
    const auto result = static_cast<native::DecodeResult>(i);
    EXPECT_EQ(Name(CounterOf(result)), "source." + std::string(native::Name(result)));
  }
}

}  // namespace
}  // namespace styled::runtime
