#include "clients/cpp/subscriber.h"

#include <gtest/gtest.h>

#include "clients/cpp/control.h"
#include "tests/unit/clients/fake_daemon.h"

namespace styled::client {
namespace {

using std::chrono::milliseconds;
using namespace std::chrono_literals;

constexpr std::string_view kRigTopic = "styled/rig.a/rig/";

std::unique_ptr<Subscriber> Listen(const FakeDaemon& daemon, SubscriberOptions options = {}) {
  options.endpoints = {daemon.publisher()};
  auto subscriber = Subscriber::Connect(options);
  EXPECT_TRUE(subscriber.ok()) << subscriber.status().message();
  return std::move(subscriber.value());
}

SubscriberOptions OnlyA() { return {.endpoints = {}, .performer = "rig.a"}; }

// Frames until `count` of them came or two seconds passed.
std::vector<Update> Frames(Subscriber& subscriber, std::size_t count) {
  std::vector<Update> frames;
  Update update;
  const auto end = std::chrono::steady_clock::now() + 2s;
  while (frames.size() < count && std::chrono::steady_clock::now() < end) {
    if (subscriber.Receive(50ms, update) && update.kind == Update::Kind::kFrame) {
      frames.push_back(update);
    }
  }
  return frames;
}

class SubscriberTest : public testing::Test {
 protected:
  FakeDaemon daemon_;
  v1::Body rig_ = HumanoidBody("rig.a", v1::OUTPUT_RIG, 11);

  void Send(std::uint64_t sequence, std::uint64_t epoch = 1) {
    daemon_.Publish(std::string(kRigTopic), HumanoidFrame(rig_, body::Pose(), sequence, epoch));
  }
};

TEST(PerformerId, IsSourceDotName) {
  for (const char* good : {"rig.a", "R_i-9.X", "a.0"}) EXPECT_TRUE(IsPerformerId(good)) << good;
  for (const char* bad : {"", "rig", "rig.", ".a", "a.b.c", "a b.c", "rig.a/", "*"}) {
    EXPECT_FALSE(IsPerformerId(bad)) << bad;
  }
  EXPECT_FALSE(IsPerformerId("a." + std::string(33, 'x')));
}

TEST(SubscriberOptionsTest, RefusesEachBadOption) {
  SubscriberOptions options;
  options.endpoints.clear();
  EXPECT_FALSE(Subscriber::Connect(options).ok());
  options.endpoints = {"nonsense"};
  const auto result = Subscriber::Connect(options);
  ASSERT_FALSE(result.ok());
  EXPECT_NE(result.status().message().find("nonsense"), std::string::npos);
  options = {};
  options.performer = "no dot";
  EXPECT_FALSE(Subscriber::Connect(options).ok());
  options = {};
  options.queue_messages = 0;
  EXPECT_FALSE(Subscriber::Connect(options).ok());
  options = {};
  options.performer = "rig.a";
  options.bundled = true;
  EXPECT_FALSE(Subscriber::Connect(options).ok()) << "bundles are of all performers";
  options = {};
  for (const char* avatar : {"", "rig", "canonical", "a/b", "a.b"}) {
    options = {};
    options.avatars = {avatar};
    EXPECT_FALSE(Subscriber::Connect(options).ok()) << avatar;
  }
  options = {};
  options.streams = {Stream::kAvatar};
  EXPECT_FALSE(Subscriber::Connect(options).ok());
}

TEST_F(SubscriberTest, GetsTheBodyFirstAndThenEveryFrameInOrder) {
  daemon_.AddBody(rig_);
  auto subscriber = Listen(daemon_, OnlyA());
  ASSERT_TRUE(daemon_.WaitForSubscription(std::string(kRigTopic)));
  for (int sequence = 5; sequence < 205; ++sequence) Send(sequence);
  const auto frames = Frames(*subscriber, 200);
  ASSERT_EQ(frames.size(), 200U);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    EXPECT_EQ(frames[i].frame.sequence(), 5 + i);
    EXPECT_EQ(frames[i].missed, 0U);
    EXPECT_FALSE(frames[i].new_epoch);
    ASSERT_NE(frames[i].body, nullptr);
    EXPECT_EQ(frames[i].body->hash(), 11U);
    EXPECT_EQ(frames[i].stream, Stream::kStyledRig);
  }
  EXPECT_EQ(subscriber->connected(), 1);
  EXPECT_EQ(subscriber->performers(), std::vector<std::string>{"rig.a"});
}

TEST_F(SubscriberTest, CountsGapsAndDropsWhatComesAgain) {
  auto subscriber = Listen(daemon_, OnlyA());
  ASSERT_TRUE(daemon_.WaitForSubscription(std::string(kRigTopic)));
  for (const int sequence : {10, 11, 11, 9, 15, 16}) Send(sequence);
  const auto frames = Frames(*subscriber, 4);
  ASSERT_EQ(frames.size(), 4U);
  EXPECT_EQ(frames[2].frame.sequence(), 15U);
  EXPECT_EQ(frames[2].missed, 3U);
  EXPECT_EQ(frames[3].missed, 0U);
  EXPECT_EQ(frames[0].body, nullptr) << "no body was sent";
  EXPECT_EQ(subscriber->counters().missed, 3U);
  EXPECT_EQ(subscriber->counters().repeated_frames, 2U);
}

TEST_F(SubscriberTest, ARestartedDaemonIsANewEpochNotAGap) {
  auto subscriber = Listen(daemon_, OnlyA());
  ASSERT_TRUE(daemon_.WaitForSubscription(std::string(kRigTopic)));
  Send(1000, 1);
  Send(0, 2);
  Send(1, 2);
  const auto frames = Frames(*subscriber, 3);
  ASSERT_EQ(frames.size(), 3U);
  EXPECT_TRUE(frames[1].new_epoch);
  EXPECT_EQ(frames[1].missed, 0U);
  EXPECT_FALSE(frames[2].new_epoch);
  EXPECT_EQ(subscriber->counters().epochs, 1U);
}

TEST_F(SubscriberTest, BodiesReplayedForOthersAreDropped) {
  daemon_.AddBody(rig_);
  auto subscriber = Listen(daemon_, OnlyA());
  ASSERT_TRUE(daemon_.WaitForSubscription(std::string(kRigTopic)));
  for (int i = 0; i < 5; ++i) daemon_.Publish("body/rig.a/", rig_.SerializeAsString());
  v1::Body other = rig_;
  other.set_hash(12);
  daemon_.Publish("body/rig.a/", other.SerializeAsString());
  Update update;
  int bodies = 0;
  while (subscriber->Receive(300ms, update)) {
    bodies += update.kind == Update::Kind::kBody ? 1 : 0;
  }
  EXPECT_EQ(bodies, 2) << "the first, and the changed one";
  EXPECT_GE(subscriber->counters().replayed_bodies, 5U);
}

TEST_F(SubscriberTest, HostileMessagesAreCountedAndHarmNothing) {
  daemon_.AddBody(rig_);
  auto subscriber = Listen(daemon_, OnlyA());
  ASSERT_TRUE(daemon_.WaitForSubscription(std::string(kRigTopic)));
  const std::string topic(kRigTopic);
  daemon_.Publish(topic, std::string("\xff\xff\xff"));  // not protobuf
  v1::Frame frame = HumanoidFrame(rig_, body::Pose(), 1);
  frame.set_performer("rig.b");  // another's frame under this topic
  daemon_.Publish(topic, frame);
  frame = HumanoidFrame(rig_, body::Pose(), 2);
  frame.mutable_rotations()->RemoveLast();
  daemon_.Publish(topic, frame);
  frame = HumanoidFrame(rig_, body::Pose(), 3);
  frame.set_output(v1::OUTPUT_CANONICAL);
  daemon_.Publish(topic, frame);
  v1::Body body = rig_;
  body.set_hash(99);
  body.set_parents(3, 17);
  daemon_.Publish("body/rig.a/", body.SerializeAsString());
  Send(4);
  const auto frames = Frames(*subscriber, 1);
  ASSERT_EQ(frames.size(), 1U);
  EXPECT_EQ(frames[0].frame.sequence(), 4U);
  EXPECT_EQ(subscriber->counters().malformed, 5U);
  EXPECT_EQ(subscriber->counters().frames, 1U);
}

TEST_F(SubscriberTest, AllPerformersAreFoundThroughTheirBodies) {
  auto subscriber = Listen(daemon_);
  ASSERT_TRUE(daemon_.WaitForSubscription("body/"));
  daemon_.AddBody(rig_);
  Update update;
  ASSERT_TRUE(subscriber->Receive(2000ms, update));
  EXPECT_EQ(update.kind, Update::Kind::kBody);
  v1::Body late = HumanoidBody("rig.ab", v1::OUTPUT_RIG, 11);
  daemon_.AddBody(late);
  ASSERT_TRUE(subscriber->Receive(2000ms, update));
  ASSERT_TRUE(daemon_.WaitForSubscription("styled/rig.ab/rig/"));
  Send(1);
  daemon_.Publish("styled/rig.ab/rig/", HumanoidFrame(late, body::Pose(), 1));
  const auto frames = Frames(*subscriber, 2);
  ASSERT_EQ(frames.size(), 2U);
  EXPECT_EQ(frames[0].frame.performer(), "rig.a");
  EXPECT_EQ(frames[1].frame.performer(), "rig.ab");
  EXPECT_EQ(subscriber->performers(), (std::vector<std::string>{"rig.a", "rig.ab"}));
}

TEST_F(SubscriberTest, BundledFramesComeAsEachWouldAlone) {
  auto subscriber = Listen(daemon_, {.bundled = true});
  ASSERT_TRUE(daemon_.WaitForSubscription("frames/rig/"));
  ASSERT_TRUE(daemon_.WaitForSubscription("body/"));
  const v1::Body other = HumanoidBody("rig.b", v1::OUTPUT_RIG, 11);
  daemon_.AddBody(rig_);
  daemon_.AddBody(other);
  v1::Frames bundle;
  *bundle.add_frames() = HumanoidFrame(rig_, body::Pose(), 1);
  *bundle.add_frames() = HumanoidFrame(other, body::Pose(), 7);
  *bundle.add_frames() = HumanoidFrame(rig_, body::Pose(), 3);
  *bundle.add_frames() = HumanoidFrame(rig_, body::Pose(), 3);  // again
  bundle.add_frames()->set_performer("nobody's");
  daemon_.Publish("frames/rig/", bundle.SerializeAsString());
  daemon_.Publish("frames/rig/", "\x0a\x7fx");
  daemon_.Publish("frames/rig/", "");
  daemon_.Publish("frames/rig/", bundle.SerializeAsString());
  const auto frames = Frames(*subscriber, 3);
  ASSERT_EQ(frames.size(), 3U);
  EXPECT_EQ(frames[0].frame.performer(), "rig.a");
  EXPECT_EQ(frames[1].frame.performer(), "rig.b");
  EXPECT_EQ(frames[2].missed, 1U);
  for (const Update& update : frames) {
    EXPECT_EQ(update.stream, Stream::kStyledRig);
    ASSERT_NE(update.body, nullptr);
    EXPECT_EQ(update.body->performer(), update.frame.performer());
  }
  Update none;
  EXPECT_FALSE(subscriber->Receive(100ms, none)) << "the second bundle is old";
  EXPECT_EQ(subscriber->counters().malformed, 3U);
  EXPECT_EQ(subscriber->counters().repeated_frames, 5U);
  EXPECT_FALSE(daemon_.Subscribed("styled/rig.a/rig/"));
}

TEST_F(SubscriberTest, LatestWinsKeepsTheNewestOfEachStreamAndEveryBody) {
  SubscriberOptions options = OnlyA();
  options.streams = {Stream::kStyledRig, Stream::kSource};
  options.statistics = true;
  auto subscriber = Listen(daemon_, options);
  ASSERT_TRUE(daemon_.WaitForSubscription("stats/"));
  daemon_.AddBody(rig_);
  for (const int sequence : {1, 2, 5, 6}) {
    Send(sequence);
    daemon_.Publish("source/rig.a/", HumanoidFrame(rig_, body::Pose(), sequence));
  }
  v1::Stats stats;
  for (int i = 1; i <= 3; ++i) {
    stats.set_wall_time_ns(i);
    daemon_.Publish("stats/", stats.SerializeAsString());
  }
  std::this_thread::sleep_for(200ms);
  std::vector<Update> updates;
  ASSERT_EQ(subscriber->ReceiveLatest(1000ms, updates), 4);
  std::map<Update::Kind, int> kinds;
  for (const Update& update : updates) {
    ++kinds[update.kind];
    if (update.kind == Update::Kind::kFrame) {
      EXPECT_EQ(update.frame.sequence(), 6U);
      EXPECT_EQ(update.missed, 2U);
      EXPECT_EQ(update.skipped, 3U);
      EXPECT_NE(update.body, nullptr);
    }
    if (update.kind == Update::Kind::kStatistics) {
      EXPECT_EQ(update.statistics.wall_time_ns(), 3U);
    }
  }
  EXPECT_EQ(kinds[Update::Kind::kFrame], 2);
  EXPECT_EQ(kinds[Update::Kind::kBody], 1);
  EXPECT_EQ(subscriber->ReceiveLatest(0ms, updates), 0);
  EXPECT_TRUE(updates.empty());
}

// As after the process was stopped: what is read first is old, and the newest is still on its way.
TEST_F(SubscriberTest, LatestWinsReadsOnWhileWhatComesIsOlderThanUsual) {
  auto subscriber = Listen(daemon_, OnlyA());
  ASSERT_TRUE(daemon_.WaitForSubscription("styled/rig.a/rig/"));
  daemon_.AddBody(rig_);
  const auto send = [this](int sequence, std::chrono::milliseconds age) {
    v1::Frame frame = HumanoidFrame(rig_, body::Pose(), sequence);
    const auto published = std::chrono::steady_clock::now() - age;
    frame.set_publish_time_ns(
        static_cast<std::uint64_t>(published.time_since_epoch() / std::chrono::nanoseconds(1)));
    daemon_.Publish("styled/rig.a/rig/", frame);
  };
  const auto newest = [&subscriber] {
    std::vector<Update> updates;
    std::uint64_t sequence = 0;
    while (sequence == 0 && subscriber->ReceiveLatest(5000ms, updates) > 0) {
      for (const Update& update : updates) {
        if (update.kind == Update::Kind::kFrame) sequence = update.frame.sequence();
      }
    }
    return sequence;
  };
  send(1, 0ms);
  EXPECT_EQ(newest(), 1U);
  for (int sequence = 2; sequence < 50; ++sequence) send(sequence, 1000ms);
  std::thread late([&send] {
    std::this_thread::sleep_for(5ms);
    send(50, 0ms);
  });
  EXPECT_EQ(newest(), 50U);
  late.join();
  send(51, 1000ms);  // and no newer one comes: not for ever
  EXPECT_EQ(newest(), 51U);
}

// Two avatars may have one and the same skeleton.
TEST_F(SubscriberTest, TellsAvatarsApartByTheNamesOfTheirOutputs) {
  SubscriberOptions options = OnlyA();
  options.streams.clear();
  options.avatars = {"hero", "villain"};
  auto subscriber = Listen(daemon_, options);
  ASSERT_TRUE(daemon_.WaitForSubscription("styled/rig.a/villain/"));
  EXPECT_FALSE(daemon_.Subscribed(std::string(kRigTopic)));
  for (const char* name : {"hero", "villain"}) {
    v1::Body body = HumanoidBody("rig.a", v1::OUTPUT_AVATAR, 12);
    body.set_output_name(name);
    daemon_.AddBody(body);
    daemon_.Publish("styled/rig.a/" + std::string(name) + "/", HumanoidFrame(body, {}, 1));
  }
  const auto frames = Frames(*subscriber, 2);
  ASSERT_EQ(frames.size(), 2U);
  for (const Update& frame : frames) {
    EXPECT_EQ(frame.stream, Stream::kAvatar);
    ASSERT_NE(frame.body, nullptr);
    EXPECT_EQ(frame.body->output_name(), frame.avatar);
  }
  EXPECT_EQ(frames[0].avatar, "hero");
  EXPECT_EQ(frames[1].avatar, "villain");
}

TEST_F(SubscriberTest, FindsEveryAvatarByItsBodyAndKeepsTheBytes) {
  SubscriberOptions options;
  options.streams.clear();
  options.every_avatar = true;
  options.keep_bytes = true;
  auto subscriber = Listen(daemon_, options);
  v1::Body body = HumanoidBody("rig.a", v1::OUTPUT_AVATAR, 12);
  body.set_output_name("hero");
  ASSERT_TRUE(daemon_.WaitForSubscription("body/"));
  daemon_.AddBody(body);
  Update update;
  ASSERT_TRUE(subscriber->Receive(2s, update));
  ASSERT_EQ(update.kind, Update::Kind::kBody);
  EXPECT_EQ(update.bytes, body.SerializeAsString());
  ASSERT_TRUE(daemon_.WaitForSubscription("styled/rig.a/hero/"));
  EXPECT_FALSE(daemon_.Subscribed(std::string(kRigTopic)));
  const std::string bytes = HumanoidFrame(body, {}, 1).SerializeAsString();
  daemon_.Publish("styled/rig.a/hero/", HumanoidFrame(body, {}, 1));
  ASSERT_TRUE(subscriber->Receive(2s, update));
  EXPECT_EQ(update.avatar, "hero");
  EXPECT_EQ(update.bytes, bytes);
}

std::string Error(const Curve& curve) {
  SubscriberOptions options;
  options.curve = curve;
  auto subscriber = Subscriber::Connect(options);
  const auto control = Control::Connect({.curve = curve});
  EXPECT_EQ(subscriber.ok(), control.ok());
  return subscriber.status().message();
}

TEST(CurveTest, RefusesKeysThatAreNone) {
  const std::string key(40, '0');
  EXPECT_EQ(Error({key, "", ""}), "");
  EXPECT_EQ(Error({key, key, key}), "");
  EXPECT_EQ(Error({"", "", ""}),
            "subscriber: curve: server_key has 0 characters; expected 40 of Z85");
  EXPECT_NE(Error({std::string(40, '~'), "", ""}), "");
  EXPECT_NE(Error({key, key, ""}).find("secret_key"), std::string::npos);
  EXPECT_NE(Error({key, "", key}).find("public_key"), std::string::npos);
}

TEST(CurveTest, WithKeysADaemonIsHeardAndWithoutThemItIsNot) {
  zmq::context_t context;
  zmq::socket_t publisher(context, zmq::socket_type::xpub);
  const Curve keys = Complete({std::string(40, '0'), "", ""}).value();
  publisher.set(zmq::sockopt::linger, 0);
  publisher.set(zmq::sockopt::curve_server, true);
  publisher.set(zmq::sockopt::curve_secretkey, keys.secret_key);
  publisher.bind("tcp://127.0.0.1:*");
  SubscriberOptions options;
  options.endpoints = {publisher.get(zmq::sockopt::last_endpoint)};
  auto stranger = Subscriber::Connect(options);
  options.curve = Curve{keys.public_key, "", ""};
  auto friendly = Subscriber::Connect(options);
  ASSERT_TRUE(stranger.ok() && friendly.ok());
  Update update;
  for (int i = 0; i < 500 && friendly.value()->connected() == 0; ++i) {
    friendly.value()->Receive(10ms, update);
    stranger.value()->Receive(0ms, update);
  }
  EXPECT_EQ(friendly.value()->connected(), 1);
  EXPECT_EQ(stranger.value()->connected(), 0);
}

TEST(SubscriberReconnect, ComesBackByItselfWhenTheDaemonDoes) {
  const v1::Body rig = HumanoidBody("rig.a", v1::OUTPUT_RIG, 11);
  auto first = std::make_unique<FakeDaemon>();
  const std::string endpoint = first->publisher();
  auto subscriber = Listen(*first, OnlyA());
  ASSERT_TRUE(first->WaitForSubscription(std::string(kRigTopic)));
  first->Publish(std::string(kRigTopic), HumanoidFrame(rig, body::Pose(), 500, 1));
  ASSERT_EQ(Frames(*subscriber, 1).size(), 1U);
  first.reset();
  Update update;
  for (int i = 0; i < 100 && subscriber->connected() > 0; ++i) subscriber->Receive(10ms, update);
  EXPECT_EQ(subscriber->connected(), 0);

  FakeDaemon second({}, endpoint);
  second.AddBody(rig);
  // libzmq subscribes again inside the subscriber's calls, so it has to be kept reading.
  for (int i = 0; i < 500 && !second.Subscribed(std::string(kRigTopic)); ++i) {
    subscriber->Receive(10ms, update);
  }
  second.Publish(std::string(kRigTopic), HumanoidFrame(rig, body::Pose(), 1, 2));
  const auto frames = Frames(*subscriber, 1);
  ASSERT_EQ(frames.size(), 1U);
  EXPECT_TRUE(frames[0].new_epoch);
  EXPECT_NE(frames[0].body, nullptr);
  EXPECT_EQ(subscriber->connected(), 1);
}

// libzmq gives up an address at which the protocol was broken once.
TEST(SubscriberReconnect, ComesBackWhereAnotherProgramBrokeTheProtocol) {
  const v1::Body rig = HumanoidBody("rig.a", v1::OUTPUT_RIG, 11);
  auto first = std::make_unique<FakeDaemon>();
  const std::string endpoint = first->publisher();
  auto subscriber = Listen(*first, OnlyA());
  ASSERT_TRUE(first->WaitForSubscription(std::string(kRigTopic)));
  first.reset();
  Update update;
  {
    zmq::context_t context;
    zmq::socket_t stranger(context, zmq::socket_type::rep);
    stranger.set(zmq::sockopt::linger, 0);
    stranger.bind(endpoint);
    for (int i = 0; i < 100; ++i) subscriber->Receive(10ms, update);
  }
  FakeDaemon second({}, endpoint);
  second.AddBody(rig);
  for (int i = 0; i < 1000 && !second.Subscribed(std::string(kRigTopic)); ++i) {
    subscriber->Receive(10ms, update);
  }
  second.Publish(std::string(kRigTopic), HumanoidFrame(rig, body::Pose(), 1, 2));
  EXPECT_EQ(Frames(*subscriber, 1).size(), 1U);
  EXPECT_EQ(subscriber->connected(), 1);
}

}  // namespace
}  // namespace styled::client
