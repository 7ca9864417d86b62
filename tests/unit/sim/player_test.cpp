#include "sim/player/player.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "sim/player/stream.h"
#include "tests/unit/sim/fakes.h"

namespace styled::player {
namespace {

using testing::FakeClock;
using testing::FakeLink;
using testing::FakeMotion;

std::vector<std::unique_ptr<Sender>> Streams(int count, int frames, double rate_hz) {
  std::vector<std::unique_ptr<Sender>> streams;
  for (int k = 0; k < count; ++k) {
    streams.push_back(std::make_unique<Stream>(
        StreamOptions{"amy-" + std::to_string(k), rate_hz, [] { return std::uint64_t{1}; }},
        std::make_unique<FakeMotion>(frames), faults::Faults(faults::Spec{})));
  }
  return streams;
}

std::vector<std::int64_t> FrameTimes(const FakeLink& link, std::string_view performer) {
  std::vector<std::int64_t> times;
  const auto received = testing::Receive(link);
  for (std::size_t i = 0; i < received.size(); ++i) {
    if (received[i].is_frame() && received[i].frame.performer() == performer) {
      times.push_back(link.times_ns[i]);
    }
  }
  return times;
}

TEST(Player, SendsEveryFrameAtItsTimeWhateverASleepIsLate) {
  FakeClock clock;
  clock.oversleep_ns = 300'000;
  const std::int64_t start_ns = clock.now_ns;
  FakeLink link(&clock);
  Player player({120, 0}, Streams(1, 1200, 120));
  const std::atomic<bool> stop{false};
  ASSERT_TRUE(player.Run(clock, link, stop).ok());
  const auto times = FrameTimes(link, "amy-0");
  ASSERT_EQ(times.size(), 1200U);
  for (std::size_t i = 0; i < times.size(); ++i) {
    const double due_ns = static_cast<double>(start_ns) + static_cast<double>(i) * 1e9 / 120;
    EXPECT_GE(static_cast<double>(times[i]), due_ns - 1) << i;
    EXPECT_LE(static_cast<double>(times[i]), due_ns + 300'001) << i;
  }
  EXPECT_EQ(player.counts().late_ticks, 0U);
}

TEST(Player, AMissingReceiverIsReportedOnceAndCounted) {
  FakeClock clock;
  FakeLink link(&clock);
  link.refusing = true;
  int told = 0;
  Player player({120, 0, [&told] { ++told; }}, Streams(1, 100, 120));
  const std::atomic<bool> stop{false};
  ASSERT_TRUE(player.Run(clock, link, stop).ok());
  EXPECT_EQ(told, 1);
  EXPECT_EQ(FrameTimes(link, "amy-0").size(), 100U) << "it goes on";
  EXPECT_EQ(player.counts().refused, link.sent.size());
  EXPECT_NE(Summary(player).find(" refused=" + std::to_string(link.sent.size())),
            std::string::npos);
}

// As of a rig that seeks its server once a second.
TEST(Player, AMissingReceiverIsReportedForASlowSenderToo) {
  class Link final : public player::Link {
   public:
    Link(FakeClock& clock, std::uint64_t most)
        : clock_(clock), start_ns_(clock.now_ns), most_(most) {}
    Status Send(std::span<const std::byte>) override { return Status::Ok(); }
    std::uint64_t refused() override {
      const auto seconds = static_cast<std::uint64_t>((clock_.now_ns - start_ns_) / 1'000'000'000);
      return std::min(most_, 1 + seconds);
    }

   private:
    FakeClock& clock_;
    std::int64_t start_ns_;
    std::uint64_t most_;
  };
  for (const int refusals : {1, 2}) {
    FakeClock clock;
    Link link(clock, static_cast<std::uint64_t>(refusals));
    int told = 0;
    Player player({120, 2, [&told] { ++told; }}, Streams(1, 1000, 120));
    const std::atomic<bool> stop{false};
    ASSERT_TRUE(player.Run(clock, link, stop).ok());
    EXPECT_EQ(told, refusals == 1 ? 0 : 1) << "one alone may be of a receiver that starts";
    EXPECT_EQ(player.counts().refused, static_cast<std::uint64_t>(refusals));
  }
}

TEST(Player, CatchesUpAfterADelayAndSkipsNothing) {
  FakeClock clock;
  clock.cost_ns = 5'000'000;  // each look at the clock: at 120 Hz more than a period per tick
  FakeLink link(&clock);
  Player player({120, 0}, Streams(1, 200, 120));
  const std::atomic<bool> stop{false};
  ASSERT_TRUE(player.Run(clock, link, stop).ok());
  EXPECT_EQ(FrameTimes(link, "amy-0").size(), 200U);
  EXPECT_GT(player.counts().late_ticks, 150U);
  EXPECT_EQ(clock.sleeps, 0);
}

TEST(Player, SpreadsSeveralPerformersOverThePeriod) {
  FakeClock clock;
  const std::int64_t start_ns = clock.now_ns;
  FakeLink link(&clock);
  Player player({100, 0}, Streams(4, 10, 100));
  const std::atomic<bool> stop{false};
  ASSERT_TRUE(player.Run(clock, link, stop).ok());
  for (int k = 0; k < 4; ++k) {
    const auto times = FrameTimes(link, "amy-" + std::to_string(k));
    ASSERT_EQ(times.size(), 10U);
    for (int i = 0; i < 10; ++i) {
      EXPECT_EQ(times[i], start_ns + i * 10'000'000 + k * 2'500'000);
    }
  }
}

TEST(Player, JitterDelaysEachFrameInOrderAndNoOtherPerformer) {
  const auto play = [](const char* spec) {
    FakeClock clock;
    const std::int64_t start_ns = clock.now_ns;
    FakeLink link(&clock);
    auto senders = Streams(2, 500, 100);
    senders[0] = std::make_unique<Stream>(
        StreamOptions{"amy-0", 100, [] { return std::uint64_t{1}; }},
        std::make_unique<FakeMotion>(500), faults::Faults(faults::Parse(spec).value()));
    Player player({100, 0}, std::move(senders));
    const std::atomic<bool> stop{false};
    EXPECT_TRUE(player.Run(clock, link, stop).ok());
    auto jittery = FrameTimes(link, "amy-0");
    const auto steady = FrameTimes(link, "amy-1");
    EXPECT_EQ(steady.size(), 500U);
    for (std::size_t i = 0; i < steady.size(); ++i) {
      EXPECT_EQ(steady[i], start_ns + std::int64_t(i) * 10'000'000 + 5'000'000);
    }
    EXPECT_EQ(player.counts().late_ticks, 0U);
    std::uint64_t newest = 0;
    for (const auto& r : testing::Receive(link)) {
      if (!r.is_frame() || r.frame.performer() != "amy-0") continue;
      EXPECT_GT(r.header.sequence, newest);
      newest = r.header.sequence;
    }
    for (std::size_t i = 0; i < jittery.size(); ++i) {
      jittery[i] -= start_ns + std::int64_t(i) * 10'000'000;
    }
    return jittery;
  };
  const auto delays_ns = play("jitter-ms=25,seed=3");
  ASSERT_EQ(delays_ns.size(), 500U);
  const auto [least, most] = std::minmax_element(delays_ns.begin(), delays_ns.end());
  EXPECT_GE(*least, 0);
  EXPECT_LT(*least, 3'000'000);
  EXPECT_LE(*most, 25'000'000);
  EXPECT_GT(*most, 22'000'000);
  EXPECT_EQ(play("jitter-ms=25,seed=3"), delays_ns);
  EXPECT_NE(play("jitter-ms=25,seed=4"), delays_ns);
}

TEST(Player, EndsAfterItsSeconds) {
  FakeClock clock;
  FakeLink link(&clock);
  Player player({120, 2}, Streams(2, 100000, 120));
  const std::atomic<bool> stop{false};
  ASSERT_TRUE(player.Run(clock, link, stop).ok());
  EXPECT_EQ(FrameTimes(link, "amy-0").size(), 240U);
  EXPECT_EQ(FrameTimes(link, "amy-1").size(), 240U);
  EXPECT_EQ(player.counts().ticks, 240U);
}

TEST(Player, StopsWhenAskedTo) {
  FakeClock clock;
  FakeLink link(&clock);
  Player player({120, 0}, Streams(1, 100000, 120));
  const std::atomic<bool> stop{true};
  ASSERT_TRUE(player.Run(clock, link, stop).ok());
  EXPECT_TRUE(link.sent.empty());
}

TEST(Player, EndsWithTheLinksReason) {
  FakeClock clock;
  FakeLink link(&clock);
  link.fail = true;
  Player player({120, 0}, Streams(1, 10, 120));
  const std::atomic<bool> stop{false};
  EXPECT_EQ(player.Run(clock, link, stop).message(), "no link");
}

TEST(Player, SumsUpInWordsAndNumbers) {
  FakeClock clock;
  FakeLink link(&clock);
  Player player({120, 0}, Streams(3, 120, 120));
  const std::atomic<bool> stop{false};
  ASSERT_TRUE(player.Run(clock, link, stop).ok());
  const std::string line = Summary(player);
  EXPECT_NE(line.find("performers=3 frames=360 bodies=3 datagrams=363 bytes="), std::string::npos)
      << line;
  EXPECT_NE(line.find(" sessions=3 "), std::string::npos) << line;
  EXPECT_EQ(line.find("loss="), std::string::npos) << line;
}

TEST(Link, RefusesAnAddressItDoesNotUnderstand) {
  for (const char* url :
       {"", "localhost:7000", "http://localhost:7000", "udp://localhost", "udp://:7000",
        "udp://localhost:", "udp://localhost:0", "udp://localhost:65536", "tcp://localhost:7x"}) {
    const auto link = Connect(url, 0);
    ASSERT_FALSE(link.ok()) << url;
    EXPECT_NE(link.status().message().find("expected udp://HOST:PORT"), std::string::npos)
        << link.status().message();
  }
}

}  // namespace
}  // namespace styled::player
