#include "daemon/source/delay.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <deque>

#include "daemon/source/native_decoder.h"
#include "tests/support/rig.h"

namespace styled::source {
namespace {

using runtime::kMillisecond_ns;
using support::Bytes;
using support::Rig;

struct FakeClock final : runtime::Clock {
  std::int64_t now_ns = 1'000'000'000;
  std::int64_t Now_ns() const noexcept override { return now_ns; }
  std::int64_t Wall_ns() const noexcept override { return now_ns; }
};

// Delivers each datagram at its time.
struct Network final : Transport {
  struct Packet {
    std::int64_t arrives_ns;
    Bytes bytes;
  };
  explicit Network(const FakeClock& the_clock) : clock(the_clock) {}
  int DoWork(Receiver& receiver) override {
    int work = 0;
    while (!packets.empty() && packets.front().arrives_ns <= clock.now_ns) {
      const std::span<const std::byte> one(packets.front().bytes);
      decoder.HandOn({&one, 1}, {}, receiver);
      packets.pop_front();
      ++work;
    }
    return work;
  }
  std::int64_t NextDeadline_ns() const override {
    return packets.empty() ? std::numeric_limits<std::int64_t>::max() : packets.front().arrives_ns;
  }
  int fd() const override { return -1; }
  const std::string& endpoint() const override { return name; }
  std::uint64_t received() const override { return 0; }

  const FakeClock& clock;
  runtime::Counters counters;
  NativeDecoder decoder{3, counters};
  std::deque<Packet> packets;
  std::string name = "here";
};

struct DelayTest : testing::Test, Receiver {
  struct Seen {
    std::int64_t at_ns;
    std::uint64_t sequence;
    bool is_body;
  };
  void OnFrames(int source, std::span<const SourceFrame> frames, bool) override {
    EXPECT_EQ(source, 3);
    EXPECT_LE(frames.size(), kBatch);
    for (const SourceFrame& frame : frames) {
      seen.push_back({clock.now_ns, frame.sequence, frame.is_body});
    }
  }
  void Arrives(std::int64_t after_ns, Bytes bytes) {
    network->packets.push_back({begin_ns + after_ns, std::move(bytes)});
  }
  // As the pipeline's thread does it.
  void Run() {
    std::stable_sort(network->packets.begin(), network->packets.end(),
                     [](const auto& a, const auto& b) { return a.arrives_ns < b.arrives_ns; });
    while (true) {
      while (delayed->DoWork(*this) > 0) {
      }
      const std::int64_t next_ns = delayed->NextDeadline_ns();
      if (next_ns == std::numeric_limits<std::int64_t>::max()) return;
      ASSERT_GT(next_ns, clock.now_ns);
      clock.now_ns = next_ns;
    }
  }

  FakeClock clock;
  const std::int64_t begin_ns = clock.now_ns;
  Network* const network = new Network(clock);  // owned by `delayed`
  const std::unique_ptr<Transport> delayed =
      MakeDelayed(std::unique_ptr<Transport>(network), 0.05F, clock);
  Rig rig{"anna"};
  std::vector<Seen> seen;
};

constexpr std::int64_t kPeriod_ns = 1'000'000'000 / 120;

TEST_F(DelayTest, BurstsAreDeliveredEvenly) {
  Arrives(0, rig.Body());
  constexpr int kFrames = 240;
  for (int i = 0; i < kFrames; ++i) {  // five at a time
    Arrives((i / 5 + 1) * 5 * kPeriod_ns, rig.Frame());
  }
  Run();
  ASSERT_EQ(seen.size(), kFrames + 1U);
  EXPECT_TRUE(seen[0].is_body);
  for (std::size_t i = 20; i < seen.size(); ++i) {
    EXPECT_EQ(seen[i].sequence, i);
    EXPECT_NEAR(static_cast<double>(seen[i].at_ns - seen[i - 1].at_ns), kPeriod_ns, 1000) << i;
  }
  const Smoothing shown = delayed->smoothing();
  EXPECT_FLOAT_EQ(shown.delay_ms, 50);
  EXPECT_NEAR(shown.arrived_ms, 4 * kPeriod_ns * 1e-6, 3);
  EXPECT_LT(shown.left_ms, 0.1);
  EXPECT_EQ(shown.missed, 0U);
}

TEST_F(DelayTest, ReorderedFramesLeaveInOrder) {
  for (int i = 0; i < 60; ++i) {
    if (i % 10 == 2 && i > 2)
      Arrives(i * kPeriod_ns - 1, rig.Body());  // overtakes the late frame before it
    Arrives(i * kPeriod_ns + (i % 3 == 1 ? 2 * kPeriod_ns : 0), rig.Frame());
  }
  Run();
  ASSERT_EQ(seen.size(), 65U);
  for (std::size_t i = 0; i < seen.size(); ++i) EXPECT_EQ(seen[i].sequence, i);
}

TEST_F(DelayTest, ALateDatagramIsDeliveredAtOnceAndCounted) {
  Arrives(0, rig.Body());
  for (int i = 0; i < 240; ++i) {
    Arrives(i * kPeriod_ns + (i == 30 ? 80 * kMillisecond_ns : 0), rig.Frame());
  }
  Run();
  const auto late =
      std::find_if(seen.begin(), seen.end(), [](const Seen& s) { return s.sequence == 31; });
  ASSERT_NE(late, seen.end());
  EXPECT_EQ(late->at_ns, begin_ns + 30 * kPeriod_ns + 80 * kMillisecond_ns);
  EXPECT_EQ(delayed->smoothing().missed, 1U);
}

TEST_F(DelayTest, ANewSessionOrAClockSetBackRestartsTheDelay) {
  for (int i = 0; i < 30; ++i) Arrives(i * kPeriod_ns, rig.Frame());
  rig.session = 9;
  rig.time_ns = 5;
  for (int i = 30; i < 60; ++i) Arrives(i * kPeriod_ns, rig.Frame());
  rig.time_ns += 3'600'000'000'000;
  for (int i = 60; i < 90; ++i) Arrives(i * kPeriod_ns, rig.Frame());
  rig.time_ns -= 3'600'000'000'000;
  for (int i = 90; i < 120; ++i) Arrives(i * kPeriod_ns, rig.Frame());
  Run();
  ASSERT_EQ(seen.size(), 120U);
  for (std::size_t i = 0; i < seen.size(); ++i) {
    EXPECT_LE(seen[i].at_ns - begin_ns, static_cast<std::int64_t>(i) * kPeriod_ns + 51'000'000);
  }
  EXPECT_GT(seen.back().at_ns - begin_ns, 119 * kPeriod_ns + 49'000'000);
}

TEST_F(DelayTest, GarbageIsCountedAndAFloodLosesNothing) {
  Arrives(0, Bytes(17));
  for (int i = 0; i < 3000; ++i) Arrives(kMillisecond_ns, rig.Frame());
  Run();
  EXPECT_EQ(network->counters.Get(runtime::Counter::kSourceTooShort), 1U);
  ASSERT_EQ(seen.size(), 3000U);
  for (std::size_t i = 0; i < seen.size(); ++i) EXPECT_EQ(seen[i].sequence, i);
}

}  // namespace
}  // namespace styled::source
