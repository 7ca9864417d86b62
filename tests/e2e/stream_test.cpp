#include <gtest/gtest.h>

#include <cstring>

#include "tests/support/daemon.h"
#include "tests/support/rig.h"

namespace styled::support {
namespace {

// Sequences increase by one per frame, and each frame is caused by the next datagram.
void ExpectUnbroken(const std::vector<v1::Frame>& frames) {
  for (std::size_t i = 1; i < frames.size(); ++i) {
    ASSERT_EQ(frames[i].sequence(), frames[i - 1].sequence() + 1);
    ASSERT_GT(frames[i].source_time_ns(), frames[i - 1].source_time_ns());
  }
}

template <typename Repeated>
std::string Bits(const Repeated& floats) {
  return {reinterpret_cast<const char*>(floats.data()), floats.size() * sizeof(float)};
}

TEST(StreamTest, EveryFrameOfSecondsAt120HzArrivesInOrderAndASwitchIsInForceAtTheNamedSequence) {
  Daemon daemon;
  Subscriber subscriber(daemon.publish, {"body/rig.a/", "styled/rig.a/rig/", "source/rig.a/"});
  ControlClient control(daemon.control);
  const UdpLink link(daemon.udp);
  Rig rig("a");
  link.Send(rig.Body());
  ASSERT_TRUE(subscriber.WaitForBody());
  std::vector<v1::SourceFrame> sent;
  std::uint64_t first_sequence = 0;
  constexpr int kFrames = 480;
  Paced(kFrames, 120, [&](int i) {
    sent.push_back(rig.MakeFrame());
    link.Send(rig.Frame());
    if (i == 240) {
      const auto reply = control.SetStyle("rig.a", "style2", 0.8F, 100);
      ASSERT_EQ(reply.code(), v1::CODE_OK) << reply.reason();
      ASSERT_EQ(reply.applied_size(), 1);
      first_sequence = reply.applied(0).first_sequence();
    }
  });
  ASSERT_TRUE(subscriber.WaitForFrames(kFrames, "styled/")) << daemon.Log();
  const auto styled = subscriber.Frames("styled/");
  const auto source = subscriber.Frames("source/");
  ASSERT_EQ(styled.size(), kFrames);
  ASSERT_EQ(source.size(), kFrames);
  ExpectUnbroken(styled);
  ASSERT_GT(first_sequence, styled[200].sequence());
  for (std::size_t i = 0; i < styled.size(); ++i) {
    const v1::Frame& frame = styled[i];
    EXPECT_EQ(frame.source_time_ns(), sent[i].source_time_ns());
    EXPECT_EQ(Bits(source[i].rotations()), Bits(sent[i].rotations())) << "source is as received";
    if (frame.sequence() < first_sequence) {
      // Bypass is bit-identical.
      ASSERT_EQ(frame.flags() & v1::FLAG_BYPASS, v1::FLAG_BYPASS) << i;
      ASSERT_EQ(Bits(frame.rotations()), Bits(sent[i].rotations())) << i;
      ASSERT_EQ(Bits(frame.root_position()), Bits(sent[i].root_position())) << i;
      ASSERT_EQ(frame.styles_size(), 0);
    } else {
      ASSERT_EQ(frame.flags() & v1::FLAG_BYPASS, 0) << i;
      ASSERT_GE(frame.styles_size(), 1) << "in force at the named sequence";
      ASSERT_EQ(frame.styles(0).style(), "style2");
    }
  }
  ASSERT_FLOAT_EQ(styled.back().styles(0).weight(), 0.8F);
  EXPECT_NE(Bits(styled.back().rotations()), Bits(sent.back().rotations()));
  EXPECT_EQ(control.Counter("pipeline.frames"), kFrames);
  EXPECT_EQ(control.Counter("pipeline.lost"), 0U);
}

TEST(StreamTest, ARigOverTcpIsStyledToo) {
  Daemon daemon;
  Subscriber subscriber(daemon.publish, {"body/", "styled/"});
  const TcpLink link(daemon.tcp);
  Rig a("a");
  Rig b("b");
  link.Send(a.Body());
  link.Send(b.Body());
  ASSERT_TRUE(subscriber.WaitForBody());
  Bytes burst;  // records must not depend on how the stream is split
  Paced(60, 120, [&](int i) {
    for (Rig* rig : {&a, &b}) {
      const Bytes bytes = rig->Frame();
      burst.insert(burst.end(), bytes.begin(), bytes.end());
    }
    if (i % 3 != 2) return;
    const auto middle = burst.begin() + static_cast<std::ptrdiff_t>(burst.size() / 2);
    link.Send(Bytes(burst.begin(), middle));
    link.Send(Bytes(middle, burst.end()));
    burst.clear();
  });
  ASSERT_TRUE(subscriber.WaitForFrames(60, "styled/tcp.a/rig/"));
  ASSERT_TRUE(subscriber.WaitForFrames(60, "styled/tcp.b/canonical/"));
  ExpectUnbroken(subscriber.Frames("styled/tcp.a/rig/"));
}

TEST(StreamTest, FramesCarryTimesTimecodeAndTheHashOfTheirBody) {
  Daemon daemon;
  Subscriber subscriber(daemon.publish, {"body/", "styled/", "source/"});
  const UdpLink link(daemon.udp);
  Rig rig("a");
  link.Send(rig.Body());
  ASSERT_TRUE(subscriber.WaitForBody());
  for (int i = 0; i < 3; ++i) {
    link.Send(rig.Frame([i](v1::SourceFrame& frame) {
      if (i == 1) return;  // the field is optional for a rig
      frame.mutable_timecode()->set_hours(10);
      frame.mutable_timecode()->set_frames(static_cast<std::uint32_t>(i));
      frame.mutable_timecode()->set_rate(29.97F);
      frame.mutable_timecode()->set_drop_frame(true);
    }));
    Sleep(0.01);
  }
  ASSERT_TRUE(subscriber.WaitForFrames(3, "styled/rig.a/canonical/"));
  ASSERT_TRUE(subscriber.WaitForFrames(3, "styled/rig.a/rig/"));
  std::map<v1::Output, std::uint64_t> hashes;
  for (const auto& body : subscriber.Bodies()) {
    hashes[body.output()] = body.hash();
    EXPECT_EQ(body.performer(), "rig.a");
    EXPECT_EQ(body.rest_size(), 4 * body.names_size());
  }
  ASSERT_EQ(hashes.size(), 2U);
  for (const auto& frame : subscriber.Frames()) {
    EXPECT_EQ(frame.performer(), "rig.a");
    EXPECT_EQ(frame.body_hash(), hashes[frame.output()]);
    EXPECT_GE(frame.publish_time_ns(), frame.receive_time_ns());
    EXPECT_GT(frame.wall_time_ns(), 1'600'000'000'000'000'000ULL);
    EXPECT_EQ(frame.has_timecode(), frame.sequence() != 2);
  }
  const auto frames = subscriber.Frames("source/");
  EXPECT_EQ(frames.at(0).flags() & v1::FLAG_NEW_SESSION, v1::FLAG_NEW_SESSION);
  EXPECT_EQ(frames.at(2).timecode().hours(), 10U);
  EXPECT_EQ(frames.at(2).timecode().frames(), 2U);
  EXPECT_TRUE(frames.at(2).timecode().drop_frame());
  EXPECT_EQ(frames.at(2).source_sequence(), 3U);
}

TEST(StreamTest, NothingIsSerializedThatNobodySubscribesTo) {
  Daemon daemon;
  ControlClient control(daemon.control);
  const UdpLink link(daemon.udp);
  Rig rig("a");
  link.Send(rig.Body());
  Paced(30, 120, [&](int) { link.Send(rig.Frame()); });
  EXPECT_EQ(control.CounterSoon("pipeline.frames", 30), 30U);
  EXPECT_EQ(control.Counter("publish.messages"), 0U);
  {
    const Subscriber subscriber(daemon.publish, {"styled/rig.a/canonical/", "body/rig.a/"});
    ASSERT_TRUE(subscriber.WaitForBody());
    Paced(30, 120, [&](int) { link.Send(rig.Frame()); });
    ASSERT_TRUE(subscriber.WaitForFrames(30));
    EXPECT_EQ(subscriber.Frames("styled/rig.a/canonical/").size(), 30U);
    EXPECT_EQ(control.Counter("publish.messages") - control.Counter("publish.bodies"), 30U);
    EXPECT_EQ(control.Counter("publish.subscriptions"), 2U);
  }
  EXPECT_EQ(control.CounterSoon("publish.subscriptions", 0), 0U);
  const auto before = control.Counter("publish.messages");
  Paced(30, 120, [&](int) { link.Send(rig.Frame()); });
  EXPECT_EQ(control.CounterSoon("pipeline.frames", 90), 90U);
  EXPECT_EQ(control.Counter("publish.messages"), before);
}

TEST(StreamTest, StatsComeOnceASecondWithEveryCounterAndPerformer) {
  Daemon daemon;
  Subscriber subscriber(daemon.publish, {"stats/"});
  const UdpLink link(daemon.udp);
  Rig rig("a");
  link.Send(rig.Body());
  Paced(300, 120, [&](int) { link.Send(rig.Frame()); });
  ASSERT_TRUE(subscriber.WaitFor([&] { return subscriber.LastStats().has_value(); }, 3));
  const auto stats = *subscriber.LastStats();
  EXPECT_GT(stats.counters_size(), 50);
  ASSERT_EQ(stats.performers_size(), 1);
  const auto& performer = stats.performers(0);
  EXPECT_EQ(performer.performer(), "rig.a");
  EXPECT_NEAR(performer.rate_hz(), 120, 40);
  EXPECT_GT(performer.latency_p50_us(), 0);
  EXPECT_LE(performer.latency_p50_us(), performer.latency_p99_us());
  EXPECT_LE(performer.latency_p99_us(), performer.latency_max_us());
  EXPECT_TRUE(performer.live());
  EXPECT_EQ(performer.joints(), 21U);
  EXPECT_EQ(performer.dialect(), "canonical");
  // Latency by stage: each stage is listed once, and their sum does not exceed the longest total.
  std::vector<std::string> stages;
  float sum_us = 0;
  for (const auto& stage : stats.stages()) {
    stages.push_back(stage.name());
    EXPECT_GT(stage.mean_us(), 0) << stage.name();
    EXPECT_LE(stage.mean_us(), stage.max_us() * 1.001F) << stage.name();
    sum_us += stage.mean_us();
  }
  EXPECT_EQ(stages, (std::vector<std::string>{"take", "style", "serialize", "send"}));
  EXPECT_LT(sum_us, 1e6F / 120);
}

}  // namespace
}  // namespace styled::support
