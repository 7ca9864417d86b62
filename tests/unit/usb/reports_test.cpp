#include "daemon/source/usb/reports.h"

#include <gtest/gtest.h>
#include <poll.h>

#include <thread>
#include <vector>

namespace styled::source::usb {
namespace {

using runtime::Counter;

class FakeClock final : public runtime::Clock {
 public:
  std::int64_t Now_ns() const noexcept override { return now_ns; }
  std::int64_t Wall_ns() const noexcept override { return 0; }
  std::int64_t now_ns = 0;
};

bool Readable(int fd) {
  pollfd waiting{fd, POLLIN, 0};
  return poll(&waiting, 1, 0) == 1;
}

std::vector<std::byte> Bytes(std::size_t size, int value) {
  return std::vector<std::byte>(size, static_cast<std::byte>(value));
}

TEST(ReportsTest, NothingIsPoppedWhereNothingWasPushed) {
  FakeClock clock;
  runtime::Counters counters;
  Reports reports(clock, counters);
  Reports::Report report;
  EXPECT_FALSE(reports.Pop(report));
  EXPECT_FALSE(Readable(reports.fd()));
}

TEST(ReportsTest, ReportsBeyondAFullRingAreCountedAndTheOthersStayInOrder) {
  FakeClock clock;
  runtime::Counters counters;
  Reports reports(clock, counters, 1024);
  for (int i = 0; i < 100; ++i) reports.PushData(1, Bytes(64, i));
  const std::uint64_t dropped = counters.Get(Counter::kUsbRingFull);
  EXPECT_GT(dropped, 0U);
  reports.PushNote("what is no data is not counted when there is no room");
  EXPECT_EQ(counters.Get(Counter::kUsbRingFull), dropped);
  Reports::Report report;
  int popped = 0;
  for (; reports.Pop(report); ++popped) {
    EXPECT_EQ(report.bytes[0], static_cast<std::byte>(popped));
  }
  EXPECT_EQ(static_cast<std::uint64_t>(popped) + dropped, 100U);
  reports.PushData(1, Bytes(64, 7));
  EXPECT_TRUE(reports.Pop(report)) << "there is room again";
}

TEST(ReportsTest, AReportCarriesItsDeviceAndTheTimeOfItsArrival) {
  FakeClock clock;
  runtime::Counters counters;
  Reports reports(clock, counters);
  clock.now_ns = 5;
  reports.PushData(3, Bytes(64, 1));
  clock.now_ns = 6;
  reports.PushNote("opened");
  reports.PushData(4, {});
  EXPECT_TRUE(Readable(reports.fd()));
  reports.Clear();
  EXPECT_FALSE(Readable(reports.fd()));

  Reports::Report report;
  ASSERT_TRUE(reports.Pop(report));
  EXPECT_FALSE(report.is_note);
  EXPECT_EQ(report.device, 3U);
  EXPECT_EQ(report.arrival_ns, 5);
  EXPECT_EQ(report.bytes.size(), 64U);
  ASSERT_TRUE(reports.Pop(report));
  EXPECT_TRUE(report.is_note);
  EXPECT_EQ(std::string(reinterpret_cast<const char*>(report.bytes.data()), report.bytes.size()),
            "opened");
  ASSERT_TRUE(reports.Pop(report));
  EXPECT_EQ(report.device, 4U);
  EXPECT_EQ(report.arrival_ns, 6);
  EXPECT_TRUE(report.bytes.empty());
  EXPECT_FALSE(reports.Pop(report));
}

TEST(ReportsTest, TwoThreadsLoseNothingAndWakeEachOther) {
  FakeClock clock;
  runtime::Counters counters;
  Reports reports(clock, counters);
  constexpr int kCount = 20000;
  std::thread usb([&reports] {
    for (int i = 0; i < kCount; ++i) {
      reports.PushData(static_cast<std::uint32_t>(i), Bytes(static_cast<std::size_t>(i % 65), i));
      if (i % 1000 == 999) std::this_thread::yield();
    }
  });
  std::uint32_t next = 0;
  Reports::Report report;
  while (next + counters.Get(Counter::kUsbRingFull) < kCount) {
    pollfd waiting{reports.fd(), POLLIN, 0};
    if (poll(&waiting, 1, 10000) != 1) break;  // a wake-up was lost
    reports.Clear();
    while (reports.Pop(report)) {
      if (counters.Get(Counter::kUsbRingFull) == 0) {
        EXPECT_EQ(report.device, next);
      }
      EXPECT_EQ(report.bytes.size(), report.device % 65);
      ++next;
    }
  }
  usb.join();
  EXPECT_EQ(next + counters.Get(Counter::kUsbRingFull), static_cast<std::uint64_t>(kCount));
}

}  // namespace
}  // namespace styled::source::usb
