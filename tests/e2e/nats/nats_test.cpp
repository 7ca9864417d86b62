// Delivery by stylenats with a daemon, the shipped leaf server and the shipped hub.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <iostream>
#include <map>

#include "tests/e2e/nats/stage.h"

namespace styled::support {
namespace {

constexpr const char* kCanonical = "styled.hall.rig=2Ea.canonical";
constexpr const char* kAudience = "styled.hall.rig=2Ea.canonical30";
constexpr const char* kRigFrames = "styled.hall.rig=2Ea.rig";

using NatsTest = OnNatsServers;

// By sequence, what the daemon sent on a ZeroMQ topic.
std::map<std::uint64_t, std::string> Sent(const Subscriber& subscriber, const std::string& topic) {
  std::map<std::uint64_t, std::string> sent;
  for (const Message& message : subscriber.Messages(topic)) {
    v1::Frame frame;
    EXPECT_TRUE(frame.ParseFromString(message.payload));
    sent[frame.sequence()] = message.payload;
  }
  return sent;
}

TEST_F(NatsTest, FramesArriveByteForByteAndInOrder) {
  Daemon daemon;
  const Subscriber sent(daemon.publish, {"styled/", "body/"});
  const NatsUser viewer(servers_.hub_port, "viewer", "styled.>");
  const Stylenats bridge(daemon, servers_.leaf_port);
  const Walker walker(daemon);
  ASSERT_TRUE(viewer.WaitFor(240, kCanonical, 30)) << bridge.Log() << servers_.Log();
  ASSERT_TRUE(viewer.WaitFor(240, kRigFrames)) << bridge.Log();
  Sleep(0.3);  // the witness has its own socket and thread
  const struct {
    const char *subject, *topic;
  } streams[] = {{kCanonical, "styled/rig.a/canonical/"},
                 {kRigFrames, "styled/rig.a/rig/"},
                 {kAudience, "styled/rig.a/canonical/"}};
  for (const auto& stream : streams) {
    const auto frames = Sent(sent, stream.topic);
    const auto heard = viewer.All(stream.subject);
    std::uint64_t last = 0;
    std::size_t compared = 0;
    for (const Heard& message : heard) {
      ASSERT_GT(message.sequence, last) << "in order, none twice";
      last = message.sequence;
      const auto frame = frames.find(message.sequence);
      if (frame == frames.end()) continue;  // the newest may not have arrived yet
      ASSERT_EQ(message.payload, frame->second) << "the daemon's bytes";
      v1::Frame parsed;
      ASSERT_TRUE(parsed.ParseFromString(message.payload));
      EXPECT_EQ(message.sequence, parsed.sequence());
      EXPECT_EQ(message.epoch, parsed.epoch());
      ++compared;
    }
    EXPECT_GE(compared + 5, heard.size()) << stream.subject;
    EXPECT_GE(compared, 50U) << stream.subject;
  }
  // A quarter of the frames of the canonical stream, give or take the replaced ones.
  const double share =
      static_cast<double>(viewer.Size(kAudience)) / static_cast<double>(viewer.Size(kCanonical));
  EXPECT_NEAR(share, 0.25, 0.05);
  EXPECT_EQ(bridge.Count("failed,"), 0) << bridge.Counters();
  std::cout << bridge.Counters() << "\n";
}

TEST_F(NatsTest, ALateJoinerHasBodyAndStyleFromTheBucket) {
  Daemon daemon;
  const Subscriber sent(daemon.publish, {"body/"});
  const Stylenats bridge(daemon, servers_.leaf_port);
  const Walker walker(daemon);
  NatsUser viewer(servers_.hub_port, "viewer");
  for (const std::string stream : {"rig", "canonical"}) {
    const std::string key = "hall.body.rig=2Ea." + stream;
    ASSERT_TRUE(viewer.WaitForKey(key, 30)) << key << "\n" << bridge.Log() << servers_.Log();
    const std::string value = *viewer.Get(key);
    const auto bodies = sent.Messages("body/rig.a/");
    EXPECT_TRUE(std::any_of(bodies.begin(), bodies.end(), [&value](const Message& message) {
      return message.payload == value;
    })) << "the daemon's bytes";
    v1::Body body;
    ASSERT_TRUE(body.ParseFromString(value));
    EXPECT_EQ(body.output(), stream == "rig" ? v1::OUTPUT_RIG : v1::OUTPUT_CANONICAL);
  }
  const std::string key = "hall.performer.rig=2Ea";
  ASSERT_TRUE(viewer.WaitForKey(key)) << bridge.Log();
  ControlClient control(daemon.control);
  ASSERT_EQ(control.SetStyle("rig.a", "style1", 1, 0).code(), v1::CODE_OK);
  v1::PerformerStats performer;
  EXPECT_TRUE(WaitUntil(
      [&] {
        return performer.ParseFromString(viewer.Get(key).value_or("")) &&
               performer.look().mix_size() == 1;
      },
      10));
  EXPECT_EQ(performer.performer(), "rig.a");
  EXPECT_TRUE(performer.live());
  ASSERT_EQ(performer.look().mix_size(), 1);
  EXPECT_EQ(performer.look().mix(0).style(), "style1");
}

TEST_F(NatsTest, CommandsChangeTheStyleAndAreAnswered) {
  Daemon daemon;
  const Stylenats bridge(daemon, servers_.leaf_port);
  const Walker walker(daemon);
  ASSERT_TRUE(bridge.WaitForLog("connected to ")) << bridge.Log();
  ControlClient control(daemon.control);
  ASSERT_TRUE(WaitUntil([&] { return control.Performer("rig.a").live(); }, 20));
  NatsUser operating(servers_.hub_port, "operator");
  v1::Request request;
  request.set_id(77);
  request.set_performer("rig.a");
  request.mutable_set()->add_mix()->set_style("style2");
  request.mutable_set()->mutable_mix(0)->set_weight(1);
  const auto reply = operating.Ask(request);
  ASSERT_TRUE(reply) << bridge.Log();
  EXPECT_EQ(reply->id(), 77U);
  EXPECT_EQ(reply->code(), v1::CODE_OK) << reply->reason();
  ASSERT_EQ(reply->applied_size(), 1);
  EXPECT_EQ(reply->applied(0).performer(), "rig.a");
  ASSERT_EQ(control.Performer("rig.a").look().mix_size(), 1);
  EXPECT_EQ(control.Performer("rig.a").look().mix(0).style(), "style2");

  request.mutable_set()->mutable_mix(0)->set_style("no such style");
  EXPECT_EQ(operating.Ask(request)->code(), v1::CODE_UNKNOWN_STYLE) << "the daemon's own refusal";
  const auto garbled = operating.Ask(std::string("\xFF\xFF\xFF"));
  ASSERT_TRUE(garbled);
  EXPECT_EQ(garbled->code(), v1::CODE_MALFORMED);
  EXPECT_THAT(garbled->reason(), testing::HasSubstr("no Request of control.proto"));

  daemon.child->Signal(SIGSTOP);
  const auto late = operating.Ask(request);
  daemon.child->Signal(SIGCONT);
  ASSERT_TRUE(late) << bridge.Log();
  EXPECT_EQ(late->id(), 77U);
  EXPECT_EQ(late->code(), v1::CODE_BUSY);
  EXPECT_THAT(late->reason(), testing::HasSubstr("no daemon answers at " + daemon.control));
}

TEST_F(NatsTest, ASignalEndsItWithinASecond) {
  Daemon daemon;
  const Stylenats bridge(daemon, servers_.leaf_port);
  const NatsUser viewer(servers_.hub_port, "viewer", "styled.>");
  const Walker walker(daemon);
  ASSERT_TRUE(viewer.WaitFor(10, "", 30)) << bridge.Log();
  bridge.child->Signal(SIGTERM);
  EXPECT_EQ(bridge.child->Wait(1.5).value_or(-1), 0) << bridge.Log();
}

}  // namespace
}  // namespace styled::support
