#include "clients/rec/rig_frames.h"

#include <gtest/gtest.h>

#include <cmath>

#include "model/base/crc32c.h"
#include "tests/unit/rec/fakes.h"

namespace styled::rec {
namespace {

using testing::kMillisecond_ns;
using testing::kSecond_ns;
using testing::Published;

struct Sent {
  std::string source;
  native::Datagram header;
  styled::v1::Body body;
  styled::v1::SourceFrame frame;
};

class RigFramesTest : public ::testing::Test {
 protected:
  void Apply(const recording::Record& record) {
    frames_.Apply(record, [this](const std::string& source, std::span<const std::byte> datagram) {
      Sent& sent = sent_.emplace_back();
      sent.source = source;
      ASSERT_EQ(native::Decode(datagram, sent.header), native::DecodeResult::kOk);
      const auto size = static_cast<int>(sent.header.payload.size());
      const void* const data = sent.header.payload.data();
      ASSERT_TRUE(sent.header.kind == native::Kind::kBody ? sent.body.ParseFromArray(data, size)
                                                          : sent.frame.ParseFromArray(data, size));
      if (sent.header.kind == native::Kind::kBody) crc_ = Crc32c(sent.header.payload);
    });
  }
  void ApplyBody() { Apply(Published(0, "body/rig.a/", body_.SerializeAsString())); }
  void ApplyFrame(std::int64_t time_ns, const styled::v1::Frame& frame) {
    Apply(Published(time_ns, "source/rig.a/", frame.SerializeAsString()));
  }
  std::string Kinds() const {
    std::string kinds;
    for (const Sent& sent : sent_) kinds += sent.header.kind == native::Kind::kBody ? 'B' : 'f';
    return kinds;
  }

  styled::v1::Body body_ = testing::MakeBody("rig.a", styled::v1::OUTPUT_RIG, 5);
  std::uint64_t session_ = 100;
  RigFrames frames_{[this] { return ++session_; }};
  std::vector<Sent> sent_;
  std::uint32_t crc_ = 0;
};

TEST(IdOfTopic, AcceptsTopicsOfAPerformerOnly) {
  EXPECT_EQ(IdOfTopic("source/rig.a/", "source/"), "rig.a");
  for (const char* wrong : {"", "source/", "source//", "source/rig.a", "source/rig/", "body/rig.a/",
                            "source/rig.a/rig/", "source/.a/", "source/ri g.a/"}) {
    EXPECT_EQ(IdOfTopic(wrong, "source/"), "") << wrong;
  }
}

TEST_F(RigFramesTest, FramesWithoutABodyOrOfAnotherSizeAreLeftOutAndCounted) {
  ApplyFrame(0, testing::MakeFrame(body_, 1, 1));
  ApplyBody();
  auto frame = testing::MakeFrame(body_, 2, 2);
  frame.set_body_hash(6);
  ApplyFrame(0, frame);
  frame.set_body_hash(5);
  frame.add_rotations(1);
  ApplyFrame(0, frame);
  EXPECT_EQ(Kinds(), "");
  EXPECT_EQ(frames_.without_body(), 3U);
}

TEST_F(RigFramesTest, WhatIsNoFrameOfASourceIsPassedOver) {
  ApplyBody();
  const auto payload = testing::MakeFrame(body_, 1, 1).SerializeAsString();
  for (const char* topic : {"styled/rig.a/rig/", "stats/", "source/x/"}) {
    Apply(Published(0, topic, payload));
  }
  Apply(Published(0, "source/rig.a/", "\xFF\xFF"));
  Apply(Published(0, "body/rig.a/", "\xFF\xFF"));
  recording::Record note;
  note.mutable_note()->set_text("x");
  Apply(note);
  EXPECT_EQ(Kinds(), "");
  EXPECT_EQ(frames_.without_body(), 0U);
}

TEST_F(RigFramesTest, ABodyAndAFrameBecomeTheRigsOwnDatagrams) {
  ApplyBody();
  auto published = testing::MakeFrame(body_, 3, 123'456);
  published.mutable_timecode()->set_frames(7);
  ApplyFrame(0, published);
  ASSERT_EQ(Kinds(), "Bf");
  EXPECT_EQ(sent_[0].source, "rig");
  EXPECT_EQ(sent_[0].body.performer(), "a");
  EXPECT_EQ(sent_[0].body.names_size(), body::kJointCount);
  EXPECT_EQ(sent_[0].body.hash(), 0U);
  EXPECT_EQ(sent_[0].header.session, 101U);
  EXPECT_EQ(sent_[0].header.sequence, 0U);
  EXPECT_EQ(sent_[1].header.sequence, 1U);
  const auto& frame = sent_[1].frame;
  EXPECT_EQ(frame.performer(), "a");
  EXPECT_EQ(frame.source_time_ns(), 123'456U);
  EXPECT_EQ(frame.timecode().frames(), 7U);
  EXPECT_EQ(frame.body_crc(), crc_);
  EXPECT_EQ(frame.root_position(1), 3.0F);
  EXPECT_EQ(frame.rotations_size(), 4 * body::kJointCount);
}

TEST_F(RigFramesTest, RestsOfADialectAreTheDaemonsAndThoseGivenAreTheRigs) {
  ApplyBody();
  ApplyFrame(0, testing::MakeFrame(body_, 1, 1));
  EXPECT_EQ(sent_[0].body.dialect(), "canonical");
  EXPECT_EQ(sent_[0].body.rest_size(), 0);
  body_.set_dialect("given");
  body_.set_hash(6);
  ApplyBody();
  ApplyFrame(0, testing::MakeFrame(body_, 2, 2));
  ASSERT_EQ(Kinds(), "BfBf");
  EXPECT_EQ(sent_[2].body.dialect(), "");
  EXPECT_EQ(sent_[2].body.rest_size(), 4 * body::kJointCount);
}

TEST_F(RigFramesTest, TheBodyComesAgainOnceASecond) {
  ApplyBody();
  for (int i = 0; i < 25; ++i) {
    ApplyFrame(i * 100 * kMillisecond_ns, testing::MakeFrame(body_, i + 1, i + 1));
  }
  EXPECT_EQ(Kinds(), "BffffffffffBffffffffffBfffff");
  for (std::size_t i = 0; i < sent_.size(); ++i) EXPECT_EQ(sent_[i].header.sequence, i);
}

TEST_F(RigFramesTest, HeldJointsAreUnknownAgain) {
  ApplyBody();
  auto frame = testing::MakeFrame(body_, 1, 1);
  frame.add_held_joints(2);
  frame.add_held_joints(4000);
  ApplyFrame(0, frame);
  const auto& rotations = sent_[1].frame.rotations();
  for (int i = 0; i < rotations.size(); ++i) {
    EXPECT_EQ(std::isnan(rotations[i]), i >= 8 && i < 12) << i;
  }
}

TEST_F(RigFramesTest, APoseThatWasRepeatedInSilenceIsNotSent) {
  ApplyBody();
  auto frame = testing::MakeFrame(body_, 1, 1);
  frame.set_flags(styled::v1::FLAG_STALE | styled::v1::FLAG_BYPASS);
  ApplyFrame(0, frame);
  EXPECT_EQ(Kinds(), "");
}

TEST_F(RigFramesTest, ASequenceThatBeganAnewAndAnotherDaemonAreNewSessions) {
  ApplyBody();
  ApplyFrame(0, testing::MakeFrame(body_, 8, 1));
  ApplyFrame(0, testing::MakeFrame(body_, 9, 2));
  ApplyFrame(0, testing::MakeFrame(body_, 1, 3));  // the rig restarted
  auto frame = testing::MakeFrame(body_, 2, 4);
  frame.set_epoch(10);
  ApplyFrame(0, frame);  // the daemon did
  frames_.Restart();
  frame.set_source_sequence(3);
  ApplyFrame(0, frame);
  ASSERT_EQ(Kinds(), "BffBfBfBf");
  EXPECT_EQ(sent_[2].header.session, 101U);
  EXPECT_EQ(sent_[3].header.session, 102U);
  EXPECT_EQ(sent_[3].header.sequence, 0U);
  EXPECT_EQ(sent_[5].header.session, 103U);
  EXPECT_EQ(sent_[7].header.session, 104U);
}

TEST_F(RigFramesTest, ABodyThatWasNotedIsEnoughAndIsSentWithTheFirstFrame) {
  frames_.Note(Published(0, "body/rig.a/", body_.SerializeAsString()));
  EXPECT_EQ(Kinds(), "");
  ApplyFrame(0, testing::MakeFrame(body_, 1, 1));
  EXPECT_EQ(Kinds(), "Bf");
}

}  // namespace
}  // namespace styled::rec
