#include "daemon/source/performer_stream.h"

#include <gtest/gtest.h>

#include "tests/support/translated.h"

namespace styled::source {
namespace {

// One stream, and what its frames say.
struct Fixture : support::Translated {
  struct Nothing final : Translator {
    void Handle(std::span<const std::byte>, const Peer&, std::int64_t, Outbox&) override {}
  };
  Fixture() : Translated(std::make_unique<Nothing>()) {}

  void Send(std::uint64_t lost = 0) {
    outbox.Open(*this, -1);
    rig::RigPose pose(body.skeleton);
    pose.translations[0] = {1, 2, 3};
    stream.Send(pose, {++time_ns, now_ns, lost, nullptr}, outbox);
    outbox.Close();
  }
  void SetBody() {
    outbox.Open(*this, -1);
    stream.SetBody(body, outbox);
    outbox.Close();
  }

  runtime::Counters counters;
  Outbox outbox{0, counters};
  PerformerStream stream{"a"};
  rig::RigBody body{{{"hips", "head"}, {-1, 0}, {{0, 1, 0}, {0, 0.5F, 0}}}, {}, 1, "auto"};
  std::uint64_t time_ns = 0;
};

TEST(PerformerStream, NothingIsReportedBeforeTheBody) {
  Fixture f;
  f.Send();
  EXPECT_TRUE(f.items.empty());
}

TEST(PerformerStream, SendsTheBodyFirstAndAgainEverySecond) {
  Fixture f;
  f.SetBody();
  for (int i = 0; i < 5; ++i) {
    f.Send();
    f.now_ns += 300'000'000;
  }
  std::string order;
  for (const auto& item : f.items) order += item.is_frame ? 'f' : 'b';
  EXPECT_EQ(order, "bffffbf");
  for (std::size_t i = 1; i < f.items.size(); ++i) {
    EXPECT_EQ(f.items[i].sequence, f.items[i - 1].sequence + 1);
    EXPECT_EQ(f.items[i].session, f.items[0].session);
  }
  EXPECT_EQ(f.undecodable, 0);
}

TEST(PerformerStream, ARefusedBodyIsSentAloneTwiceASecondWithTheReason) {
  Fixture f;
  const auto why = std::make_shared<const std::string>("it has no legs");
  const auto refuse = [&] {
    f.outbox.Open(f, -1);
    f.stream.SendRefused(why, f.now_ns, f.outbox);
    f.outbox.Close();
    f.now_ns += 100'000'000;
  };
  refuse();
  EXPECT_TRUE(f.items.empty()) << "there is no body yet";
  f.SetBody();
  for (int i = 0; i < 10; ++i) refuse();
  ASSERT_EQ(f.items.size(), 2U);
  for (const auto& item : f.items) {
    EXPECT_FALSE(item.is_frame);
    EXPECT_EQ(item.refusal, *why);
  }
}

TEST(PerformerStream, LostFramesShowInTheSequenceAndARestartInTheSession) {
  Fixture f;
  f.SetBody();
  f.Send();
  f.Send(3);
  EXPECT_EQ(f.items[2].sequence, f.items[1].sequence + 4);
  f.stream.Restart();
  f.Send();
  ASSERT_EQ(f.items.size(), 5U);
  EXPECT_FALSE(f.items[3].is_frame) << "a session begins with its body";
  EXPECT_NE(f.items[3].session, f.items[0].session);
  EXPECT_EQ(f.items[3].sequence, 0U);
}

TEST(PerformerStream, ANewBodyIsSentAtOnceAndTheSameOneIsNot) {
  Fixture f;
  f.SetBody();
  f.Send();
  f.SetBody();
  f.Send();
  EXPECT_EQ(f.Bodies().size(), 1U);
  f.body.skeleton.offsets[1].y() = 0.6F;
  f.SetBody();
  f.Send();
  ASSERT_EQ(f.Bodies().size(), 2U);
  EXPECT_FLOAT_EQ(f.Bodies()[1].offsets(4), 0.6F);
  EXPECT_NE(f.Frames()[2].body_crc(), f.Frames()[1].body_crc());
}

TEST(PerformerStream, MoreThanABatchArrivesWhole) {
  Fixture f;
  f.SetBody();
  f.outbox.Open(f, -1);
  rig::RigPose pose(f.body.skeleton);
  for (int i = 0; i < 100; ++i) f.stream.Send(pose, {++f.time_ns, f.now_ns, 0, nullptr}, f.outbox);
  f.outbox.Close();
  EXPECT_EQ(f.Frames().size(), 100U);
  EXPECT_EQ(f.undecodable, 0);
}

TEST(PerformerStream, FramesOfOneBatchKeepTheirOwnPoseNameAndFace) {
  Fixture f;
  f.SetBody();
  f.stream.ReserveFace();
  f.outbox.Open(f, -1);
  rig::RigPose pose(f.body.skeleton);
  Face face;
  {
    PerformerStream second("b");  // gone before the batch is passed
    second.SetBody(f.body, f.outbox);
    second.Send(pose, {++f.time_ns, f.now_ns}, f.outbox);
  }
  for (int i = 0; i < 3; ++i) {
    const std::string name = "blend" + std::to_string(i);
    face.expressions = {{name, static_cast<float>(i)}};
    pose.translations[0].x() = static_cast<float>(i);
    f.stream.Send(pose, {++f.time_ns, f.now_ns, 0, nullptr, &face}, f.outbox);
  }
  f.outbox.Close();
  const auto frames = f.Frames();
  ASSERT_EQ(frames.size(), 4U);
  EXPECT_EQ(frames[0].performer(), "b");
  for (int i = 0; i < 3; ++i) {
    const auto& frame = frames[static_cast<std::size_t>(i) + 1];
    EXPECT_EQ(frame.performer(), "a");
    EXPECT_EQ(frame.root_position(0), static_cast<float>(i));
    ASSERT_EQ(frame.expressions_size(), 1);
    EXPECT_EQ(frame.expressions(0).name(), "blend" + std::to_string(i));
  }
}

TEST(PerformerStream, AFaceIsTheBytesThatProtobufWrites) {
  v1::SourceFrame message;
  Face face;
  const std::string thru = "/VMC/Thru/x", empty, longest(300, 'x');
  const std::vector<std::pair<std::string_view, float>> rows{
      {"Joy", 0.5F}, {"\xE3\x81\x82", 1.0F}, {"", 2.0F}, {"zero", 0.0F}, {"minus zero", -0.0F},
      {"", 0.0F},    {longest, 1.0F}};
  for (const auto& [name, value] : rows) {
    face.expressions.push_back({name, value});
    auto& expression = *message.add_expressions();
    expression.set_name(std::string(name));
    expression.set_value(value);
  }
  for (const std::string* const text : {&thru, &empty, &longest}) {
    face.thru.push_back(std::as_bytes(std::span(*text)));
    message.add_thru(*text);
  }
  std::vector<std::byte> bytes(kMaxFace);
  const std::size_t size = EncodeFace(face, bytes);
  EXPECT_EQ(std::string(reinterpret_cast<const char*>(bytes.data()), size),
            message.SerializeAsString());
  EXPECT_EQ(EncodeFace(face, std::span(bytes).first(size)), size);
  EXPECT_EQ(EncodeFace(face, std::span(bytes).first(size - 1)), 0U) << "whole, or left out";
}

TEST(PerformerStream, NamesAreMadeValid) {
  EXPECT_EQ(MakeName("Anna B\xC3\xBC"), "Anna_B__");
  EXPECT_EQ(MakeName(""), "performer");
  EXPECT_EQ(MakeName(std::string(40, 'x')), std::string(32, 'x'));
}

}  // namespace
}  // namespace styled::source
