// A broker that dies or hangs harms no subscriber of the daemon, and the frames that arrive
// afterwards are new.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <iostream>

#include "tests/e2e/nats/stage.h"

namespace styled::support {
namespace {

constexpr const char* kFrames = "styled.hall.rig=2Ea.canonical";
constexpr const char* kTopic = "styled/rig.a/canonical/";

using NatsFailureTest = OnNatsServers;

// Of the daemon's subscriber: frames that never came.
std::uint64_t Lost(const std::vector<v1::Frame>& frames) {
  std::uint64_t lost = 0;
  for (std::size_t i = 1; i < frames.size(); ++i) {
    lost += frames[i].sequence() - frames[i - 1].sequence() - 1;
  }
  return lost;
}

TEST_F(NatsFailureTest, FramesAreBackWithinTwoSecondsOfAKilledServersRestartAndNoneIsOld) {
  Daemon daemon;
  const Subscriber zmq(daemon.publish, {kTopic, "body/"});
  NatsUser viewer(servers_.hub_port, "viewer", "styled.>");
  const Stylenats bridge(daemon, servers_.leaf_port);
  const Walker walker(daemon);
  ASSERT_TRUE(viewer.WaitFor(60, kFrames, 30)) << bridge.Log() << servers_.Log();

  servers_.leaf->Signal(SIGKILL);
  ASSERT_TRUE(servers_.leaf->Wait(5));
  ASSERT_TRUE(bridge.WaitForLog("lost the broker")) << bridge.Log();
  Sleep(2);
  EXPECT_GT(bridge.Count("dropped without a broker"), 100) << bridge.Counters();
  viewer.Clear();
  const std::uint64_t newest = zmq.Frames(kTopic).back().sequence();
  servers_.StartLeaf();
  const auto ready = std::chrono::steady_clock::now();
  ASSERT_TRUE(viewer.WaitFor(1, kFrames)) << bridge.Log() << servers_.Log();
  const auto first = viewer.All(kFrames).front();
  const double took_s = std::chrono::duration<double>(first.at - ready).count();
  EXPECT_LT(took_s, 2.0);
  ASSERT_TRUE(viewer.WaitFor(60, kFrames));
  std::uint64_t last = newest;
  for (const Heard& heard : viewer.All(kFrames)) {
    ASSERT_GT(heard.sequence, last) << "older than the restart, or doubled";
    last = heard.sequence;
  }
  EXPECT_THAT(bridge.Log(), testing::HasSubstr("connected again, to nats://127.0.0.1:"));
  EXPECT_EQ(Lost(zmq.Frames(kTopic)), 0U);
  EXPECT_EQ(bridge.Count("missed,"), 0) << bridge.Counters();
  std::cout << "back after " << took_s << " s\n";
}

// The hub has the bucket in memory. It may be started again although our connection to the leaf
// server never breaks.
TEST_F(NatsFailureTest, BodiesAreInTheBucketOfAHubThatWasStartedAgain) {
  Daemon daemon;
  const Stylenats bridge(daemon, servers_.leaf_port);
  const Walker walker(daemon);
  const std::string key = "hall.body.rig=2Ea.canonical";
  {
    NatsUser viewer(servers_.hub_port, "viewer");
    ASSERT_TRUE(viewer.WaitForKey(key, 30)) << bridge.Log() << servers_.Log();
  }
  servers_.hub->Signal(SIGKILL);
  ASSERT_TRUE(servers_.hub->Wait(5));
  servers_.StartHub();
  NatsUser viewer(servers_.hub_port, "viewer", "styled.>");
  EXPECT_TRUE(viewer.WaitFor(1, kFrames)) << bridge.Log() << servers_.Log();
  EXPECT_TRUE(viewer.WaitForKey(key, 20)) << bridge.Log() << servers_.Log();
}

// Frames of 16 kB fill the kernel's buffers, after which a call of libnats stands still.
TEST_F(NatsFailureTest, AServerThatStandsStillMakesNobodyElseLate) {
  Daemon daemon;
  const Subscriber zmq(daemon.publish, {kTopic, "body/"});
  NatsUser viewer(servers_.hub_port, "viewer", kFrames);
  const Stylenats bridge(daemon, servers_.leaf_port);
  const Walker walker(daemon, {"a", "b"}, 15000);
  ASSERT_TRUE(viewer.WaitFor(60, kFrames, 30)) << bridge.Log() << servers_.Log();

  servers_.leaf->Signal(SIGSTOP);
  const std::size_t before = zmq.Frames(kTopic).size();
  Sleep(8);
  const auto frames = zmq.Frames(kTopic);
  EXPECT_EQ(Lost(frames), 0U);
  EXPECT_GT(frames.size() - before, 800U) << "120 Hz for 8 s";
  EXPECT_EQ(bridge.Count("missed,"), 0) << "it reads ZeroMQ all the time: " << bridge.Counters();
  const long dropped = bridge.Count("replaced,") + bridge.Count("dropped without a broker,");
  EXPECT_GT(dropped, 1000) << bridge.Counters();
  std::cout << bridge.Counters() << "\n";

  viewer.Clear();
  servers_.leaf->Signal(SIGCONT);
  ASSERT_TRUE(viewer.WaitFor(60, kFrames)) << bridge.Log() << servers_.Log();
  std::uint64_t last = 0;
  for (const Heard& heard : viewer.All(kFrames)) {
    ASSERT_GT(heard.sequence, last) << "in order, none twice";
    last = heard.sequence;
  }
}

TEST_F(NatsFailureTest, ASignalEndsItWhileTheServerStandsStill) {
  Daemon daemon;
  NatsUser viewer(servers_.hub_port, "viewer", kFrames);
  const Stylenats bridge(daemon, servers_.leaf_port);
  const Walker walker(daemon, {"a", "b"}, 15000);
  ASSERT_TRUE(viewer.WaitFor(60, kFrames, 30)) << bridge.Log() << servers_.Log();
  servers_.leaf->Signal(SIGSTOP);
  Sleep(2);
  bridge.child->Signal(SIGTERM);
  EXPECT_EQ(bridge.child->Wait(4).value_or(-1), 0) << bridge.Log();
}

TEST_F(NatsFailureTest, ItWaitsForABrokerThatComesLater) {
  Daemon daemon;
  servers_.leaf.reset();
  NatsUser viewer(servers_.hub_port, "viewer", "styled.>");
  const Stylenats bridge(daemon, servers_.leaf_port);
  const Walker walker(daemon);
  ASSERT_TRUE(bridge.WaitForLog("no broker answers at nats://127.0.0.1:")) << bridge.Log();
  Sleep(1);
  servers_.StartLeaf();
  EXPECT_TRUE(viewer.WaitFor(60, kFrames, 10)) << bridge.Log() << servers_.Log();
  EXPECT_TRUE(viewer.WaitForKey("hall.body.rig=2Ea.rig")) << bridge.Log();
}

}  // namespace
}  // namespace styled::support
