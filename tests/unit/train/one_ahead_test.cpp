#include "model/train/one_ahead.h"

#include <gtest/gtest.h>

#include <atomic>

namespace styled::train {
namespace {

// The batches and the sampler's states after them are the same, whether or not one is made ahead.
TEST(OneAheadTest, ReturnsTheSameBatchesInOrder) {
  for (const bool ahead : {false, true}) {
    std::atomic<int> made = 0;
    OneAhead<int64_t> batches(ahead, [&made](int64_t iteration) {
      ++made;
      return OneAhead<int64_t>::Made{10 * iteration, std::to_string(iteration)};
    });
    EXPECT_EQ(batches.sampler(), "");
    for (int64_t i = 5; i < 8; ++i) {
      EXPECT_EQ(batches.Next(i), 10 * i);
      EXPECT_EQ(batches.sampler(), std::to_string(i)) << "not of the one that is made ahead";
    }
    if (!ahead) EXPECT_EQ(made, 3);
  }
}

TEST(OneAheadTest, AnErrorReachesNext) {
  OneAhead<int> batches(true, [](int64_t iteration) -> OneAhead<int>::Made {
    if (iteration == 1) throw std::runtime_error("no clips");
    return {1, ""};
  });
  EXPECT_EQ(batches.Next(0), 1);
  EXPECT_THROW(batches.Next(1), std::runtime_error);
}

}  // namespace
}  // namespace styled::train
