#include <gtest/gtest.h>

#include <cmath>

#include "daemon/source/rigs/mvn.h"
#include "model/base/crc32c.h"
#include "proto/rigs/mvn/mvn.h"
#include "tests/support/translated.h"
#include "tests/unit/mvn/packets.h"

namespace styled::source {
namespace {

using runtime::Counter;
using support::Translated;
using Bytes = mvn::testing::Bytes;

constexpr std::int64_t kSecond_ns = 1'000'000'000;

// A T-pose a metre and a half tall, +Z up, left +Y: segment s at (0, y, z).
struct Sender {
  mvn::Header header;
  std::array<mvn::Segment, mvn::kBodySegments> segments;

  Sender() {
    header.sample = 100;
    for (std::size_t s = 0; s < segments.size(); ++s) {
      segments[s].id = static_cast<std::uint32_t>(s + 1);
      segments[s].position = {0, 0.1F * static_cast<float>(s), 1};
    }
    segments[6].position = {0, 0, 1.7F};  // the head above the pelvis: +Z is up
    segments[0].position = {0.5F, 0, 1};
  }

  Bytes Datagram(std::size_t size, const Bytes& out) const {
    return {out.begin(), out.begin() + static_cast<std::ptrdiff_t>(size)};
  }
  Bytes Pose() {
    ++header.sample;
    header.time_ms += 10;
    Bytes out(2000);
    return Datagram(mvn::EncodePose(header, segments, out), out);
  }
  Bytes Name(std::string_view name) const {
    Bytes out(2000);
    return Datagram(mvn::EncodeName(header, name, out), out);
  }
  Bytes Scale(float shift) const {
    std::array<mvn::Scale::Row, mvn::kBodySegments> rows;
    for (std::size_t s = 0; s < rows.size(); ++s) {
      rows[s] = {mvn::kSegments[s].name, {shift * static_cast<float>(s), 0, 1}};
    }
    Bytes out(2000);
    return Datagram(mvn::EncodeScale(header, rows, out), out);
  }
};

config::Source Config() {
  config::Source config;
  config.name = "stage";
  config.type = "mvn";
  return config;
}

// Behind the body's 23 segments, before the fingers' forty.
TEST(MvnTranslator, PropsAreNamedByTypeThirteenOrCounted) {
  for (const bool named : {true, false}) {
    Translated got(MakeMvn(Config()));
    Sender sender;
    std::vector<mvn::Segment> segments(sender.segments.begin(), sender.segments.end());
    for (int i = 0; i < 42; ++i) {
      const auto id = static_cast<std::uint32_t>(24 + i);
      const bool prop = i < 2;
      segments.push_back({id,
                          {prop ? 1.0F + static_cast<float>(i) : 0.0F, 2, 3},
                          {0, prop ? 0.6F : 0.0F, 0, prop ? 0.8F : 1.0F}});
    }
    sender.header.props = 2;
    sender.header.finger_segments = 40;
    Bytes out(4000);
    std::vector<mvn::Scale::Row> rows;
    for (const auto& row : mvn::kSegments) rows.push_back({row.name, {0, 0, 1}});
    if (named) {
      rows.push_back({"Sword", {}});
      rows.push_back({"", {}});
    }
    for (int i = 0; i < 40; ++i) rows.push_back({"finger", {}});
    got.Handle(sender.Name("Anna"));
    got.Handle(sender.Datagram(mvn::EncodeScale(sender.header, rows, out), out));
    for (int k = 0; k < 2; ++k) {
      ++sender.header.sample;
      sender.header.time_ms += 10;
      got.Handle(sender.Datagram(mvn::EncodePose(sender.header, segments, out), out));
    }
    ASSERT_EQ(got.Frames().size(), 2U);
    const v1::SourceFrame frame = got.Frames()[1];
    ASSERT_EQ(frame.props_size(), 2);
    EXPECT_EQ(frame.props(0).name(), named ? "Sword" : "Prop1");
    EXPECT_EQ(frame.props(1).name(), "Prop2");
    EXPECT_EQ(frame.props(1).position(0), 2);
    EXPECT_EQ(frame.props(1).rotation(1), 0.6F);
    EXPECT_EQ(frame.rotations_size(), 4 * 63) << "and the fingers are behind them";
    EXPECT_EQ(frame.rotations(4 * 24 + 3), 1) << "a finger, not a prop";
    // One prop less: the fingers move up.
    segments.erase(segments.begin() + 23);
    sender.header.props = 1;
    ++sender.header.sample;
    sender.header.time_ms += 10;
    got.Handle(sender.Datagram(mvn::EncodePose(sender.header, segments, out), out));
    ASSERT_EQ(got.Frames().size(), 3U);
    EXPECT_EQ(got.Frames()[2].props_size(), 1);
    EXPECT_EQ(got.Frames()[2].rotations(4 * 24 + 3), 1);
    EXPECT_EQ(got.Bodies().size(), 1U) << "the body is the same";
  }
}

TEST(MvnTranslator, CountsWhatItCannotReadAndWhatItHasNoUseFor) {
  Translated got(MakeMvn(Config()));
  got.Handle(Bytes(10));
  got.Handle(Bytes(100));
  Bytes cut = mvn::testing::Quaternions();
  cut.pop_back();
  got.Handle(cut);
  EXPECT_EQ(got.Count(Counter::kSourceMalformed), 3U);
  Bytes joint_angles = mvn::testing::Head("20", 0);
  got.Handle(joint_angles);
  EXPECT_EQ(got.Count(Counter::kSourceIgnored), 1U);
  EXPECT_TRUE(got.items.empty());
}

TEST(MvnTranslator, WaitsForNameAndTPoseThenSendsTheBodyBeforeTheFirstFrame) {
  Translated got(MakeMvn(Config()));
  Sender sender;
  got.Handle(sender.Pose());
  EXPECT_TRUE(got.items.empty()) << "MVN tells name and scale once a second: wait for them";
  got.Handle(sender.Name("Anna B"));
  got.Handle(sender.Scale(0.25F));
  got.Handle(sender.Pose());
  got.Handle(sender.Pose());
  ASSERT_EQ(got.items.size(), 3U);
  ASSERT_FALSE(got.items[0].is_frame);
  const v1::Body& body = got.items[0].body;
  EXPECT_EQ(body.performer(), "Anna_B");
  ASSERT_EQ(body.names_size(), 23);
  EXPECT_EQ(body.names(13), "LeftForeArm");
  EXPECT_EQ(body.parents(13), 12);
  EXPECT_FLOAT_EQ(body.offsets(3 * 13), 0.25F) << "from the T-pose, not from the pose";
  EXPECT_FLOAT_EQ(body.metres_per_unit(), 1);
  const std::string bytes = body.SerializeAsString();
  EXPECT_EQ(got.items[1].frame.body_crc(), Crc32c(std::as_bytes(std::span(bytes))));
  EXPECT_EQ(got.items[2].frame.source_time_ns() - got.items[1].frame.source_time_ns(), 10'000'000U);
  EXPECT_FLOAT_EQ(got.items[2].frame.root_position(0), 0.5F);
}

TEST(MvnTranslator, TakesTheSkeletonFromThePoseWhereNoTPoseComes) {
  Translated got(MakeMvn(Config()));
  Sender sender;
  got.Handle(sender.Pose());
  EXPECT_EQ(got.Count(Counter::kSourceBeforeRestPose), 1U) << "withheld, and counted";
  EXPECT_TRUE(got.notes.empty());
  got.now_ns += 2 * kSecond_ns;
  got.Handle(sender.Pose());
  ASSERT_EQ(got.items.size(), 2U);
  ASSERT_EQ(got.notes.size(), 1U);
  EXPECT_NE(got.notes[0].find("neither name (type 12) nor T-pose (type 13)"), std::string::npos);
  EXPECT_NE(got.notes[0].find("continues as stage, with the bones of its first pose"),
            std::string::npos);
  EXPECT_EQ(got.items[0].body.performer(), "stage") << "the source's name, where none is told";
  EXPECT_FLOAT_EQ(got.items[0].body.offsets(3 * 13 + 1), 0.1F);
  // Told after the fact: another body, announced before the frames that belong to it.
  got.Handle(sender.Scale(0.3F));
  got.Handle(sender.Pose());
  ASSERT_EQ(got.Bodies().size(), 2U);
  EXPECT_FLOAT_EQ(got.Bodies()[1].offsets(3 * 13), 0.3F);
}

TEST(MvnTranslator, MakesLocalRotationsOfGlobalOnesAndNoneWhereNothingIsTracked) {
  Translated got(MakeMvn(Config()));
  Sender sender;
  constexpr float kHalf = 0.70710678F;
  sender.segments[11].rotation = {0, 0, kHalf, kHalf};  // the left shoulder, 90 degrees about z
  sender.segments[12].rotation = {0, 0, -1, 0};         // the arm below it: 180, in the other sign
  sender.segments[16].rotation = {0, 0, 0, 0};          // a knee that is not tracked
  got.Handle(sender.Name("a"));
  got.Handle(sender.Scale(0.1F));
  got.Handle(sender.Pose());
  ASSERT_EQ(got.Frames().size(), 1U);
  const auto& rotations = got.Frames()[0].rotations();
  EXPECT_NEAR(std::abs(rotations[4 * 12 + 2]), kHalf, 1e-6F);
  EXPECT_NEAR(std::abs(rotations[4 * 12 + 3]), kHalf, 1e-6F);
  const auto length = [&rotations](int joint) {
    float sum = 0;
    for (int i = 0; i < 4; ++i) sum += rotations[4 * joint + i] * rotations[4 * joint + i];
    return std::sqrt(sum);
  };
  EXPECT_EQ(length(16), 0) << "the stylist holds it";
  EXPECT_EQ(length(17), 0) << "and what hangs on it";
  EXPECT_NEAR(length(15), 1, 1e-6F);
}

TEST(MvnTranslator, SplitSamplesAreJoinedAndIncompleteOnesCounted) {
  Translated got(MakeMvn(Config()));
  Sender sender;
  got.Handle(sender.Name("a"));
  got.Handle(sender.Scale(0.1F));
  const auto split = [&](int only) {
    mvn::Header header = sender.header;
    header.sample = ++sender.header.sample;
    const std::span<const mvn::Segment> all(sender.segments);
    Bytes out(2000);
    header.last = false;
    if (only != 1) got.Handle(std::span(out).first(mvn::EncodePose(header, all.first(10), out)));
    header.datagram = 1;
    header.last = true;
    if (only != 0) got.Handle(std::span(out).first(mvn::EncodePose(header, all.subspan(10), out)));
  };
  split(-1);
  EXPECT_EQ(got.Frames().size(), 1U);
  split(1);
  EXPECT_EQ(got.Frames().size(), 1U);
  EXPECT_EQ(got.Count(Counter::kSourceIncomplete), 1U);
  split(0);
  split(-1);
  EXPECT_EQ(got.Frames().size(), 2U);
}

// Parts of one sample, none of them marked as the last.
void SendParts(Translated& got, Sender& sender, std::initializer_list<std::size_t> counts,
               bool numbered = true) {
  mvn::Header header = sender.header;
  header.sample = ++sender.header.sample;
  header.last = false;
  std::span<const mvn::Segment> rest(sender.segments);
  Bytes out(2000);
  for (const std::size_t count : counts) {
    got.Handle(std::span(out).first(mvn::EncodePose(header, rest.first(count), out)));
    rest = rest.subspan(count);
    if (numbered) ++header.datagram;
  }
}

TEST(MvnTranslator, ASampleIsWholeWithAllItsSegmentsThoughNoDatagramIsMarkedAsTheLast) {
  Translated got(MakeMvn(Config()));
  Sender sender;
  got.Handle(sender.Name("a"));
  got.Handle(sender.Scale(0.1F));
  SendParts(got, sender, {23});
  EXPECT_EQ(got.Frames().size(), 1U);
  SendParts(got, sender, {10, 13});
  EXPECT_EQ(got.Frames().size(), 2U);
  SendParts(got, sender, {1, 2, 20});
  EXPECT_EQ(got.Frames().size(), 3U);
  EXPECT_EQ(got.Count(Counter::kSourceIncomplete), 0U);
  EXPECT_EQ(got.Count(Counter::kPipelineDuplicate), 0U);
  EXPECT_TRUE(got.notes.empty());
}

TEST(MvnTranslator, ASampleThatNeverGetsAllItsSegmentsIsCountedAndSaidOnceASecond) {
  Translated got(MakeMvn(Config()));
  Sender sender;
  got.Handle(sender.Name("a"));
  got.Handle(sender.Scale(0.1F));
  for (int i = 0; i < 101; ++i) SendParts(got, sender, {5, 7});
  EXPECT_TRUE(got.Frames().empty());
  EXPECT_EQ(got.Count(Counter::kSourceIncomplete), 100U) << "the last one is at hand";
  ASSERT_EQ(got.notes.size(), 1U);
  EXPECT_NE(got.notes[0].find("12 of 23 segments"), std::string::npos) << got.notes[0];
  got.now_ns += kSecond_ns;
  SendParts(got, sender, {5, 7});
  ASSERT_EQ(got.notes.size(), 2U);
  EXPECT_NE(got.notes[1].find("(100 times)"), std::string::npos) << got.notes[1];
}

// Neither sample nor datagram is numbered: each restarts its count, none vanishes.
TEST(MvnTranslator, PartsThatAreNotNumberedAreCounted) {
  Translated got(MakeMvn(Config()));
  Sender sender;
  got.Handle(sender.Name("a"));
  got.Handle(sender.Scale(0.1F));
  for (int i = 0; i < 10; ++i) {
    SendParts(got, sender, {12, 11}, false);
    --sender.header.sample;
  }
  EXPECT_TRUE(got.Frames().empty());
  EXPECT_EQ(got.Count(Counter::kSourceIncomplete), 19U);
}

TEST(MvnTranslator, ExtraBytesBehindAWholePoseAreNotAFault) {
  Translated got(MakeMvn(Config()));
  Sender sender;
  got.Handle(sender.Name("a"));
  got.Handle(sender.Scale(0.1F));
  for (int i = 0; i < 3; ++i) {
    SendParts(got, sender, {23, 0});
    mvn::Header fingers = sender.header;
    fingers.datagram = 2;
    std::array<mvn::Segment, 40> hands;
    Bytes out(2000);
    got.Handle(std::span(out).first(mvn::EncodePose(fingers, hands, out)));
  }
  EXPECT_EQ(got.Frames().size(), 3U);
  EXPECT_EQ(got.Count(Counter::kSourceIncomplete), 0U);
  EXPECT_EQ(got.Count(Counter::kPipelineDuplicate), 0U);
}

TEST(MvnTranslator, FingersThatTheHeaderCountsAreWaitedFor) {
  Translated got(MakeMvn(Config()));
  Sender sender;
  sender.header.finger_segments = 40;
  got.Handle(sender.Name("a"));
  got.Handle(sender.Scale(0.1F));
  SendParts(got, sender, {23});
  EXPECT_TRUE(got.Frames().empty());
  mvn::Header fingers = sender.header;
  fingers.datagram = 1;
  fingers.last = false;
  std::array<mvn::Segment, 40> hands;
  Bytes out(2000);
  got.Handle(std::span(out).first(mvn::EncodePose(fingers, hands, out)));
  ASSERT_EQ(got.Frames().size(), 1U);
  EXPECT_EQ(got.Bodies()[0].names_size(), 63);
}

TEST(MvnTranslator, ACounterThatJumpsBackIsARestartALittleIsAnOldSample) {
  Translated got(MakeMvn(Config()));
  Sender sender;
  sender.header.sample = 5000;
  got.Handle(sender.Name("a"));
  got.Handle(sender.Scale(0.1F));
  got.Handle(sender.Pose());
  const std::uint32_t newest = sender.header.sample;
  got.Handle(sender.Pose());
  sender.header.sample = newest - 1;
  got.Handle(sender.Pose());  // as the first one
  EXPECT_EQ(got.Count(Counter::kPipelineReordered), 1U);
  sender.header.sample = newest;
  got.Handle(sender.Pose());  // as the second one
  EXPECT_EQ(got.Count(Counter::kPipelineDuplicate), 1U);
  EXPECT_EQ(got.Frames().size(), 2U);
  sender.header.sample = 1;
  got.Handle(sender.Pose());
  ASSERT_EQ(got.Frames().size(), 3U);
  EXPECT_NE(got.items.back().session, got.items.front().session);
}

TEST(MvnTranslator, EveryCharacterIsAPerformerAndNoTwoOfASenderShareAName) {
  Translated got(MakeMvn(Config()));
  Sender first;
  Sender second;
  second.header.character = 1;
  Sender elsewhere;
  for (auto* sender : {&first, &second}) {
    got.Handle(sender->Name("Suit"));
    got.Handle(sender->Scale(0.1F));
    got.Handle(sender->Pose());
  }
  got.Handle(elsewhere.Name("Suit"), 2);
  got.Handle(elsewhere.Scale(0.1F), 2);
  got.Handle(elsewhere.Pose(), 2);
  ASSERT_EQ(got.Frames().size(), 3U);
  EXPECT_EQ(got.Frames()[0].performer(), "Suit");
  EXPECT_EQ(got.Frames()[1].performer(), "Suit-2");
  EXPECT_EQ(got.Frames()[2].performer(), "Suit") << "another machine's: the pipeline decides";
  EXPECT_NE(got.items[1].session, got.items[5].session);
}

TEST(MvnTranslator, AStreamWithYUpKeepsItsOwnAxes) {
  Translated got(MakeMvn(Config()));
  Sender sender;
  for (auto& segment : sender.segments) {
    const auto p = segment.position;
    segment.position = {p[1], p[2], p[0]};
  }
  got.Handle(sender.Name("a"));
  got.Handle(sender.Scale(0.25F));  // always with Z up: along +X, so along +Z here
  got.Handle(sender.Pose());
  ASSERT_EQ(got.Bodies().size(), 1U);
  EXPECT_FLOAT_EQ(got.Bodies()[0].offsets(3 * 13 + 2), 0.25F);
}

}  // namespace
}  // namespace styled::source
