#include "daemon/runtime/sign_of_life.h"

#include <gtest/gtest.h>

#include <atomic>

#include "tests/support/datagrams.h"

namespace styled::runtime {
namespace {

TEST(SignOfLifeTest, IsGivenOnlyWhileTheThreadTurns) {
  support::Datagrams manager;
  std::atomic<std::uint64_t> turns{0};
  std::atomic<int> woken{0};
  std::atomic<bool> turns_when_woken{false};
  const SignOfLife sign(
      manager.path(), [&turns] { return turns.load(); },
      [&] {
        ++woken;
        if (turns_when_woken) ++turns;
      });
  EXPECT_EQ(manager.Next(0.7), std::nullopt) << "it has not turned yet";
  EXPECT_GT(woken, 1) << "an idle thread is asked to turn";
  turns = 1;
  EXPECT_EQ(manager.Next(5), "WATCHDOG=1");
  EXPECT_EQ(manager.Next(0.7), std::nullopt) << "one turn is one sign";
  turns_when_woken = true;
  EXPECT_EQ(manager.Next(5), "WATCHDOG=1");
  EXPECT_EQ(manager.Next(5), "WATCHDOG=1");
}

TEST(SignOfLifeTest, EndsAtOnce) {
  support::Datagrams manager;
  const auto begin = std::chrono::steady_clock::now();
  for (int i = 0; i < 20; ++i) {
    SignOfLife(
        manager.path(), [] { return std::uint64_t{0}; }, [] {});
  }
  // 20 looks would take 4 s.
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(2));
}

TEST(WatchdogAskedTest, IsAskedForByTheEnvironmentOfThisProcessAlone) {
  EXPECT_TRUE(WatchdogAsked("5000000", nullptr, 7));
  EXPECT_TRUE(WatchdogAsked("5000000", "7", 7));
  EXPECT_FALSE(WatchdogAsked("5000000", "8", 7));
  EXPECT_FALSE(WatchdogAsked(nullptr, "7", 7));
  EXPECT_FALSE(WatchdogAsked("0", nullptr, 7));
  EXPECT_FALSE(WatchdogAsked("soon", nullptr, 7));
}

}  // namespace
}  // namespace styled::runtime
