#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "daemon/source/rigs/make.h"
#include "daemon/source/rigs/qtm.h"
#include "sim/rigs/qtm.h"
#include "sim/rigs/qtm_skeleton.h"
#include "tests/support/translation.h"
#include "tests/unit/natnet/performer.h"
#include "tests/unit/qtm/decode_cases.h"

namespace styled::source {
namespace {

using namespace qtm::testing;
using runtime::Counter;
using support::Translated;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr std::int64_t kSecond_ns = 1'000'000'000;

config::Source Config() {
  config::Source config;
  config.name = "suit";
  config.type = "qtm";
  config.server = "192.0.2.7";
  return config;
}

class QtmTranslatorTest : public testing::Test {
 protected:
  QtmTranslatorTest() : translated_(std::make_unique<Qtm>(Config())) {}

  Qtm& translator() { return dynamic_cast<Qtm&>(translated_.translator()); }
  std::string Fault() { return translator().NextFault(); }
  void Handle(const Bytes& packet) { translated_.Handle(packet); }
  void Wait(double seconds) {
    translated_.now_ns += static_cast<std::int64_t>(seconds * 1e9);
    translated_.Tick();
  }
  static Bytes Described(const std::vector<std::string>& names, bool flat = false) {
    qtm::Parameters parameters;
    parameters.skeletons.emplace();
    for (std::size_t k = 0; k < names.size(); ++k) {
      parameters.skeletons->push_back(rigs::DescribeQtmSkeleton(
          names[k], static_cast<std::uint32_t>(100 * (k + 1)), true, flat));
    }
    return Xml(qtm::WriteParameters(parameters, flat ? 20 : 25));
  }
  // Up to the stream.
  void Connect(const Bytes& skeletons) {
    translator().Connected(translated_.now_ns);
    Handle(Command("QTM RT Interface connected"));
    Handle(Command("Version set to 1.25"));
    Handle(Xml("<Q><General><Frequency>120</Frequency></General></Q>"));
    Handle(Xml("<Q><The_3D><AxisUpwards>+Z</AxisUpwards></The_3D></Q>"));
    Handle(skeletons);
    ASSERT_TRUE(translator().ready());
    translated_.items.clear();
  }
  // Whether these parameters were requested.
  bool Answers(const Bytes& xml) {
    const std::uint64_t before = translated_.Count(Counter::kSourceIgnored);
    Handle(xml);
    return translated_.Count(Counter::kSourceIgnored) == before;
  }
  Bytes FrameAt(std::int64_t time_us, std::uint32_t number, const std::vector<body::Pose>& poses,
                bool timecode = false) {
    qtm::Frame& frame = *frame_;
    frame.timestamp_us = time_us;
    frame.number = number;
    frame.has_skeletons = true;
    frame.has_timecode = timecode;
    frame.timecode = qtm::PackSmpte({10, 20, 30, 12});
    frame.skeleton_count = poses.size();
    for (std::size_t k = 0; k < poses.size(); ++k) {
      rigs::PlaceQtmSkeleton(poses[k], static_cast<std::uint32_t>(100 * (k + 1)), true,
                             frame.skeletons[k]);
    }
    Bytes packet(qtm::kMaxPacketSize);
    packet.resize(qtm::EncodeFrame(frame, packet));
    return packet;
  }

  Translated translated_;
  std::int64_t time_us_ = 0;
  std::unique_ptr<qtm::Frame> frame_ = std::make_unique<qtm::Frame>();
};

TEST_F(QtmTranslatorTest, ASkeletonsPosesAreThePerformers) {
  for (const bool flat : {false, true}) {
    translated_.now_ns += 2 * kSecond_ns;
    Connect(Described({"Anna"}, flat));
    for (std::uint32_t i = 0; i < 5; ++i) {
      const body::Pose pose = natnet::testing::BentPose(0.1F * static_cast<float>(i));
      Handle(FrameAt(flat * 1'000'000 + 10'000 * i, i + 1, {pose}));
      const auto frames = translated_.Frames();
      ASSERT_EQ(frames.size(), i + 1U);
      ASSERT_EQ(translated_.Bodies().size(), 1U);
      const v1::Body body = translated_.Bodies()[0];
      EXPECT_EQ(body.performer(), "Anna");
      EXPECT_EQ(body.names(7), "LeftArm");
      const auto got = support::CanonicalPose(body, frames.back());
      ASSERT_TRUE(got);
      const auto distance = support::Between(*got, pose);
      EXPECT_LT(distance.joint_deg, 0.05F);
      EXPECT_LT(distance.hips_m, 0.001F);
    }
  }
  EXPECT_EQ(translated_.Frames().back().source_time_ns(), 1'040'000'000U);
}

TEST_F(QtmTranslatorTest, SeveralSkeletonsAreSeveralPerformersWithValidNames) {
  Connect(Described({"Anna", "Ben & co", "Anna"}));
  const body::Pose pose;
  Handle(FrameAt(0, 1, {pose, pose, pose}));
  std::vector<std::string> names;
  for (const auto& body : translated_.Bodies()) names.push_back(body.performer());
  EXPECT_THAT(names, ElementsAre("Anna", "Ben___co", "Anna-2"));
}

// Their XML alone is larger than any other packet may be.
TEST_F(QtmTranslatorTest, OfTwentySkeletonsWithFingersSixteenPlay) {
  qtm::Parameters parameters;
  parameters.skeletons.emplace();
  for (std::uint32_t k = 0; k < 20; ++k) {
    auto& skeleton = parameters.skeletons->emplace_back(
        rigs::DescribeQtmSkeleton("s" + std::to_string(k), 1000 * (k + 1), true, false));
    for (std::uint32_t s = 0; s < 100; ++s) {
      skeleton.segments.push_back(
          {std::string(200, 'f') + std::to_string(s), 1000 * (k + 1) + 100 + s, 0});
    }
  }
  const Bytes xml = Xml(qtm::WriteParameters(parameters, 25));
  ASSERT_GT(xml.size(), qtm::kMaxPacketSize);
  std::size_t size = 0;
  ASSERT_EQ(qtm::CutPacket(xml, size), rigs::Cut::kRecord);
  EXPECT_GE(translator().max_record(), size);
  Connect(xml);
  EXPECT_EQ(translated_.notes.at(0), "server 192.0.2.7 has 20 skeletons, the first 16 are taken");
  Bytes skeletons;
  for (std::uint32_t k = 0; k < 20; ++k) {
    Part{Join(U32{1}, SegmentOf(1000 * (k + 1), 0, 0, 1, 0, 0, 0, 1))}.AppendTo(skeletons);
  }
  Handle(Data(0, 1, ComponentOf(18, U32{20}, Part{skeletons})));
  EXPECT_EQ(translated_.Frames().size(), 16U);
  EXPECT_EQ(translated_.Count(Counter::kPipelineBeforeBody), 0U);
  EXPECT_EQ(translator().NextDeadline_ns(), Translator::kNever) << "nothing is asked anew";
}

TEST_F(QtmTranslatorTest, OneThatIsNotSeenSendsNothingTheOthersDo) {
  Connect(Described({"a", "b"}));
  const body::Pose pose;
  (void)FrameAt(0, 1, {pose, pose});
  frame_->skeletons[0].segment_count = 0;
  Bytes packet(qtm::kMaxPacketSize);
  packet.resize(qtm::EncodeFrame(*frame_, packet));
  Handle(packet);
  ASSERT_EQ(translated_.Frames().size(), 1U);
  EXPECT_EQ(translated_.Bodies()[0].performer(), "b");
  EXPECT_EQ(translated_.Count(Counter::kPipelineBeforeBody), 0U);
}

TEST_F(QtmTranslatorTest, NamesWhatTheServerSaysAndReadsOldOnes) {
  translator().Connected(translated_.now_ns);
  Handle(Command("QTM RT Interface connected."));
  for (int minor = 25; minor > 20; --minor) Handle(Error("Version NOT supported"));
  EXPECT_EQ(Fault(), "");
  Handle(Command("Version set to 1.20"));
  Handle(Error("Parse error"));
  Handle(Error("Measurement busy"));
  Handle(Described({"a"}, true));
  EXPECT_TRUE(translator().ready());
  EXPECT_THAT(
      translated_.notes,
      ElementsAre("server 192.0.2.7 answers \"GetParameters General\" with \"Parse error\"",
                  "server 192.0.2.7 answers \"GetParameters 3D\" with \"Measurement busy\"; "
                  "+Z is taken to be up",
                  "server 192.0.2.7: QTM RT 1.20, +Z up, skeletons: a"));
}

// Each connection is reported, but those of an unstable server only once a minute.
TEST_F(QtmTranslatorTest, ComplaintsOfAnotherConnectionAreSaidAgain) {
  Connect(Described({}));
  ASSERT_EQ(translated_.notes.size(), 2U);
  Connect(Described({}));
  EXPECT_EQ(translated_.notes.size(), 2U) << "at once";
  Handle(Data(1, 1, ComponentOf(18, U32{0})));  // it streams
  Wait(61);
  Connect(Described({}));
  ASSERT_EQ(translated_.notes.size(), 4U);
  EXPECT_EQ(translated_.notes[2], translated_.notes[0]);
  for (int i = 0; i < 100; ++i) Handle(Error("Error " + std::to_string(i)));
  EXPECT_EQ(translated_.notes.size(), 66U);
  Wait(61);
  Connect(Described({"new"}));
  EXPECT_THAT(translated_.notes.back(), HasSubstr("skeletons: new"));
}

TEST_F(QtmTranslatorTest, GivesUpAServerThatIsTooOldOrFullOrAnother) {
  translator().Connected(translated_.now_ns);
  Handle(Error("Connection refused. Max number of clients reached."));
  EXPECT_EQ(Fault(), "refuses: \"Connection refused. Max number of clients reached.\"");
  EXPECT_EQ(Fault(), "") << "forgotten";
  translator().Connected(translated_.now_ns);
  Handle(Command("220 ftp"));
  EXPECT_EQ(Fault(), "greets with \"220 ftp\", expected \"QTM RT Interface connected\"");
  translator().Connected(translated_.now_ns);
  Handle(Command("QTM RT Interface connected"));
  for (int minor = 25; minor >= 19; --minor) {
    EXPECT_EQ(Fault(), "");
    Handle(Command("Version NOT supported"));
  }
  EXPECT_EQ(Fault(),
            "speaks none of QTM RT 1.25 to 1.19 (skeletons need QTM 2019 or later); it answered "
            "\"Version NOT supported\"");
}

// As in a recording of two connections.
TEST_F(QtmTranslatorTest, AGreetingBeginsTheDialogueAnewAndNothingOfTheOldIsAsked) {
  Connect(Described({}));
  Handle(Error("Parse error"));
  Handle(Error("Parse error"));  // StreamFrames and the request for skeletons would be sent again
  Handle(Command("QTM RT Interface connected"));
  EXPECT_FALSE(translator().ready());
  EXPECT_EQ(translator().NextDeadline_ns(), translated_.now_ns + 5 * kSecond_ns);
  Wait(5);
  EXPECT_EQ(Fault(), "did not answer \"Version 1.25\" within 5 s");
  EXPECT_EQ(translator().NextDeadline_ns(), Translator::kNever);
}

TEST_F(QtmTranslatorTest, GivesUpAServerThatDoesNotAnswer) {
  translator().Connected(translated_.now_ns);
  EXPECT_EQ(translator().NextDeadline_ns(), translated_.now_ns + 5 * kSecond_ns);
  Wait(4.9);
  EXPECT_EQ(Fault(), "");
  Wait(0.2);
  EXPECT_EQ(Fault(), "did not greet within 5 s: is it QTM's port 22223?");
  translator().Connected(translated_.now_ns);
  Handle(Command("QTM RT Interface connected"));
  Wait(5);
  EXPECT_EQ(Fault(), "did not answer \"Version 1.25\" within 5 s");
}

TEST_F(QtmTranslatorTest, WaitsForMeasurementsAndSkeletonsWithoutEnd) {
  Connect(Described({}));
  EXPECT_THAT(translated_.notes.at(0), HasSubstr("has no skeleton: in QTM add one"));
  Handle(Pack(4));
  EXPECT_EQ(translator().NextDeadline_ns(), translated_.now_ns + 5 * kSecond_ns)
      << "asks again whether there is one";
  Wait(5);
  Handle(Described({"a"}));
  EXPECT_EQ(translator().NextDeadline_ns(), Translator::kNever);
  Wait(3600);
  EXPECT_EQ(Fault(), "");
  Handle(FrameAt(0, 1, {body::Pose()}));
  EXPECT_EQ(translated_.Frames().size(), 1U);
}

// A measurement begins between the question for the stream and its answer.
TEST_F(QtmTranslatorTest, AnErrorBeforeTheFirstFrameIsTheStreams) {
  const std::string answers = "server 192.0.2.7 answers ";
  Connect(Described({"a"}));
  translated_.notes.clear();
  translated_.now_ns += kSecond_ns;
  Handle(EventOf(3));
  EXPECT_FALSE(Answers(Described({"b"}))) << "not asked: two answers could not be told apart";
  Handle(Error("Parse error"));
  EXPECT_THAT(translated_.notes, IsEmpty()) << "it is asked without Timecode";
  Handle(Error("No"));
  EXPECT_THAT(translated_.notes,
              ElementsAre(answers + "\"StreamFrames AllFrames Skeleton\" with \"No\""));
  Wait(5);  // asked again
  Handle(FrameAt(0, 1, {body::Pose()}));
  EXPECT_EQ(translated_.Frames().size(), 1U);
  EXPECT_TRUE(Answers(Described({"a"}))) << "what the event called for";
  Handle(Error("Busy"));
  EXPECT_EQ(translated_.notes.back(), "server 192.0.2.7 complains: \"Busy\"");
  translated_.now_ns += 10 * kSecond_ns;
  Handle(EventOf(3));
  Handle(Error("Busy"));
  EXPECT_EQ(translated_.notes.back(), "server 192.0.2.7 complains: \"Busy\"") << "asks for less";
  Handle(Error("Busy"));
  EXPECT_EQ(translated_.notes.back(), answers + "\"GetParameters Skeleton\" with \"Busy\"");
  Wait(5);
  EXPECT_TRUE(Answers(Described({"a"}))) << "asked again";
}

TEST_F(QtmTranslatorTest, SaysOnceThatNoFrameCameAndReadsSkeletonsAnyway) {
  for (const bool no_measurement : {false, true}) {
    translated_.now_ns += 100 * kSecond_ns;
    Connect(Described({"a"}));
    translated_.notes.clear();
    if (no_measurement) Handle(Pack(4));
    Handle(EventOf(1));
    Wait(4.9);
    EXPECT_THAT(translated_.notes, IsEmpty());
    Wait(0.2);
    ASSERT_EQ(translated_.notes.size(), 1U);
    EXPECT_THAT(translated_.notes[0],
                HasSubstr(no_measurement ? "runs no measurement: frames come when"
                                         : "sent no frame within 5 s: frames come when"));
    EXPECT_TRUE(Answers(Described({"a"})));
    Wait(3600);
    EXPECT_EQ(translated_.notes.size(), 1U);
    EXPECT_EQ(Fault(), "");
    Handle(FrameAt(0, 1, {body::Pose()}));
    EXPECT_EQ(translated_.Frames().size(), 1U);
  }
}

TEST_F(QtmTranslatorTest, ParametersThatNobodyAskedForAnswerNothing) {
  translator().Connected(translated_.now_ns);
  Handle(Xml("<Q><The_3D><AxisUpwards>+X</AxisUpwards></The_3D></Q>"));
  Handle(Command("QTM RT Interface connected"));
  Wait(1);
  Handle(Xml("<Q><General>"));
  EXPECT_EQ(translated_.Count(Counter::kSourceIgnored), 2U);
  EXPECT_EQ(Fault(), "") << "not read";
  Wait(4);
  EXPECT_EQ(Fault(), "did not answer \"Version 1.25\" within 5 s");
  Connect(Described({"a"}));
  EXPECT_THAT(translated_.notes.back(), HasSubstr("+Z up, skeletons: a"));
  Handle(Described({}));
  Handle(FrameAt(0, 1, {body::Pose()}));
  EXPECT_EQ(translated_.Frames().size(), 1U) << "a goes on";
}

TEST_F(QtmTranslatorTest, ParametersThatCannotBeUsedEndTheConnection) {
  translator().Connected(translated_.now_ns);
  Handle(Command("QTM RT Interface connected"));
  Handle(Command("Version set to 1.25"));
  Handle(Xml("<Q><General>"));
  EXPECT_THAT(Fault(), HasSubstr("sent parameters that cannot be used: not XML: byte "));
  EXPECT_EQ(translated_.Count(Counter::kSourceMalformed), 1U);
}

TEST_F(QtmTranslatorTest, ARefusedSkeletonIsNamedAndTheOthersPlay) {
  qtm::Parameters parameters;
  parameters.skeletons.emplace();
  parameters.skeletons->push_back({"bad", false, {{"Hips", 1}, {"Hips", 2, 0}}});
  parameters.skeletons->push_back(rigs::DescribeQtmSkeleton("good", 200, true, false));
  const std::string xml = qtm::WriteParameters(parameters, 25);
  Connect(Xml(xml));
  EXPECT_THAT(translated_.notes.at(0),
              "server 192.0.2.7: skeleton bad: segment Hips: its name, or its ID 2, is another's");
  Handle(FrameAt(0, 1, {body::Pose(), body::Pose()}));
  ASSERT_EQ(translated_.Frames().size(), 1U);
  EXPECT_EQ(translated_.Bodies()[0].performer(), "good");
  EXPECT_EQ(translated_.Count(Counter::kPipelineBodiesRefused), 1U);
  EXPECT_EQ(translated_.Count(Counter::kPipelineBeforeBody), 1U);
}

TEST_F(QtmTranslatorTest, AMeasurementThatBeginsIsANewSession) {
  Connect(Described({"a"}));
  Handle(FrameAt(50'000, 5, {body::Pose()}));
  Handle(FrameAt(60'000, 6, {body::Pose()}));
  const std::uint64_t first = translated_.items.back().session;
  EXPECT_EQ(translated_.items.back().sequence, translated_.items[1].sequence + 1);
  Handle(FrameAt(10'000, 1, {body::Pose()}));  // timestamps fall back
  const std::uint64_t second = translated_.items.back().session;
  EXPECT_EQ(second, first + 2);
  Handle(Described({"a"}));
  for (const unsigned event : {1U, 3U, 8U}) {
    translated_.now_ns += 10 * kSecond_ns;
    const std::uint64_t before = translated_.items.back().session;
    Handle(EventOf(event));
    Handle(Described({"a"}));
    Handle(FrameAt(90'000, 2, {body::Pose()}));
    EXPECT_EQ(translated_.items.back().session, before + 2) << event;
  }
  for (const unsigned event : {2U, 4U, 9U, 11U, 200U}) {
    const std::uint64_t before = translated_.items.back().session;
    Handle(EventOf(event));
    Handle(FrameAt(90'000 + event, 3, {body::Pose()}));
    EXPECT_EQ(translated_.items.back().session, before) << event;
  }
  EXPECT_EQ(Fault(), "");
  Handle(EventOf(12));
  EXPECT_EQ(Fault(), "QTM shuts down");
}

// A file may have been captured at another rate, and in a volume whose other axis is up.
TEST_F(QtmTranslatorTest, AFileThatBeginsHasItsOwnRateAndUpwardAxis) {
  Connect(Described({"a"}));
  Handle(FrameAt(0, 1, {body::Pose()}));
  translated_.now_ns += 10 * kSecond_ns;
  Handle(EventOf(8));
  qtm::Parameters parameters;
  parameters.frequency_hz = 240;
  parameters.up = qtm::Axis::kY;
  parameters.skeletons = {rigs::DescribeQtmSkeleton("a", 100, false, false)};
  EXPECT_TRUE(Answers(Xml(qtm::WriteParameters(parameters, 25))));
  EXPECT_THAT(translated_.notes.back(), HasSubstr("240 Hz, +Y up, skeletons: a"));
  frame_->timestamp_us = 20'000;
  rigs::PlaceQtmSkeleton(body::Pose(), 100, false, frame_->skeletons[0]);
  Bytes packet(qtm::kMaxPacketSize);
  packet.resize(qtm::EncodeFrame(*frame_, packet));
  translated_.items.clear();
  Handle(packet);
  ASSERT_EQ(translated_.Frames().size(), 1U);
  const auto pose = support::CanonicalPose(translated_.Bodies().back(), translated_.Frames()[0]);
  ASSERT_TRUE(pose);
  const auto distance = support::Between(*pose, body::Pose());
  EXPECT_LT(distance.joint_deg, 0.05F);
  EXPECT_LT(distance.hips_m, 0.001F);
  // Another connection may be to another QTM.
  translator().Connected(translated_.now_ns);
  Handle(Command("QTM RT Interface connected"));
  Handle(Command("Version set to 1.25"));
  Handle(Error("none"));
  Handle(Error("none"));
  Handle(Described({"a"}));
  EXPECT_THAT(translated_.notes.back(), HasSubstr("QTM RT 1.25, +Z up, skeletons: a"));
}

TEST_F(QtmTranslatorTest, FramesLostAndRepeatedAreTold) {
  Connect(Described({"a"}));
  Handle(FrameAt(0, 1, {body::Pose()}));
  const std::uint64_t first = translated_.items.back().sequence;
  Handle(FrameAt(40'000, 5, {body::Pose()}));
  EXPECT_EQ(translated_.items.back().sequence, first + 4);
  Handle(FrameAt(40'000, 5, {body::Pose()}));
  EXPECT_EQ(translated_.Count(Counter::kPipelineDuplicate), 1U);
  EXPECT_EQ(translated_.Frames().size(), 2U);
}

TEST_F(QtmTranslatorTest, AnUnknownSkeletonMakesItReadThemAnew) {
  Connect(Described({"a"}));
  translated_.now_ns += 2 * kSecond_ns;
  Handle(FrameAt(0, 1, {body::Pose(), body::Pose()}));
  EXPECT_EQ(translated_.Count(Counter::kPipelineBeforeBody), 1U);
  EXPECT_EQ(translator().NextDeadline_ns(), translated_.now_ns + 5 * kSecond_ns) << "asked";
  Handle(Described({"a", "b"}));
  translated_.items.clear();
  Handle(FrameAt(10'000, 2, {body::Pose(), body::Pose()}));
  EXPECT_EQ(translated_.Frames().size(), 2U);
}

TEST_F(QtmTranslatorTest, SkeletonsAreReadAnewEverLessOftenWhileNothingChanges) {
  Connect(Described({"a"}));
  const auto seconds = [this](double from, double to, const std::vector<std::string>& names) {
    std::vector<double> asked;
    const std::int64_t begin_ns = translated_.now_ns;
    for (int i = static_cast<int>(10 * from); i < static_cast<int>(10 * to); ++i) {
      translated_.now_ns = begin_ns + i * kSecond_ns / 10;
      Handle(FrameAt(++time_us_, 1, {body::Pose(), body::Pose()}));
      if (Answers(Described(names))) asked.push_back(i / 10.0);
    }
    return asked;
  };
  EXPECT_THAT(seconds(2, 300, {"a"}), ElementsAre(2, 4, 8, 16, 32, 64, 124, 184, 244));
  EXPECT_THAT(seconds(0, 10, {"a", "c"}), ElementsAre(4.1)) << "c is known, nothing is missing";
  translated_.now_ns += 60 * kSecond_ns;
  EXPECT_THAT(seconds(0, 1, {"a", "c"}), IsEmpty());
  for (int i = 0; i < 3; ++i) {
    translated_.now_ns += 20 * kSecond_ns;
    Handle(EventOf(3));
    EXPECT_TRUE(Answers(Described({"a", "c"}))) << "at once, of measurements in succession";
  }
}

TEST_F(QtmTranslatorTest, AFloodOfEventsAsksOnce) {
  Connect(Described({"a"}));
  Handle(FrameAt(0, 1, {body::Pose()}));
  translated_.now_ns += 2 * kSecond_ns;
  int asked = 0;
  for (int i = 0; i < 7281; ++i) {
    Handle(EventOf(3));
    asked += Answers(Described({"a"})) ? 1 : 0;
  }
  EXPECT_EQ(asked, 1);
  EXPECT_EQ(translator().NextDeadline_ns(), translated_.now_ns + 2 * kSecond_ns) << "the next";
  Wait(2);
  Handle(EventOf(3));
  EXPECT_EQ(translator().NextDeadline_ns(), translated_.now_ns + 5 * kSecond_ns)
      << "asked already: its answer is awaited";
  EXPECT_EQ(Fault(), "");
}

TEST_F(QtmTranslatorTest, TimecodeIsCarried) {
  Connect(Described({"a"}));
  Handle(FrameAt(0, 1, {body::Pose()}, true));
  const auto frame = translated_.Frames().back();
  EXPECT_EQ(frame.timecode().hours(), 10U);
  EXPECT_EQ(frame.timecode().minutes(), 20U);
  EXPECT_EQ(frame.timecode().seconds(), 30U);
  EXPECT_EQ(frame.timecode().frames(), 12U);
}

TEST_F(QtmTranslatorTest, DamageIsCountedAndDisturbsNothing) {
  Connect(Described({"a"}));
  for (const DecodeCase& c : DecodeCases()) {
    if (c.expected != qtm::DecodeResult::kOk) Handle(c.packet);
  }
  EXPECT_EQ(translated_.Count(Counter::kSourceMalformed), 9U);
  EXPECT_THAT(translated_.items, IsEmpty());
  Handle(Pack(5, Any{20}));
  Handle(Xml("<Q/>"));
  EXPECT_EQ(Fault(), "");
  Handle(FrameAt(0, 1, {body::Pose()}));
  EXPECT_EQ(translated_.Frames().size(), 1U);
}

TEST_F(QtmTranslatorTest, DoesNotAllocateForFrames) {
  Connect(Described({"a", "b"}));
  for (std::uint32_t i = 1; i < 10; ++i) {
    Handle(FrameAt(10'000 * i, i, {body::Pose(), body::Pose()}, true));
  }
  const Bytes next = FrameAt(200'000, 20, {body::Pose(), body::Pose()}, true);
  EXPECT_EQ(support::Allocations(translated_.translator(), next, translated_.now_ns), 0);
}

// The requests that frames and events cause, too.
TEST_F(QtmTranslatorTest, DoesNotAllocateToReadSkeletonsAnew) {
  Connect(Described({"a", "b"}));
  Handle(FrameAt(10'000, 1, {body::Pose(), body::Pose()}));
  translated_.now_ns += 2 * kSecond_ns;
  const Bytes unknown = FrameAt(20'000, 2, {body::Pose(), body::Pose(), body::Pose()});
  EXPECT_EQ(support::Allocations(translated_.translator(), unknown, translated_.now_ns), 0);
  EXPECT_EQ(translator().NextDeadline_ns(), translated_.now_ns + 5 * kSecond_ns) << "asked";
  Handle(Described({"a", "b"}));
  translated_.now_ns += 10 * kSecond_ns;
  EXPECT_EQ(support::Allocations(translated_.translator(), EventOf(3), translated_.now_ns), 0);
  EXPECT_EQ(translator().NextDeadline_ns(), translated_.now_ns + 5 * kSecond_ns) << "asked";
}

}  // namespace
}  // namespace styled::source
