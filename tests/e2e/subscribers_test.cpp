#include <gtest/gtest.h>
#include <zmq.h>

#include "tests/support/daemon.h"
#include "tests/support/rig.h"

namespace styled::support {
namespace {

// A ZeroMQ socket that subscribes and never reads.
class Stalled {
 public:
  Stalled(const std::string& endpoint, int topics)
      : context_(zmq_ctx_new()), socket_(zmq_socket(context_, ZMQ_SUB)) {
    const int small = 1;
    zmq_setsockopt(socket_, ZMQ_RCVHWM, &small, sizeof small);
    const int buffer = 4096;
    zmq_setsockopt(socket_, ZMQ_RCVBUF, &buffer, sizeof buffer);
    const int none = 0;  // high-water mark: no limit
    zmq_setsockopt(socket_, ZMQ_LINGER, &none, sizeof none);
    zmq_setsockopt(socket_, ZMQ_SNDHWM, &none, sizeof none);
    for (int i = 0; i < topics; ++i) {
      const std::string topic = i == 0 ? "" : "styled/rig.x" + std::to_string(i);
      zmq_setsockopt(socket_, ZMQ_SUBSCRIBE, topic.data(), topic.size());
    }
    zmq_connect(socket_, endpoint.c_str());
  }
  ~Stalled() {
    zmq_close(socket_);
    zmq_ctx_term(context_);
  }
  Stalled(const Stalled&) = delete;
  Stalled& operator=(const Stalled&) = delete;

 private:
  void* context_;
  void* socket_;
};

TEST(SubscribersTest, OneThatNeverReadsHarmsNobody) {
  Daemon daemon({"publish.high_water_mark=50"});
  const Stalled stalled(daemon.publish, 1);
  ControlClient control(daemon.control);
  const UdpLink link(daemon.udp);
  Rig rig("a");
  link.Send(rig.Body());
  EXPECT_EQ(control.CounterSoon("publish.subscriptions", 1), 1U);
  Paced(200, 1000, [&](int) { link.Send(rig.Frame()); });  // fills its buffers
  Subscriber subscriber(daemon.publish, {"body/", "styled/rig.a/rig/"});
  ASSERT_TRUE(subscriber.WaitForBody());
  Paced(240, 120, [&](int) { link.Send(rig.Frame()); });
  ASSERT_TRUE(subscriber.WaitForFrames(240, "styled/"));
  const auto frames = subscriber.Frames("styled/");
  for (std::size_t i = 1; i < frames.size(); ++i) {
    ASSERT_EQ(frames[i].sequence(), frames[i - 1].sequence() + 1);
  }
  EXPECT_EQ(control.Counter("publish.failed"), 0U);
  // libzmq says nothing of what it drops; the kernel shows who takes nothing.
  EXPECT_EQ(control.CounterSoon("publish.stalled_now", 1), 1U);
  EXPECT_EQ(control.Counter("publish.subscribers_stalled"), 1U);
  EXPECT_NE(daemon.Log().find(" has stopped reading"), std::string::npos) << daemon.Log();
  EXPECT_GT(control.Counter("publish.canary_received"), 600U) << "it reads what others asked for";
}

TEST(SubscribersTest, TwoLateOnesToOneTopicBothGetTheBodyAtOnce) {
  Daemon daemon;
  const UdpLink link(daemon.udp);
  ControlClient control(daemon.control);
  Rig rig("a");
  link.Send(rig.Body());
  EXPECT_EQ(control.CounterSoon("pipeline.performers", 1), 1U);
  for (int late = 0; late < 2; ++late) {
    Sleep(0.3);
    const auto before = control.Counter("publish.bodies");
    Subscriber subscriber(daemon.publish, {"body/rig.a/", "styled/rig.a/rig/"});
    ASSERT_TRUE(subscriber.WaitFor([&] { return subscriber.Bodies().size() >= 2; }, 5));
    EXPECT_GE(control.Counter("publish.bodies"), before + 2);
    // Both keep running: to ZeroMQ the second subscription is a repetition.
    static std::vector<std::unique_ptr<Subscriber>> staying;
    staying.push_back(std::make_unique<Subscriber>(
        daemon.publish, std::vector<std::string>{"body/rig.a/", "styled/rig.a/rig/"}));
    ASSERT_TRUE(staying.back()->WaitForBody());
    if (late == 1) staying.clear();
  }
}

TEST(SubscribersTest, ABodyComesOnceASecondAnyway) {
  Daemon daemon;
  const UdpLink link(daemon.udp);
  Rig rig("a");
  link.Send(rig.Body());
  const Subscriber subscriber(daemon.publish, {"body/rig.a/"});
  Sleep(2.5);
  const auto bodies = subscriber.Bodies().size();
  EXPECT_GE(bodies, 4U);
  EXPECT_LE(bodies, 10U);
}

TEST(SubscribersTest, SubscriptionsBeyondTheCapAreCountedAndNotServed) {
  Daemon daemon({"publish.max_subscriptions=100"});
  ControlClient control(daemon.control);
  const UdpLink link(daemon.udp);
  Rig rig("a");
  link.Send(rig.Body());
  Subscriber subscriber(daemon.publish, {"body/", "styled/rig.a/rig/"});
  ASSERT_TRUE(subscriber.WaitForBody());
  const Stalled flood(daemon.publish, 5000);
  EXPECT_EQ(control.CounterSoon("publish.subscriptions_refused", 4902), 4902U);
  EXPECT_EQ(control.Counter("publish.subscriptions"), 100U);
  Paced(60, 120, [&](int) { link.Send(rig.Frame()); });
  ASSERT_TRUE(subscriber.WaitForFrames(60, "styled/"));
}

TEST(SubscribersTest, AnInvalidSubscriptionIsCountedAndIgnored) {
  Daemon daemon;
  ControlClient control(daemon.control);
  void* const context = zmq_ctx_new();
  void* const socket = zmq_socket(context, ZMQ_XSUB);
  zmq_connect(socket, daemon.publish.c_str());
  for (int i = 0; i < 5; ++i) zmq_send(socket, "nonsense", 8, 0);
  EXPECT_EQ(control.CounterSoon("publish.bad_messages", 5), 5U);
  const int none = 0;
  zmq_setsockopt(socket, ZMQ_LINGER, &none, sizeof none);
  zmq_close(socket);
  zmq_ctx_term(context);
}

}  // namespace
}  // namespace styled::support
