#include "daemon/runtime/helpers.h"

#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <mutex>
#include <set>
#include <thread>

namespace styled::runtime {
namespace {

// Of each part, how often it was done.
std::vector<int> DonePer(Helpers& helpers, int parts) {
  std::vector<std::atomic<int>> done(static_cast<std::size_t>(parts));
  helpers.Run(parts, [&](int part) { ++done[static_cast<std::size_t>(part)]; });
  return {done.begin(), done.end()};
}

TEST(HelpersTest, EachPartIsDoneOnceWhateverTheNumberOfHelpers) {
  for (const int count : {0, 1, 3}) {
    Helpers helpers(count);
    for (int run = 0; run < 2000; ++run) {
      const int parts = run % 9;
      EXPECT_EQ(DonePer(helpers, parts), std::vector<int>(static_cast<std::size_t>(parts), 1))
          << count << " helpers, run " << run;
    }
  }
}

TEST(HelpersTest, WhatAPartWroteIsSeenAfterRun) {
  Helpers helpers(2);
  std::array<int, 64> values{};
  for (int run = 1; run <= 2000; ++run) {
    helpers.Run(64, [&](int part) { values[static_cast<std::size_t>(part)] = run; });
    for (const int value : values) ASSERT_EQ(value, run);
  }
}

TEST(HelpersTest, AHelperTakesWhatTheOwnerLeaves) {
  Helpers helpers(1);
  std::array<std::thread::id, 2> threads;
  std::atomic<int> begun{0};
  // Neither part ends before both have begun, so two threads must do them.
  helpers.Run(2, [&](int part) {
    threads[static_cast<std::size_t>(part)] = std::this_thread::get_id();
    ++begun;
    while (begun < 2) std::this_thread::yield();
  });
  EXPECT_NE(threads[0], threads[1]);
}

TEST(HelpersTest, SleepingHelpersAreWoken) {
  Helpers helpers(3);
  for (int run = 0; run < 5; ++run) {
    std::this_thread::sleep_for(std::chrono::milliseconds(2));  // much longer than kPoll_us
    std::atomic<int> begun{0};
    helpers.Run(4, [&](int) {
      ++begun;
      while (begun < 4) std::this_thread::yield();
    });
    EXPECT_EQ(begun, 4);
  }
}

TEST(HelpersTest, EachHelperBeginsOnceWithItsNumber) {
  std::mutex mutex;
  std::multiset<int> numbers;
  {
    const Helpers helpers(3, [&](int number) {
      const std::scoped_lock lock(mutex);
      numbers.insert(number);
    });
    EXPECT_EQ(helpers.count(), 3);
  }
  EXPECT_EQ(numbers, (std::multiset<int>{0, 1, 2}));
}

}  // namespace
}  // namespace styled::runtime
