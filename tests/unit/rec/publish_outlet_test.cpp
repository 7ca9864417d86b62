#include "clients/rec/publish_outlet.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>

#include "proto/styled/v1/stats.pb.h"
#include "tests/unit/rec/fakes.h"

namespace styled::rec {
namespace {

using ::testing::HasSubstr;
using testing::Published;

class PublishOutletTest : public ::testing::Test {
 protected:
  void Bind(bool as_recorded = false) {
    auto made = PublishOutlet::Bind("tcp://127.0.0.1:*", as_recorded);
    ASSERT_TRUE(made.ok()) << made.status().message();
    outlet_ = std::move(made.value());
  }
  // Subscribes and waits until the outlet has the subscription.
  void Subscribe(const std::string& topic) {
    const int before = outlet_->subscriptions();
    if (!connected_) socket_.connect(outlet_->endpoint());
    connected_ = true;
    socket_.set(zmq::sockopt::rcvtimeo, 2000);
    socket_.set(zmq::sockopt::subscribe, topic);
    for (int i = 0; i < 1000 && outlet_->subscriptions() == before; ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
      outlet_->Idle();
    }
    ASSERT_GT(outlet_->subscriptions(), before);
  }
  // "TOPIC PAYLOAD", or "none".
  std::string Receive(int wait_ms = 2000) {
    socket_.set(zmq::sockopt::rcvtimeo, wait_ms);
    zmq::message_t topic, payload;
    if (!socket_.recv(topic) || !socket_.recv(payload)) return "none";
    return topic.to_string() + " " + payload.to_string();
  }
  std::string ReceivePayload() {
    const std::string text = Receive();
    return text.substr(text.find(' ') + 1);
  }
  void Play(const recording::Record& record) { ASSERT_TRUE(outlet_->Play(record).ok()); }

  std::unique_ptr<PublishOutlet> outlet_;
  zmq::context_t context_{1};
  zmq::socket_t socket_{context_, zmq::socket_type::sub};
  bool connected_ = false;
  styled::v1::Body body_ = testing::MakeBody("rig.a", styled::v1::OUTPUT_RIG, 5);
  recording::Record BodyRecord() const {
    return Published(0, "body/rig.a/", body_.SerializeAsString());
  }
  recording::Record FrameRecord(std::uint64_t number) const {
    return Published(0, "styled/rig.a/rig/",
                     testing::MakeFrame(body_, number, number).SerializeAsString());
  }
};

TEST_F(PublishOutletTest, AnAddressThatCannotBeBoundIsRefusedByName) {
  EXPECT_THAT(PublishOutlet::Bind("tcp://nowhere", false).status().message(),
              HasSubstr("--publish tcp://nowhere"));
  Bind();
  EXPECT_THAT(PublishOutlet::Bind(outlet_->endpoint(), false).status().message(),
              HasSubstr("Address already in use"));
}

TEST_F(PublishOutletTest, FramesAndStatisticsGetAnotherEpochAndKeepAllElse) {
  Bind();
  Subscribe("");
  std::uint64_t last_epoch = 9;
  for (int pass = 0; pass < 2; ++pass) {
    Play(FrameRecord(4));
    styled::v1::Frame frame, expected = testing::MakeFrame(body_, 4, 4);
    ASSERT_TRUE(frame.ParseFromString(ReceivePayload()));
    EXPECT_NE(frame.epoch(), last_epoch);
    last_epoch = frame.epoch();
    expected.set_epoch(frame.epoch());
    EXPECT_EQ(frame.SerializeAsString(), expected.SerializeAsString());
    styled::v1::Stats stats;
    stats.set_epoch(9);
    stats.set_wall_time_ns(3);
    Play(Published(0, "stats/", stats.SerializeAsString()));
    ASSERT_TRUE(stats.ParseFromString(ReceivePayload()));
    EXPECT_EQ(stats.epoch(), frame.epoch()) << "one daemon's";
    EXPECT_EQ(stats.wall_time_ns(), 3U);
    outlet_->Restart();
  }
  EXPECT_EQ(outlet_->counts().messages, 4U);
}

TEST_F(PublishOutletTest, AsRecordedEverythingIsByteForByteAndWhatIsNoMessageAlwaysIs) {
  Bind(true);
  Subscribe("");
  Play(FrameRecord(4));
  EXPECT_EQ(ReceivePayload(), FrameRecord(4).published().payload());
  outlet_.reset();
  connected_ = false;
  socket_ = zmq::socket_t(context_, zmq::socket_type::sub);
  Bind(false);
  Subscribe("");
  Play(Published(0, "styled/rig.a/rig/", "\xFF\xFF"));
  EXPECT_EQ(Receive(), "styled/rig.a/rig/ \xFF\xFF");
  recording::Record note;
  note.mutable_note()->set_text("not published");
  Play(note);
  EXPECT_EQ(outlet_->counts().messages, 1U);
}

TEST_F(PublishOutletTest, ALateSubscriberGetsTheBodiesAtOnce) {
  Bind();
  body_.set_hash(4);
  Play(BodyRecord());
  body_.set_hash(5);
  Play(BodyRecord());
  const auto canonical = testing::MakeBody("rig.a", styled::v1::OUTPUT_CANONICAL, 6);
  Play(Published(0, "body/rig.a/", canonical.SerializeAsString()));
  const auto other = testing::MakeBody("rig.b", styled::v1::OUTPUT_RIG, 7);
  Play(Published(0, "body/rig.b/", other.SerializeAsString()));
  Subscribe("body/rig.a/");
  EXPECT_EQ(ReceivePayload(), body_.SerializeAsString()) << "the last of its kind";
  EXPECT_EQ(ReceivePayload(), canonical.SerializeAsString());
  EXPECT_EQ(Receive(50), "none");
  Subscribe("styled/rig.a/rig/");  // answered on body/rig.a/
  EXPECT_EQ(ReceivePayload(), body_.SerializeAsString());
  EXPECT_EQ(ReceivePayload(), canonical.SerializeAsString());
  EXPECT_EQ(Receive(50), "none");
}

TEST_F(PublishOutletTest, BodiesFromBeforeThePartThatIsPlayedComeBeforeIt) {
  Bind(true);
  Subscribe("");
  outlet_->Note(BodyRecord());
  EXPECT_EQ(Receive(50), "none");
  Play(FrameRecord(1));
  EXPECT_EQ(ReceivePayload(), body_.SerializeAsString());
  EXPECT_EQ(ReceivePayload(), FrameRecord(1).published().payload());
  Play(FrameRecord(2));
  EXPECT_EQ(ReceivePayload(), FrameRecord(2).published().payload());
}

}  // namespace
}  // namespace styled::rec
