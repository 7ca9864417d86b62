#include "model/train/flags.h"

#include <gtest/gtest.h>

#include <limits>

namespace styled::train {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinite = std::numeric_limits<double>::infinity();

std::string Refused(double value, Range range) {
  return CheckRanges({{"Data", {{"--share", &value, range, "a share"}}}}).message();
}

TEST(FlagsTest, NumbersInTheirRangePass) {
  for (const double value : {0.0, 0.5, 1.0}) EXPECT_EQ(Refused(value, Range::k0To1), "") << value;
  for (const double value : {0.0, 7.0}) EXPECT_EQ(Refused(value, Range::kAtLeast0), "") << value;
  EXPECT_EQ(Refused(1, Range::kAtLeast1), "");
  EXPECT_EQ(Refused(kNaN, Range::kAny), "");
}

TEST(FlagsTest, OthersAreRefusedByName) {
  for (const double value : {-0.1, 1.1, kNaN}) EXPECT_NE(Refused(value, Range::k0To1), "") << value;
  for (const double value : {-0.1, kInfinite, kNaN}) {
    EXPECT_NE(Refused(value, Range::kAtLeast0), "") << value;
    EXPECT_NE(Refused(value, Range::kAtLeast1), "") << value;
  }
  EXPECT_EQ(Refused(2, Range::k0To1), "--share: found 2, expected a number from 0 to 1");
  EXPECT_EQ(Refused(-1, Range::kAtLeast0), "--share: found -1, expected a number, 0 or more");
  EXPECT_EQ(Refused(0, Range::kAtLeast1), "--share: found 0, expected 1 or more");
}

TEST(FlagsTest, WholeNumbersHaveRangesAndOthersNone) {
  int batch = 0;
  bool mirror = false;
  std::string precision = "auto";
  EXPECT_EQ(CheckRanges({{"Data", {{"--mirror", &mirror, Range::kAny, "mirror images"}}},
                         {"Schedule",
                          {{"--precision", &precision, Range::kAny, "of activations"},
                           {"--batch", &batch, Range::kAtLeast1, "windows"}}}})
                .message(),
            "--batch: found 0, expected 1 or more");
}

}  // namespace
}  // namespace styled::train
