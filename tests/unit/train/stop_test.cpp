#include "model/train/stop.h"

#include <gtest/gtest.h>

#include <csignal>
#include <cstdlib>
#include <memory>

namespace styled::train {
namespace {

TEST(StopTest, ASignalAsksAndTheNextRunBeginsAnew) {
  for (const int signal : {SIGINT, SIGTERM}) {
    const StopOnSignal stop;
    EXPECT_EQ(StopSignal(), 0);
    std::raise(signal);
    EXPECT_EQ(StopSignal(), signal);
  }
  const StopOnSignal again;
  EXPECT_EQ(StopSignal(), 0);
}

TEST(StopTest, TheSecondSignalEndsTheProcess) {
  EXPECT_EXIT(
      {
        const StopOnSignal stop;
        std::raise(SIGTERM);
        std::raise(SIGTERM);
        std::exit(0);
      },
      testing::KilledBySignal(SIGTERM), "ends after this step");
}

TEST(StopTest, AfterwardsASignalDoesWhatItDidBefore) {
  EXPECT_EXIT(
      {
        std::make_unique<StopOnSignal>().reset();
        std::raise(SIGINT);
        std::exit(0);
      },
      testing::KilledBySignal(SIGINT), "");
}

}  // namespace
}  // namespace styled::train
