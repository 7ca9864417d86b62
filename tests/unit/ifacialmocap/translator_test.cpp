#include <gtest/gtest.h>

#include <cmath>

#include "daemon/source/rigs/ifacialmocap.h"
#include "sim/rigs/ifacialmocap.h"
#include "tests/support/translation.h"
#include "tests/unit/ifacialmocap/texts.h"

namespace styled::source {
namespace {

using runtime::Counter;
using support::Said;
using support::Translated;

config::Source Config(std::string server = "") {
  config::Source config;
  config.name = "phone";
  config.type = "ifacialmocap";
  config.merge_into = "stage.anna";
  config.server = std::move(server);
  return config;
}

std::span<const std::byte> Bytes(std::string_view text) { return std::as_bytes(std::span(text)); }

float Value(const Translated::Item& item, std::string_view name) {
  for (const auto& one : item.frame.expressions()) {
    if (one.name() == name) return one.value();
  }
  return NAN;
}

TEST(IFacialMocapTranslator, AnInvalidFaceIsCounted) {
  Translated translation(MakeIFacialMocap(Config()));
  EXPECT_TRUE(Said(translation, {}).empty());
  EXPECT_TRUE(Said(translation, Bytes("=head#1,2,3,4,5,6|")).empty());
  EXPECT_EQ(translation.Count(Counter::kSourceMalformed), 1U);
  EXPECT_EQ(translation.Count(Counter::kSourceIncomplete), 1U);
}

TEST(IFacialMocapTranslator, AFaceHasNumbersOfItsOwn) {
  Translated translation(MakeIFacialMocap(Config()));
  const auto first = Said(translation, Bytes(ifacialmocap::testing::kVersion1));
  const auto second = Said(translation, Bytes(ifacialmocap::testing::kVersion2));
  ASSERT_EQ(first.size(), 1U);
  ASSERT_EQ(second.size(), 1U);
  EXPECT_FLOAT_EQ(Value(first[0], "jawOpen"), 0.12F);
  EXPECT_EQ(Value(second[0], "jawOpen"), 0) << "-3 percent";
  EXPECT_EQ(first[0].session, second[0].session);
  EXPECT_GT(second[0].sequence, first[0].sequence);
}

// The sample on the vendor's page: the head looks 21 degrees up and 6 to the right.
TEST(IFacialMocapTranslator, AFaceAloneHasTheSamplesHead) {
  config::Source config = Config();
  config.merge_into = "";
  config.body = "seated";
  Translated translation(MakeIFacialMocap(config));
  const auto said = Said(translation, Bytes(ifacialmocap::testing::kVersion1));
  ASSERT_EQ(said.size(), 2U);
  EXPECT_EQ(said[0].body.performer(), "phone");
  const auto pose = support::CanonicalPose(said[0].body, said[1].frame);
  ASSERT_TRUE(pose);
  body::WorldPose world;
  body::ForwardKinematics(*pose, world);
  const body::Vec3 ahead = world.rotations[body::kHead] * body::Vec3::UnitZ();
  EXPECT_NEAR(std::asin(ahead.y()) * 57.29578F, 21.49F, 0.1F);
  EXPECT_NEAR(std::atan2(ahead.x(), ahead.z()) * 57.29578F, -6.04F, 0.1F);
  EXPECT_FLOAT_EQ(Value(said[1], "jawOpen"), 0.12F);
}

TEST(IFacialMocapTranslator, AnotherPhoneWaitsUntilTheFirstIsSilent) {
  Translated translation(MakeIFacialMocap(Config()));
  const auto face = Bytes(ifacialmocap::testing::kVersion2);
  EXPECT_EQ(Said(translation, face, 1).size(), 1U);
  EXPECT_TRUE(Said(translation, face, 2).empty());
  EXPECT_EQ(translation.Count(Counter::kPipelineSecondSender), 1U);
  translation.now_ns += 3'000'000'000;
  EXPECT_EQ(Said(translation, face, 2).size(), 1U);
}

TEST(IFacialMocapTranslator, ThePhoneGetsRequestsWhileNothingArrives) {
  EXPECT_EQ(MakeIFacialMocap(Config())->NextDeadline_ns(), Translator::kNever);
  Translated translation(MakeIFacialMocap(Config("192.168.1.20")));
  EXPECT_LE(translation.translator().NextDeadline_ns(), translation.now_ns);
  translation.Tick();
  EXPECT_EQ(translation.translator().NextDeadline_ns(), translation.now_ns + 2'000'000'000);
  translation.now_ns += 1'000'000'000;
  (void)Said(translation, Bytes(ifacialmocap::testing::kVersion2));
  EXPECT_EQ(translation.translator().NextDeadline_ns(), translation.now_ns + 300'000'000)
      << "a phone that stopped is asked before its face is gone";
  translation.now_ns += 300'000'000;
  translation.Tick();
  EXPECT_EQ(translation.translator().NextDeadline_ns(), translation.now_ns + 2'000'000'000);
}

TEST(IFacialMocapTranslator, DoesNotAllocate) {
  const auto translator = MakeIFacialMocap(Config());
  const auto face = Bytes(ifacialmocap::testing::kVersion1);
  (void)support::Allocations(*translator, face, 1);
  EXPECT_EQ(support::Allocations(*translator, face, 2), 0);
}

TEST(IFacialMocapStandIn, SendsOnlyWhenAskedAndWhatWasAsked) {
  for (const auto& [quirks, mark] :
       {std::pair{std::vector<std::string>{}, '&'}, {{"v1", "state"}, '-'}}) {
    auto rig = rigs::MakeIFacialMocap({.quirks = quirks});
    ASSERT_TRUE(rig.ok());
    Translated translation(MakeIFacialMocap(Config()));
    std::string text;
    const auto take = [&](std::span<const std::byte> datagram) {
      text.assign(reinterpret_cast<const char*>(datagram.data()), datagram.size());
      EXPECT_EQ(Said(translation, datagram).size(), 1U) << text;
    };
    rigs::Frame frame;
    frame.time_s = 0.2;
    rig.value()->Encode(frame, take);
    EXPECT_TRUE(text.empty());
    rig.value()->Receive(Bytes(ifacialmocap::kStart), take);
    rig.value()->Encode(frame, take);
    EXPECT_NE(text.find(std::string("jawOpen") + mark), std::string::npos) << text;
  }
}

}  // namespace
}  // namespace styled::source
