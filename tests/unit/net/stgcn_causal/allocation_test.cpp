// Start and Step allocate nothing, from the first frame on. That the count sees allocations at all
// is tests/unit/net/erd/allocation_test.cpp's.
#include <gtest/gtest.h>

#include "model/net/load.h"
#include "tests/support/count_new.h"
#include "tests/unit/net/stgcn_causal/random_weights.h"

namespace styled::stgcn_causal {
namespace {

TEST(CausalAllocations, NoneInStartAndStep) {
  const auto stylizer = net::Parse(RandomWeights(8, 32, 1).Bytes(), "random");
  ASSERT_TRUE(stylizer.ok()) << stylizer.status().message();
  const std::vector<net::StyleWeight> mix{{1, 0.3F}, {2, 0.3F}, {3, 0.2F}, {4, 0.1F}};
  const std::vector<net::StyleWeight> other{{5, 1.0F}, {2, 0.0F}};
  const std::vector<net::VariationWeight> variations{{7, 0.5F}, {99, 0.9F}};
  const body::Pose pose;
  const auto stream = stylizer.value()->MakeStream();
  net::Prediction out;
  const auto step = [&](int input_style, std::span<const net::StyleWeight> styles) {
    const net::StepJob job{&pose, input_style, styles, stream.get(), &out, variations};
    stylizer.value()->Step({&job, 1});
  };
  const support::CountNew count;
  for (int repeat = 0; repeat < 2; ++repeat) {
    for (int frame = 0; frame < 120; ++frame) step(0, {});  // until the second decoder follows
    for (int frame = 0; frame < 10; ++frame) step(0, mix);
    for (int frame = 0; frame < 10; ++frame) step(6, other);
    stylizer.value()->Start(*stream);
    step(0, mix);
  }
  EXPECT_EQ(count.calls(), 0);
}

TEST(CausalAllocations, AStreamIsMadeByAllocating) {
  const auto stylizer = net::Parse(RandomWeights(2, 16, 1).Bytes(), "random");
  ASSERT_TRUE(stylizer.ok()) << stylizer.status().message();
  const support::CountNew count;
  const auto stream = stylizer.value()->MakeStream();
  EXPECT_GE(count.calls(), 2);
}

}  // namespace
}  // namespace styled::stgcn_causal
