#include "model/train/means.h"

#include <gtest/gtest.h>

namespace styled::train {
namespace {

TEST(MeansTest, AreOverTheIterationsThatHadThem) {
  Means means;
  means.Add("often", torch::tensor(1.0F));
  means.Add("once", torch::tensor(8.0F));
  means.Add("often", torch::tensor(2.0F));
  EXPECT_EQ(means.Pop(), (Figures{{"often", 1.5}, {"once", 8}}));
  EXPECT_TRUE(means.Pop().empty());
}

// Recorded work adds to the sums without a call of Add, as this test does by hand.
TEST(MeansTest, RecordedWorkIsCountedWhereItAdds) {
  Means means;
  means.KeepSums();
  const torch::Tensor value = torch::tensor(3.0F);
  const auto work = [&] { means.Add("loss", value); };
  work();
  EXPECT_EQ(means.NamesOf(work), std::vector<std::string>{"loss"});
  means.Count({"loss"});
  EXPECT_EQ(means.Pop(), (Figures{{"loss", 3}}));
  means.Count({"loss"});  // the sum is still there, and empty
  EXPECT_EQ(means.Pop(), (Figures{{"loss", 0}}));
  EXPECT_THROW(means.NamesOf([&] { means.Add("another", value); }), c10::Error)
      << "a sum that is not there cannot be recorded";
}

}  // namespace
}  // namespace styled::train
