#include "model/base/flush_subnormals.h"

#include <gtest/gtest.h>

#include <limits>

namespace styled {
namespace {

TEST(FlushSubnormals, TinyNumbersAreZeroWhileItLivesAndNotAfterwards) {
  volatile float least = std::numeric_limits<float>::min(), half = 0.5F;
  volatile float product = least * half;
  EXPECT_GT(product, 0);
  {
    const FlushSubnormals flush;
    product = least * half;
    EXPECT_EQ(product, 0);
    // An operand that is one already counts as 0, too.
    volatile float subnormal = std::numeric_limits<float>::denorm_min(), large = 1e38F;
    product = subnormal * large;
    EXPECT_EQ(product, 0);
  }
  product = least * half;
  EXPECT_GT(product, 0);
}

}  // namespace
}  // namespace styled
