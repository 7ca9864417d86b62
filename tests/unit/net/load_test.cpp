// Reading of the common part of any family's weights file.
#include "model/net/load.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/unit/net/erd/random_weights.h"

namespace styled::net {
namespace {

using testing::AllOf;
using testing::HasSubstr;

TEST(Load, AFileOfVersionOneIsOfStyleErd) {
  erd::WeightsFile file = erd::RandomWeights(3, 1);
  file.metadata["version"] = 1;
  file.metadata.erase("family");
  const auto network = Parse(file.Bytes(), "file");
  ASSERT_TRUE(network.ok()) << network.status().message();
  EXPECT_EQ(network.value()->model().family, "style-erd");
  EXPECT_EQ(network.value()->model().styles.size(), 3U);
}

TEST(Load, AFileOfVersionTwoNamesItsFamily) {
  erd::WeightsFile file = erd::RandomWeights(3, 1);
  ASSERT_TRUE(Parse(file.Bytes(), "file").ok());
  file.metadata.erase("family");
  EXPECT_EQ(Parse(file.Bytes(), "file").status().message(), "file: key 'family': missing");
}

TEST(Load, AnUnknownFamilyIsRefusedWithTheKnownOnes) {
  erd::WeightsFile file = erd::RandomWeights(3, 1);
  file.metadata["family"] = "transformer";
  EXPECT_THAT(Parse(file.Bytes(), "file").status().message(),
              AllOf(HasSubstr("file: key 'family': expected "), HasSubstr("\"style-erd\""),
                    HasSubstr("found \"transformer\"")));
}

TEST(Load, NamesTheFile) {
  EXPECT_THAT(Load("no/such/weights").status().message(),
              HasSubstr("no/such/weights: no such file"));
}

}  // namespace
}  // namespace styled::net
