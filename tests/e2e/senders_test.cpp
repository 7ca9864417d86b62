#include <gtest/gtest.h>
#include <signal.h>

#include "tests/support/daemon.h"
#include "tests/support/rig.h"

namespace styled::support {
namespace {

void ExpectSequencesGrow(const std::vector<v1::Frame>& frames) {
  for (std::size_t i = 1; i < frames.size(); ++i) {
    ASSERT_EQ(frames[i].sequence(), frames[i - 1].sequence() + 1);
  }
}

TEST(SendersTest, ARestartedSenderIsTheSamePerformerWithItsStyle) {
  Daemon daemon({"performers.takeover_ms=100"});
  Subscriber subscriber(daemon.publish, {"body/", "styled/rig.a/rig/"});
  ControlClient control(daemon.control);
  ASSERT_EQ(control.SetStyle("rig.a", "s3", 1, 0).code(), v1::CODE_OK) << "configured ahead";
  const UdpLink link(daemon.udp);
  Rig first("a", 100);
  link.Send(first.Body());
  ASSERT_TRUE(subscriber.WaitForBody());
  Paced(60, 120, [&](int) { link.Send(first.Frame()); });
  ASSERT_TRUE(subscriber.WaitForFrames(60, "styled/"));
  Sleep(0.2);
  Rig second("a", 200);  // its clock and sequence start again
  second.time_ns = 5;
  link.Send(second.Body());
  Paced(60, 120, [&](int) { link.Send(second.Frame()); });
  ASSERT_TRUE(subscriber.WaitForFrames(120, "styled/"));
  const auto frames = subscriber.Frames("styled/");
  ASSERT_EQ(frames.size(), 120U);
  ExpectSequencesGrow(frames);
  EXPECT_EQ(frames[60].flags() & v1::FLAG_NEW_SESSION, v1::FLAG_NEW_SESSION);
  EXPECT_EQ(frames[60].styles(0).style(), "style3");
  EXPECT_EQ(control.Counter("pipeline.sessions"), 2U);
  EXPECT_EQ(control.Counter("pipeline.second_sender"), 0U);
}

TEST(SendersTest, ASecondLiveSenderIsRefusedUntilTheFirstIsSilent) {
  Daemon daemon;  // silent: 1 s
  Subscriber subscriber(daemon.publish, {"body/", "styled/rig.a/rig/"});
  ControlClient control(daemon.control);
  const UdpLink link(daemon.udp);
  Rig first("a", 100);
  Rig second("a", 200);
  link.Send(first.Body());
  ASSERT_TRUE(subscriber.WaitForBody());
  Paced(60, 120, [&](int) {
    link.Send(first.Frame());
    link.Send(second.Frame());
  });
  EXPECT_EQ(control.CounterSoon("pipeline.second_sender", 60), 60U);
  EXPECT_EQ(control.Counter("pipeline.frames"), 60U);
  Sleep(1.1);
  link.Send(second.Body());
  Paced(30, 120, [&](int) { link.Send(second.Frame()); });
  EXPECT_EQ(control.CounterSoon("pipeline.frames", 90), 90U);
  EXPECT_EQ(control.Counter("pipeline.second_sender"), 60U);
  ASSERT_TRUE(subscriber.WaitForFrames(90, "styled/"));
  ExpectSequencesGrow(subscriber.Frames("styled/"));
}

TEST(SendersTest, AClockThatGoesBackMoreThanASecondStartsANewSession) {
  Daemon daemon;
  Subscriber subscriber(daemon.publish, {"body/", "styled/rig.a/rig/"});
  ControlClient control(daemon.control);
  const UdpLink link(daemon.udp);
  Rig rig("a");
  rig.time_ns = 60'000'000'000;
  link.Send(rig.Body());
  ASSERT_TRUE(subscriber.WaitForBody());
  Paced(40, 120, [&](int i) {
    if (i == 20) rig.time_ns -= 10'000'000'000;
    link.Send(rig.Frame());
  });
  ASSERT_TRUE(subscriber.WaitForFrames(40, "styled/"));
  const auto frames = subscriber.Frames("styled/");
  ExpectSequencesGrow(frames);
  EXPECT_EQ(frames[20].flags() & v1::FLAG_NEW_SESSION, v1::FLAG_NEW_SESSION);
  EXPECT_EQ(control.Counter("pipeline.clock_jumps"), 1U);
  EXPECT_EQ(control.Counter("pipeline.old_time"), 0U);
}

TEST(SendersTest, FiftyPerformersAtOnceAllGetThrough) {
  Daemon daemon;
  Subscriber subscriber(daemon.publish, {"body/", "styled/"});
  ControlClient control(daemon.control);
  ASSERT_EQ(control.SetStyle("*", "style1").code(), v1::CODE_OK);
  const UdpLink link(daemon.udp);
  std::vector<Rig> rigs;
  for (int i = 0; i < 50; ++i) rigs.emplace_back("p" + std::to_string(i), 1000 + i);
  for (auto& rig : rigs) link.Send(rig.Body());
  EXPECT_EQ(control.CounterSoon("pipeline.performers", 50), 50U);
  ASSERT_TRUE(subscriber.WaitForBody());
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  constexpr double kRate_hz =
      10;  // an instrumented daemon on a busy machine does not do 3000 a second
#else
  constexpr double kRate_hz = 60;
#endif
  constexpr int kFrames = 180;
  Paced(kFrames, kRate_hz, [&](int) {
    for (auto& rig : rigs) link.Send(rig.Frame());
  });
  EXPECT_EQ(control.CounterSoon("pipeline.frames", 50 * kFrames), 50U * kFrames);
  EXPECT_EQ(control.Counter("source.kernel_dropped"), 0U);
  ASSERT_TRUE(subscriber.WaitForFrames(2 * 50 * kFrames, "styled/", 30));
  for (const auto& rig : rigs) {
    const auto frames = subscriber.Frames("styled/rig." + rig.performer + "/rig/");
    ASSERT_EQ(frames.size(), kFrames);
    ExpectSequencesGrow(frames);
    EXPECT_EQ(frames.back().styles(0).style(), "style1");
  }
}

TEST(SendersTest, MorePerformersThanAllowedAreRefusedAndTheOthersUnharmed) {
  Daemon daemon({"performers.max_performers=2", "performers.forget_s=1"});
  ControlClient control(daemon.control);
  const UdpLink link(daemon.udp);
  Rig a("a", 1);
  Rig b("b", 2);
  Rig c("c", 3);
  for (Rig* rig : {&a, &b, &c}) link.Send(rig->Body());
  Paced(20, 120, [&](int) {
    for (Rig* rig : {&a, &b, &c}) link.Send(rig->Frame());
  });
  EXPECT_EQ(control.CounterSoon("pipeline.frames", 40), 40U);
  EXPECT_EQ(control.Counter("pipeline.performers_refused"), 1U);
  EXPECT_EQ(control.Counter("pipeline.before_body"), 20U);
  // Once the others are forgotten there is room again, and sequences still do not decrease.
  EXPECT_EQ(control.CounterSoon("pipeline.performers", 0), 0U);
  EXPECT_EQ(control.Counter("pipeline.forgotten"), 2U);
  Subscriber subscriber(daemon.publish, {"body/", "styled/rig.a/rig/"});
  link.Send(c.Body());
  link.Send(a.Body());
  ASSERT_TRUE(subscriber.WaitForBody());
  link.Send(a.Frame());
  ASSERT_TRUE(subscriber.WaitForFrames(1, "styled/"));
  EXPECT_GT(subscriber.Frames("styled/")[0].sequence(), 20U);
}

TEST(SendersTest, SilenceGivesOneStaleFrameAndNothingMore) {
  Daemon daemon({"performers.stale_ms=300"});
  Subscriber subscriber(daemon.publish, {"body/", "styled/rig.a/rig/"});
  ControlClient control(daemon.control);
  const UdpLink link(daemon.udp);
  Rig rig("a");
  link.Send(rig.Body());
  ASSERT_TRUE(subscriber.WaitForBody());
  for (int i = 0; i < 20; ++i) link.Send(rig.Frame());
  ASSERT_TRUE(subscriber.WaitForFrames(21, "styled/"));
  Sleep(0.7);
  const auto frames = subscriber.Frames("styled/");
  ASSERT_EQ(frames.size(), 21U);
  EXPECT_EQ(frames[20].flags() & v1::FLAG_STALE, v1::FLAG_STALE);
  EXPECT_EQ(frames[20].source_time_ns(), frames[19].source_time_ns());
  EXPECT_EQ(frames[20].SerializeAsString().size() > 0, true);
  ExpectSequencesGrow(frames);
  EXPECT_FALSE(control.Performer("rig.a").live());
  EXPECT_EQ(control.Counter("pipeline.stale"), 1U);
}

TEST(SendersTest, ABacklogBeyondItsBoundIsCutToTheNewest) {
  Daemon daemon(
      {"performers.backlog_ms=100", "performers.late_ms=25", "performers.stale_ms=10000"});
  Subscriber subscriber(daemon.publish, {"body/", "styled/rig.a/rig/"});
  ControlClient control(daemon.control);
  const UdpLink link(daemon.udp);
  Rig rig("a");
  link.Send(rig.Body());
  ASSERT_TRUE(subscriber.WaitForBody());
  Paced(60, 120, [&](int) { link.Send(rig.Frame()); });
  ASSERT_TRUE(subscriber.WaitForFrames(40, "styled/"));
  daemon.child->Signal(SIGSTOP);
  // Half a second of frames is queued in the socket.
  Paced(60, 120, [&](int) { link.Send(rig.Frame()); });
  daemon.child->Signal(SIGCONT);
  Sleep(0.3);
  const auto frames = subscriber.Frames("styled/");
  const auto dropped = control.Counter("pipeline.backlog_dropped");
  EXPECT_GE(dropped, 40U);
  EXPECT_LE(dropped, 59U);
  EXPECT_EQ(frames.size() + dropped, 120U);
  EXPECT_EQ(frames.back().source_sequence(), 120U) << "the newest is there";
  EXPECT_GE(control.Counter("pipeline.late"), 1U);
  ExpectSequencesGrow(frames);
}

TEST(SendersTest, ANewBodyAtRunTimeIsBoundAndAnnounced) {
  Daemon daemon;
  Subscriber subscriber(daemon.publish, {"body/", "styled/rig.a/rig/"});
  ControlClient control(daemon.control);
  const UdpLink link(daemon.udp);
  Rig rig("a");
  link.Send(rig.Body());
  ASSERT_TRUE(subscriber.WaitForBody());
  for (int i = 0; i < 10; ++i) link.Send(rig.Frame());
  v1::Body taller = rig.MakeBody();
  taller.add_names("tail");
  taller.add_parents(0);
  for (const float value : {0.0F, 0.0F, -0.2F}) taller.add_offsets(value);
  link.Send(rig.Datagram(native::Kind::kBody, taller.SerializeAsString()));
  for (int i = 0; i < 10; ++i) {
    link.Send(rig.Frame([](v1::SourceFrame& frame) {
      for (const float value : {0.0F, 0.0F, 0.0F, 1.0F}) frame.add_rotations(value);
    }));
  }
  ASSERT_TRUE(subscriber.WaitForFrames(20, "styled/"));
  const auto frames = subscriber.Frames("styled/");
  EXPECT_EQ(frames[9].rotations_size(), 84);
  EXPECT_EQ(frames[10].rotations_size(), 88);
  EXPECT_NE(frames[9].body_hash(), frames[10].body_hash());
  ExpectSequencesGrow(frames);
  EXPECT_EQ(control.Counter("pipeline.body_changes"), 1U);
}

}  // namespace
}  // namespace styled::support
