#include "daemon/publish/canary.h"

#include <gtest/gtest.h>
#include <zmq.h>

#include <string>

#include "daemon/publish/stalled.h"

namespace styled::publish {
namespace {

using runtime::Counter;

class CanaryTest : public testing::Test {
 protected:
  static constexpr int kMark = 64;
  CanaryTest() : context_(zmq_ctx_new()), publisher_(context_, ZMQ_XPUB) {
    publisher_.Set(ZMQ_SNDHWM, kMark);
    publisher_.Set(ZMQ_XPUB_VERBOSE, 1);
    auto opened = Canary::Open(context_, publisher_, kMark);
    EXPECT_TRUE(opened.ok()) << opened.status().message();
    canary_ = std::move(opened.value());
  }
  ~CanaryTest() override {
    canary_.reset();
    publisher_ = runtime::ZmqSocket();
    zmq_ctx_term(context_);
  }
  void Send(const std::string& topic, int times) {
    // As the pipeline does each cycle; it also learns what has been read.
    (void)publisher_.Get(ZMQ_EVENTS);
    for (int i = 0; i < times; ++i) {
      zmq_send(publisher_.get(), topic.data(), topic.size(), ZMQ_SNDMORE | ZMQ_DONTWAIT);
      zmq_send(publisher_.get(), "payload", 7, ZMQ_DONTWAIT);
      canary_->NoteSent(topic);
    }
  }
  std::uint64_t Drain(Counter counter) {
    canary_->Drain(counters_);
    return counters_.Get(counter);
  }

  void* context_;
  runtime::ZmqSocket publisher_;
  std::unique_ptr<Canary> canary_;
  runtime::Counters counters_;
};

TEST_F(CanaryTest, TheCanaryRequestsNoTopic) {
  EXPECT_EQ(publisher_.Get(ZMQ_EVENTS) & ZMQ_POLLIN, 0) << "its subscription counts for no topic";
}

TEST_F(CanaryTest, AQueueWithRoomMissesNothing) {
  for (int i = 0; i < 20; ++i) {
    Send("styled/rig.a/rig/", 2 * kMark);
    Drain(Counter::kPublishCanaryMissed);
  }
  EXPECT_EQ(Drain(Counter::kPublishCanaryReceived), 40U * kMark);
  EXPECT_EQ(Drain(Counter::kPublishCanaryMissed), 0U);
}

TEST_F(CanaryTest, AFullQueuesLossesAreCountedExactlyOnce) {
  Send("styled/rig.a/rig/", 200);
  Send("frames/rig/", 50);  // does not read those
  const std::uint64_t received = Drain(Counter::kPublishCanaryReceived);
  EXPECT_GE(received, std::uint64_t{2 * kMark});
  EXPECT_LT(received, 200U);
  EXPECT_EQ(Drain(Counter::kPublishCanaryMissed), 200 - received);
  EXPECT_EQ(Drain(Counter::kPublishCanaryMissed), 200 - received);
  Send("source/rig.a/", 10);
  EXPECT_EQ(Drain(Counter::kPublishCanaryMissed), 200 - received) << "it goes on";
  EXPECT_EQ(Drain(Counter::kPublishCanaryReceived), received + 10);
}

// As the kernel writes it: a reader, one that has stopped, one whose network is gone, another port,
// a listener.
constexpr const char* kTable =
    "  sl  local_address rem_address   st tx_queue rx_queue tr tm->when retrnsmt   uid\n"
    "   0: 0100007F:1B59 00000000:0000 0A 00000000:00000000 00:00000000 00000000     0\n"
    "   1: 0100007F:1B59 0100007F:A2C4 01 00000000:00000000 00:00000000 00000000     0\n"
    "   2: 0100007F:1B59 0300000A:1267 01 0001F3A0:00000000 04:0000001D 00000000     0\n"
    "   3: 0100007F:1B59 0400000A:1268 01 000003A0:00000000 01:0000001D 00000005     0\n"
    "   4: 0100007F:1B59 0500000A:1269 01 000003A0:00000000 01:0000001D 00000000     0\n"
    "   5: 0100007F:1B5A 0600000A:126A 01 0001F3A0:00000000 04:0000001D 00000000     0\n"
    "torn lin\n";

TEST(StalledTest, AConnectionThatTakesNothingIsFoundByItsPort) {
  EXPECT_EQ(FindStalled(kTable, 7001),
            (std::vector<std::string>{"10.0.0.3:4711", "10.0.0.4:4712"}));
  EXPECT_EQ(FindStalled(kTable, 7002), (std::vector<std::string>{"10.0.0.6:4714"}));
  EXPECT_TRUE(FindStalled(kTable, 7003).empty());
  EXPECT_TRUE(FindStalled("", 7001).empty());
}

TEST(StalledTest, AStalledIPv6ConnectionIsFound) {
  const std::string line =
      "   1: 00000000000000000000000001000000:1B59 00000000000000000000000001000000:1267 01 "
      "0001F3A0:00000000 04:0000001D 00000000     0\n";
  EXPECT_EQ(FindStalled(line, 7001), (std::vector<std::string>{"[::1]:4711"}));
}

TEST(StalledTest, AStallIsReportedOnceFromTheSecondTableOnAndSoIsItsEnd) {
  StalledSubscribers subscribers("tcp://0.0.0.0:7001");
  std::vector<std::string> fresh, recovered;
  const auto look = [&](std::vector<std::string> stalled) {
    fresh.clear();
    recovered.clear();
    subscribers.Judge(std::move(stalled), fresh, recovered);
  };
  const std::vector<std::string> one{"10.0.0.3:4711"};
  look(one);
  EXPECT_TRUE(fresh.empty()) << "a short pause";
  look(one);
  EXPECT_EQ(fresh, one);
  look(one);
  EXPECT_TRUE(fresh.empty());
  EXPECT_EQ(subscribers.count(), 1U);
  look({});
  EXPECT_TRUE(recovered.empty()) << "between two probes of its window";
  look({});
  EXPECT_EQ(recovered, one);
  EXPECT_EQ(subscribers.count(), 0U);
}

}  // namespace
}  // namespace styled::publish
