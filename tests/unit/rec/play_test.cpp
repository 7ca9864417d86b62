#include "clients/rec/play.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "tests/unit/rec/fakes.h"

namespace styled::rec {
namespace {

using ::testing::ElementsAre;
using testing::FakeClock;
using ::testing::HasSubstr;
using testing::kMillisecond_ns;
using testing::kSecond_ns;

// Notes what it was given and when, in milliseconds since the start.
class FakeOutlet final : public Outlet {
 public:
  explicit FakeOutlet(FakeClock& clock) : clock_(clock), start_ns_(clock.now_ns) {}
  void Note(const recording::Record& record) override { noted.push_back(record.note().text()); }
  Status Play(const recording::Record& record) override {
    taken.push_back(record.note().text());
    at_ms.push_back((clock_.now_ns - start_ns_) / kMillisecond_ns);
    clock_.now_ns += cost_ns;
    if (stop != nullptr && static_cast<int>(taken.size()) == stop_after) *stop = true;
    return record.note().text() == fail_at ? Status::Error("the cable is out") : Status::Ok();
  }
  void Idle() override { ++idles; }
  void Restart() override { ++restarts; }
  void Finish() override { ++finishes; }

  std::vector<std::string> noted, taken;
  std::vector<std::int64_t> at_ms;
  std::int64_t cost_ns = 0;
  std::string fail_at;
  std::atomic<bool>* stop = nullptr;
  int stop_after = 0, idles = 0, restarts = 0, finishes = 0;

 private:
  FakeClock& clock_;
  std::int64_t start_ns_;
};

class PlayTest : public ::testing::Test {
 protected:
  // Notes "0", "1", ... at these times in ms, on some clock.
  static std::unique_ptr<recording::Reader> Records(const std::vector<int>& times_ms) {
    std::vector<recording::Record> records;
    for (const int time_ms : times_ms) {
      recording::Record record;
      record.set_time_ns(5 * kSecond_ns + time_ms * kMillisecond_ns);
      record.mutable_note()->set_text(std::to_string(records.size()));
      records.push_back(record);
    }
    return testing::MakeReader(records);
  }
  Status Run(const std::vector<int>& times_ms, const PlayOptions& options) {
    const auto reader = Records(times_ms);
    return Play(*reader, options, clock_, {&outlet_}, stop_, counts_);
  }

  FakeClock clock_;
  FakeOutlet outlet_{clock_};
  std::atomic<bool> stop_{false};
  PlayCounts counts_;
};

TEST_F(PlayTest, ARecordingWithoutRecordsAndABeginningBehindTheEndAreRefused) {
  EXPECT_THAT(Run({}, {}).message(), HasSubstr("test.styrec: found no records"));
  EXPECT_THAT(Run({0, 500}, {.from_s = 0.6}).message(),
              HasSubstr("found 0.5 s, expected --from within"));
}

TEST_F(PlayTest, EachRecordComesAtItsTime) {
  ASSERT_TRUE(Run({0, 10, 500}, {}).ok());
  EXPECT_THAT(outlet_.at_ms, ElementsAre(0, 10, 500));
  EXPECT_EQ(counts_.records, 3U);
  EXPECT_EQ(counts_.seconds, 0.5);
  EXPECT_EQ(counts_.wall_ns, 500 * kMillisecond_ns);
  EXPECT_GE(outlet_.idles, 24) << "every 20 ms";
  EXPECT_EQ(outlet_.finishes, 1);
}

TEST_F(PlayTest, AtAnotherSpeedTimesAreDivided) {
  ASSERT_TRUE(Run({0, 10, 500}, {.speed = 0.5}).ok());
  EXPECT_THAT(outlet_.at_ms, ElementsAre(0, 20, 1000));
}

TEST_F(PlayTest, FlatOutNothingIsWaitedFor) {
  ASSERT_TRUE(Run({0, 10, 5000}, {.speed = std::numeric_limits<double>::infinity()}).ok());
  EXPECT_THAT(outlet_.at_ms, ElementsAre(0, 0, 0));
  EXPECT_EQ(clock_.slept_ns, 0);
}

TEST_F(PlayTest, WhatIsOverdueComesAtOnceAndNothingIsSkipped) {
  outlet_.cost_ns = 15 * kMillisecond_ns;
  ASSERT_TRUE(Run({0, 10, 20, 30, 100}, {}).ok());
  EXPECT_THAT(outlet_.at_ms, ElementsAre(0, 15, 30, 45, 100));
  EXPECT_EQ(counts_.most_late_ns, 15 * kMillisecond_ns);
}

TEST_F(PlayTest, TimesThatGoBackALittleAreKeptInTheFilesOrder) {
  ASSERT_TRUE(Run({0, 20, 10, 30}, {}).ok());
  EXPECT_THAT(outlet_.taken, ElementsAre("0", "1", "2", "3"));
  EXPECT_THAT(outlet_.at_ms, ElementsAre(0, 20, 20, 30));
}

TEST_F(PlayTest, APartIsPlayedAtOnceAndWhatIsBeforeItNoted) {
  ASSERT_TRUE(Run({0, 100, 200, 300, 400}, {.from_s = 0.2, .until_s = 0.3}).ok());
  EXPECT_THAT(outlet_.noted, ElementsAre("0", "1"));
  EXPECT_THAT(outlet_.taken, ElementsAre("2", "3"));
  EXPECT_THAT(outlet_.at_ms, ElementsAre(0, 100));
  EXPECT_NEAR(counts_.seconds, 0.1, 1e-9);
}

TEST_F(PlayTest, ALoopBeginsAgainUntilItIsStopped) {
  outlet_.stop = &stop_;
  outlet_.stop_after = 5;
  ASSERT_TRUE(Run({0, 100}, {.loop = true}).ok());
  EXPECT_THAT(outlet_.taken, ElementsAre("0", "1", "0", "1", "0"));
  EXPECT_EQ(outlet_.restarts, 2);
  EXPECT_EQ(counts_.passes, 3U);
  EXPECT_EQ(outlet_.finishes, 1);
}

TEST_F(PlayTest, AnOutletsErrorEndsItUnlessASignalCameFirst) {
  outlet_.fail_at = "1";
  EXPECT_EQ(Run({0, 1, 2}, {.loop = true}).message(), "the cable is out");
  EXPECT_THAT(outlet_.taken, ElementsAre("0", "1"));
  outlet_.stop = &stop_;
  outlet_.stop_after = 4;
  EXPECT_TRUE(Run({0, 1, 2}, {.loop = true}).ok()) << "what a signal interrupted is no error";
}

}  // namespace
}  // namespace styled::rec
