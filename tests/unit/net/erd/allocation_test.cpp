// Start and Step allocate nothing.
#include <gtest/gtest.h>

#include <array>
#include <cstdlib>
#include <new>

#include "tests/support/count_new.h"
#include "tests/unit/net/erd/random_weights.h"

namespace styled::erd {
namespace {

template <typename Work>
int AllocationsIn(Work work) {
  const support::CountNew count;
  work();
  return count.calls();
}

void* volatile sink = nullptr;  // keeps an allocation from being optimized away

TEST(Allocations, ArePerceived) {
  EXPECT_GE(AllocationsIn([] {
              int* one = new int(1);
              sink = one;
              delete one;
            }),
            1);
  struct alignas(64) Line {
    char bytes[64];
  };
  EXPECT_GE(AllocationsIn([] {
              Line* line = new Line;
              sink = line;
              delete line;
            }),
            1);
  EXPECT_GE(AllocationsIn([] {
              const Eigen::MatrixXf matrix = Eigen::MatrixXf::Random(64, 64);
              sink = const_cast<float*>(matrix.data());
            }),
            1);
  if (support::CountNew::CountsMalloc()) {
    EXPECT_GE(AllocationsIn([] {
                sink = std::malloc(7);
                std::free(sink);
              }),
              1);
  }
}

TEST(Allocations, NoneInStartAndStep) {
  const auto network = RandomNetwork(8, 1);
  const std::vector<net::StyleWeight> mix{{1, 0.3F}, {2, 0.3F}, {3, 0.2F}, {4, 0.1F}};
  const std::vector<net::StyleWeight> other{{5, 1.0F}, {2, 0.0F}};
  Features features;
  features.fill(0.1F);
  State state;
  net::Prediction out;
  EXPECT_EQ(AllocationsIn([&] {
              network->Start(state);
              for (int frame = 0; frame < 50; ++frame) {
                network->Step(features, 0, {}, state, out);
                network->Step(features, 0, mix, state, out);
                network->Step(features, 6, other, state, out);
              }
            }),
            0);
}

TEST(Allocations, NoneWithContents) {
  const auto network = NetworkOf(RandomWeightsWithContents(8, 64, 1));
  const std::vector<net::StyleWeight> mix{{1, 0.5F}};
  Features features;
  features.fill(0.1F);
  State state;
  net::Prediction out;
  std::array<float, 64> shares;
  EXPECT_EQ(AllocationsIn([&] {
              for (const int content : {net::kContentRecognized, net::kContentUnknown, 3}) {
                network->Start(state);
                for (int frame = 0; frame < 50; ++frame) {
                  network->Step(features, 0, mix, state, out, content);
                  network->Recognized(state, shares);
                }
              }
            }),
            0);
}

}  // namespace
}  // namespace styled::erd
