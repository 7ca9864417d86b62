#include "clients/rec/rig_outlet.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/unit/rec/fakes.h"

namespace styled::rec {
namespace {

using testing::Arrival;
using testing::FakeClock;
using ::testing::HasSubstr;
using testing::kMillisecond_ns;
using testing::kSecond_ns;
using testing::Listener;

std::string BodyDatagram(std::uint64_t session, std::uint64_t sequence,
                         const std::string& name = "a") {
  styled::v1::Body body;
  body.set_performer(name);
  return testing::Datagram(native::Kind::kBody, session, sequence, body.SerializeAsString());
}

std::string FrameDatagram(std::uint64_t session, std::uint64_t sequence,
                          const std::string& name = "a") {
  styled::v1::SourceFrame frame;
  frame.set_performer(name);
  return testing::Datagram(native::Kind::kSourceFrame, session, sequence,
                           frame.SerializeAsString());
}

native::Datagram Header(const std::string& bytes) {
  native::Datagram header;
  EXPECT_EQ(native::Decode(std::as_bytes(std::span(bytes)), header), native::DecodeResult::kOk);
  return header;
}

class RigOutletTest : public ::testing::Test {
 protected:
  RigOutlet Make(bool as_recorded = false) {
    RigOutletOptions options;
    options.to = {{"", listener_.url()}};
    options.as_recorded = as_recorded;
    return RigOutlet(std::move(options), clock_, nullptr);
  }
  void Play(RigOutlet& outlet, const recording::Record& record) {
    const Status status = outlet.Play(record);
    ASSERT_TRUE(status.ok()) << status.message();
  }

  FakeClock clock_;
  Listener listener_;
};

TEST_F(RigOutletTest, AnAddressThatMakesNoSenseAndAnUnknownOriginAreRefused) {
  RigOutlet nowhere({.to = {{"", "http://x"}}}, clock_, nullptr);
  EXPECT_THAT(nowhere.Play(Arrival(0, "x")).message(), HasSubstr("http://x"));
  RigOutlet original({.to = {{"", "original"}}}, clock_, nullptr);
  EXPECT_THAT(original.Play(Arrival(0, "x")).message(),
              HasSubstr("source 'rig': where it listened is not recorded"));
}

TEST_F(RigOutletTest, WhatIsNotOursGoesByteForByte) {
  RigOutlet outlet = Make();
  std::string damaged = FrameDatagram(5, 1);
  damaged.back() ^= 1;
  for (const std::string& bytes : {std::string("MXTP02 and more"), std::string(1, '\0'), damaged}) {
    Play(outlet, Arrival(0, bytes));
    EXPECT_EQ(listener_.Receive(), bytes);
  }
  EXPECT_EQ(outlet.counts().datagrams, 3U);
}

TEST_F(RigOutletTest, OurDatagramsGetASessionOfTheirOwnAndKeepAllElse) {
  RigOutlet outlet = Make();
  const std::string sent = FrameDatagram(5, 41);
  Play(outlet, Arrival(0, sent));
  const std::string first = listener_.Receive();
  EXPECT_NE(Header(first).session, 5U);
  EXPECT_EQ(Header(first).sequence, 41U);
  EXPECT_TRUE(std::ranges::equal(Header(first).payload, Header(sent).payload));
  Play(outlet, Arrival(0, FrameDatagram(5, 42)));
  EXPECT_EQ(Header(listener_.Receive()).session, Header(first).session) << "the same one again";
  outlet.Restart();
  Play(outlet, Arrival(0, sent));
  const auto third = Header(listener_.Receive()).session;
  EXPECT_NE(third, Header(first).session);
  EXPECT_NE(third, 5U);
}

TEST_F(RigOutletTest, PiecesOfAStreamBecomeWholeDatagramsOfANewSessionAndWhatBrokeItGoesAsItCame) {
  for (const char* const type : {"tcp", "usb"}) {
    RigOutlet outlet = Make();
    const std::string stream = BodyDatagram(5, 0) + FrameDatagram(5, 1) + FrameDatagram(5, 2);
    std::uint64_t sequence = 0;
    const auto take = [&](const std::string& piece) {
      recording::Record record = Arrival(0, piece);
      record.mutable_arrival()->set_type(type);
      Play(outlet, record);
    };
    for (std::size_t at = 0; at < stream.size(); at += 25) {
      const auto before = outlet.counts().datagrams;
      take(stream.substr(at, 25));
      for (auto i = before; i < outlet.counts().datagrams; ++i) {
        const std::string received = listener_.Receive();
        EXPECT_NE(Header(received).session, 5U);
        EXPECT_EQ(Header(received).sequence, sequence++);
      }
    }
    EXPECT_EQ(sequence, 3U);
    const std::string begun = FrameDatagram(5, 3).substr(0, 3);
    take(begun);
    EXPECT_EQ(outlet.counts().datagrams, 3U);
    take("no record of ours");
    EXPECT_EQ(listener_.Receive(), begun + "no record of ours");
    take("the daemon had closed it");
    EXPECT_EQ(outlet.counts().datagrams, 4U);
  }
}

TEST_F(RigOutletTest, AsRecordedTheyGoByteForByteToo) {
  RigOutlet outlet = Make(true);
  const std::string sent = BodyDatagram(5, 0);
  Play(outlet, Arrival(0, sent));
  EXPECT_EQ(listener_.Receive(), sent);
}

TEST_F(RigOutletTest, EachSenderHasASocketOfItsOwn) {
  RigOutlet outlet = Make();
  std::vector<int> ports;
  for (const char* peer : {"10.0.0.1:1", "10.0.0.2:1", "10.0.0.1:1"}) {
    Play(outlet, Arrival(0, "x", "rig", peer));
    ASSERT_EQ(listener_.Receive(), "x");
    ports.push_back(listener_.from_port);
  }
  EXPECT_NE(ports[0], ports[1]);
  EXPECT_EQ(ports[0], ports[2]);
}

TEST_F(RigOutletTest, SourcesGoWhereTheyAreSentAndOthersNowhere) {
  Listener suit;
  RigOutlet outlet({.to = {{"suit", suit.url()}, {"rig", listener_.url()}}}, clock_, nullptr);
  Play(outlet, Arrival(0, "to suit", "suit"));
  Play(outlet, Arrival(0, "to rig", "rig"));
  Play(outlet, Arrival(0, "to nobody", "hall"));
  EXPECT_EQ(suit.Receive(), "to suit");
  EXPECT_EQ(listener_.Receive(), "to rig");
  EXPECT_EQ(outlet.counts().elsewhere, 1U);
  EXPECT_EQ(outlet.counts().datagrams, 2U);
}

TEST_F(RigOutletTest, OriginalIsWhereItArrivedOnThisMachineWhereThatWasEveryAddress) {
  RigOutlet outlet({.to = {{"", "original"}}}, clock_, nullptr);
  recording::Record record = Arrival(0, "x");
  record.mutable_arrival()->set_listen("udp://0.0.0.0:" + std::to_string(listener_.port()));
  Play(outlet, record);
  EXPECT_EQ(listener_.Receive(), "x");
}

TEST_F(RigOutletTest, ANewSessionIsPrecededByItsSilenceUpTo150MsAtAnySpeed) {
  RigOutlet outlet = Make();
  Play(outlet, Arrival(0, FrameDatagram(5, 1)));
  Play(outlet, Arrival(kMillisecond_ns, FrameDatagram(5, 2)));
  EXPECT_EQ(clock_.slept_ns, 0);
  Play(outlet, Arrival(31 * kMillisecond_ns, FrameDatagram(6, 0)));
  EXPECT_EQ(clock_.slept_ns, 30 * kMillisecond_ns) << "a second sender is refused again";
  Play(outlet, Arrival(60 * kSecond_ns, FrameDatagram(7, 0)));
  EXPECT_EQ(clock_.slept_ns, 180 * kMillisecond_ns);
  Play(outlet, Arrival(60 * kSecond_ns, FrameDatagram(9, 0, "b")));
  EXPECT_EQ(clock_.slept_ns, 180 * kMillisecond_ns) << "another performer waits for nobody";
  outlet.Restart();
  Play(outlet, Arrival(0, FrameDatagram(7, 0)));
  EXPECT_EQ(clock_.slept_ns, 330 * kMillisecond_ns) << "the same recording once more";
}

TEST_F(RigOutletTest, ThePartThatIsPlayedBeginsWithTheBodiesFromBeforeIt) {
  RigOutlet outlet = Make(true);
  outlet.Note(Arrival(0, BodyDatagram(5, 0)));
  outlet.Note(Arrival(1, BodyDatagram(5, 1)));
  outlet.Note(Arrival(1, FrameDatagram(5, 2)));
  outlet.Note(Arrival(1, BodyDatagram(8, 0, "b")));
  outlet.Note(Arrival(1, "MXTP02"));
  Play(outlet, Arrival(2, FrameDatagram(5, 3)));
  EXPECT_EQ(listener_.Receive(), BodyDatagram(5, 1)) << "the last one";
  EXPECT_EQ(listener_.Receive(), BodyDatagram(8, 0, "b"));
  EXPECT_EQ(listener_.Receive(), FrameDatagram(5, 3));
  Play(outlet, Arrival(2, FrameDatagram(5, 4)));
  EXPECT_EQ(listener_.Receive(), FrameDatagram(5, 4)) << "and once";
}

TEST_F(RigOutletTest, WithoutArrivalsWhatWasPublishedIsSent) {
  RigOutlet outlet({.to = {{"rig", listener_.url()}}, .from_published = true}, clock_, nullptr);
  const auto body = testing::MakeBody("rig.a", styled::v1::OUTPUT_RIG, 5);
  outlet.Note(testing::Published(0, "body/rig.a/", body.SerializeAsString()));
  Play(outlet,
       testing::Published(0, "source/rig.a/", testing::MakeFrame(body, 1, 1).SerializeAsString()));
  EXPECT_EQ(Header(listener_.Receive()).kind, native::Kind::kBody);
  EXPECT_EQ(Header(listener_.Receive()).kind, native::Kind::kSourceFrame);
  EXPECT_EQ(outlet.counts().datagrams, 2U);
}

}  // namespace
}  // namespace styled::rec
