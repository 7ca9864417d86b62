#include "daemon/source/arrival_clock.h"

#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <thread>
#include <vector>

#include "daemon/runtime/counters.h"
#include "daemon/runtime/wall_offset.h"
#include "daemon/source/tcp.h"
#include "daemon/source/udp_socket.h"
#include "tests/support/rig.h"

namespace styled::source {
namespace {

using runtime::kMillisecond_ns;
using runtime::kSecond_ns;

// A clock whose two sides the test moves. `between_ns` passes once, between the first two readings.
class TwoClocks final : public runtime::Clock {
 public:
  std::int64_t Now_ns() const noexcept override { return now_ns; }
  std::int64_t Wall_ns() const noexcept override {
    const std::int64_t wall_ns = now_ns + offset_ns;
    now_ns += std::exchange(between_ns, 0);
    return wall_ns;
  }
  mutable std::int64_t now_ns = 1000 * kSecond_ns;
  std::int64_t offset_ns = 1'700'000'000 * kSecond_ns;
  mutable std::int64_t between_ns = 0;
};

class ArrivalClockTest : public testing::Test {
 protected:
  ArrivalClockTest() { Read(true); }
  void Read(bool drained) {
    arrivals_.Begin(clock_.now_ns);
    arrivals_.Received(clock_);
    arrivals_.End(drained);
  }
  // How long ago the datagram arrived that the kernel stamped `stamp_ns`, read now.
  std::int64_t AgeOf(std::int64_t stamp_ns) {
    arrivals_.Begin(clock_.now_ns);
    arrivals_.Received(clock_);
    const std::int64_t arrival_ns = arrivals_.Arrival_ns(stamp_ns);
    arrivals_.End(true);
    return clock_.now_ns - arrival_ns;
  }
  std::int64_t Wall() const { return clock_.now_ns + clock_.offset_ns; }

  TwoClocks clock_;
  ArrivalClock arrivals_;
};

TEST_F(ArrivalClockTest, ADatagramThatWaitedHasItsOwnTime) {
  const std::int64_t stamp_ns = Wall();
  clock_.now_ns += 22 * kMillisecond_ns;
  EXPECT_EQ(AgeOf(stamp_ns), 22 * kMillisecond_ns);
}

TEST_F(ArrivalClockTest, ADatagramThatWaitedForSecondsHasItsOwnTime) {
  const std::int64_t stamp_ns = Wall();
  clock_.now_ns += 3 * kSecond_ns;
  EXPECT_EQ(AgeOf(stamp_ns), 3 * kSecond_ns);
}

TEST_F(ArrivalClockTest, AWallClockThatIsSetWhileItWaitsChangesNothing) {
  for (const std::int64_t step_ns :
       {3600 * kSecond_ns, -3600 * kSecond_ns, kSecond_ns, -kSecond_ns}) {
    clock_.now_ns += 8 * kMillisecond_ns;
    const std::int64_t before_ns = Wall();
    clock_.now_ns += 10 * kMillisecond_ns;
    clock_.offset_ns += step_ns;
    const std::int64_t after_ns = Wall();
    clock_.now_ns += 12 * kMillisecond_ns;
    EXPECT_EQ(AgeOf(before_ns), 22 * kMillisecond_ns) << step_ns;
    EXPECT_EQ(AgeOf(after_ns), 0) << step_ns << ": read before already";
    clock_.now_ns += 12 * kMillisecond_ns;
    EXPECT_EQ(AgeOf(Wall() - 5 * kMillisecond_ns), 5 * kMillisecond_ns) << step_ns;
  }
}

TEST_F(ArrivalClockTest, AStampBeforeTheSocketWasEmptyIsNotBelieved) {
  clock_.now_ns += 100 * kMillisecond_ns;
  Read(true);
  clock_.now_ns += kMillisecond_ns;
  EXPECT_EQ(AgeOf(Wall() - 50 * kMillisecond_ns), 0);
  EXPECT_EQ(AgeOf(Wall() + kSecond_ns), 0) << "nor one of the future";
}

TEST_F(ArrivalClockTest, DatagramsAfterAFullBatchMayBeOlder) {
  const std::int64_t stamp_ns = Wall();
  clock_.now_ns += 100 * kMillisecond_ns;
  Read(false);
  clock_.now_ns += 10 * kMillisecond_ns;
  EXPECT_EQ(AgeOf(stamp_ns), 110 * kMillisecond_ns);
}

TEST(WallWatchTest, AnInterruptionBetweenReadingsIsNotAStep) {
  TwoClocks clock;
  runtime::WallWatch watch;
  EXPECT_EQ(watch.Look(clock), 0) << "the first look has nothing to compare with";
  clock.between_ns = 22 * kMillisecond_ns;
  EXPECT_EQ(watch.Look(clock), 0);
}

TEST(WallWatchTest, AStepIsReportedOnceAndSmallOnesAddUp) {
  TwoClocks clock;
  runtime::WallWatch watch;
  EXPECT_EQ(watch.Look(clock), 0);
  clock.offset_ns -= 3 * kSecond_ns;
  EXPECT_EQ(watch.Look(clock), -3 * kSecond_ns);
  EXPECT_EQ(watch.Look(clock), 0);
  clock.offset_ns += 4 * kMillisecond_ns;
  EXPECT_EQ(watch.Look(clock), 0);
  clock.offset_ns += 4 * kMillisecond_ns;
  EXPECT_EQ(watch.Look(clock), 8 * kMillisecond_ns);
}

class UdpSocketTest : public testing::Test {
 protected:
  static constexpr int kSource = 3;
  UdpSocket Open(int buffer_bytes) {
    auto socket = runtime::BindSocket(SOCK_DGRAM, "127.0.0.1:0", buffer_bytes);
    EXPECT_TRUE(socket.ok());
    return {std::move(socket.value()), kSource, clock_, counters_, 0};
  }
  // A kernel that stamped nothing before begins some time after the first socket asks for it; until
  // then it tells the time of reading.
  void AwaitStamps(UdpSocket& socket, const support::UdpLink& link) {
    constexpr auto kWait = std::chrono::milliseconds(20);
    for (int tries = 0; tries < 100; ++tries) {
      link.Send(support::Bytes(10));
      std::this_thread::sleep_for(kWait);
      const std::int64_t read_ns = clock_.Now_ns();
      ASSERT_EQ(socket.Receive().size(), 1U);
      if (socket.arrived_ns(0) < read_ns - kWait / std::chrono::nanoseconds(2)) return;
    }
    FAIL() << "the kernel stamps no datagram";
  }
  runtime::SystemClock clock_;
  runtime::Counters counters_;
};

TEST_F(UdpSocketTest, ADatagramHasTheKernelsArrivalTime) {
  UdpSocket socket = Open(1 << 20);
  const support::UdpLink link(socket.endpoint());
  EXPECT_TRUE(socket.Receive().empty());
  AwaitStamps(socket, link);
  for (const int wait_ms : {0, 30, 250}) {
    const std::int64_t before_ns = clock_.Now_ns();
    link.Send(support::Bytes(10));
    const std::int64_t after_ns = clock_.Now_ns();
    std::this_thread::sleep_for(std::chrono::milliseconds(wait_ms));
    ASSERT_EQ(socket.Receive().size(), 1U);
    // Both clocks are read within 20 us of each other, or as near as the machine lets them.
    EXPECT_GE(socket.arrived_ns(0), before_ns - kMillisecond_ns) << wait_ms;
    EXPECT_LE(socket.arrived_ns(0), after_ns + kMillisecond_ns) << wait_ms;
  }
}

// Of a stream the kernel tells when the last byte arrived; what waited before it is as much older
// as the rig took it earlier.
class TcpArrivalTest : public testing::Test, public Receiver {
 protected:
  void OnFrames(int /*source*/, std::span<const SourceFrame> frames, bool /*more*/) override {
    for (const SourceFrame& frame : frames) {
      if (!frame.is_body) arrivals_ns_.push_back(frame.arrival_ns);
    }
  }
  std::int64_t Send(const support::TcpLink& link, support::Rig& rig) {
    rig.time_ns = static_cast<std::uint64_t>(clock_.Now_ns());
    link.Send(rig.Frame());
    const std::int64_t sent_ns = clock_.Now_ns();
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
    return sent_ns;
  }
  void Read(Transport& transport) {
    while (transport.DoWork(*this) > 0) {
    }
  }
  runtime::SystemClock clock_;
  runtime::Counters counters_;
  std::vector<std::int64_t> arrivals_ns_;
};

TEST_F(TcpArrivalTest, DatagramsThatWaitedForADelayedLoopAreNotNew) {
  config::Source config;
  config.name = "rig";
  config.type = "tcp";
  config.listen = "127.0.0.1:0";
  auto made = MakeTcp(config, 0, clock_, counters_, nullptr);
  ASSERT_TRUE(made.ok()) << made.status().message();
  Transport& transport = *made.value();
  const support::TcpLink link(transport.endpoint());
  support::Rig rig("a");
  Read(transport);
  // The sender may be interrupted, too, between its clock and the socket. Not ten times.
  for (int tries = 0; tries < 10; ++tries) {
    (void)Send(link, rig);  // and reads until nothing waits
    Read(transport);
    arrivals_ns_.clear();
    std::array<std::int64_t, 4> sent_ns{};
    for (std::int64_t& sent : sent_ns) sent = Send(link, rig);
    std::this_thread::sleep_for(std::chrono::milliseconds(30));
    const std::int64_t read_ns = clock_.Now_ns();
    Read(transport);
    ASSERT_EQ(arrivals_ns_.size(), sent_ns.size());
    bool as_sent = true;
    for (std::size_t i = 0; i < sent_ns.size(); ++i) {
      as_sent = as_sent && std::abs(arrivals_ns_[i] - sent_ns[i]) < 3 * kMillisecond_ns;
      ASSERT_LE(arrivals_ns_[i], clock_.Now_ns());
    }
    if (as_sent) return;
    std::printf("read %.1f ms after the last was sent; arrivals off by",
                1e-6 * static_cast<double>(read_ns - sent_ns.back()));
    for (std::size_t i = 0; i < sent_ns.size(); ++i) {
      std::printf(" %.1f", 1e-6 * static_cast<double>(arrivals_ns_[i] - sent_ns[i]));
    }
    std::printf(" ms\n");
  }
  FAIL() << "never as they were sent";
}

// Each datagram reports the drops before it, so the last ones of a burst are not reported.
TEST_F(UdpSocketTest, TheKernelsLastDropsAreCountedToo) {
  UdpSocket socket = Open(4096);
  const support::UdpLink link(socket.endpoint());
  constexpr int kSent = 200;
  for (int i = 0; i < kSent; ++i) link.Send(support::Bytes(500));
  std::size_t received = 0;
  for (std::size_t more = 1; more > 0; received += more) more = socket.Receive().size();
  ASSERT_LT(received, kSent);
  const auto dropped = [this] { return counters_.Get(runtime::Counter::kSourceKernelDropped); };
  EXPECT_LT(dropped(), kSent - received) << "nothing told of the last ones";
  socket.ReadDrops();
  EXPECT_EQ(dropped(), kSent - received);
  EXPECT_EQ(socket.kernel_dropped(), kSent - received);
  EXPECT_EQ(counters_.ClearSources(runtime::Counter::kSourceKernelDropped), 1U << kSource);
  socket.ReadDrops();
  EXPECT_EQ(dropped(), kSent - received) << "counted once";
}

// Datagrams that were queued before the count was read carry an earlier one.
TEST_F(UdpSocketTest, DatagramsThatTellLessThanIsKnownCountNothing) {
  UdpSocket socket = Open(4096);
  const support::UdpLink link(socket.endpoint());
  const auto dropped = [this] { return counters_.Get(runtime::Counter::kSourceKernelDropped); };
  for (int i = 0; i < 100; ++i) link.Send(support::Bytes(500));
  socket.ReadDrops();
  const std::uint64_t known = dropped();
  ASSERT_GT(known, 0U);
  std::size_t received = 0;
  for (std::size_t more = 1; more > 0; received += more) more = socket.Receive().size();
  EXPECT_EQ(received + known, 100U);
  EXPECT_EQ(dropped(), known);
  link.Send(support::Bytes(500));
  ASSERT_EQ(socket.Receive().size(), 1U);
  EXPECT_EQ(dropped(), known);
}

}  // namespace
}  // namespace styled::source
