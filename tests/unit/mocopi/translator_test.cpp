#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "daemon/source/rigs/mocopi.h"
#include "proto/rigs/mocopi/mocopi.h"
#include "sim/rigs/mocopi.h"
#include "tests/support/translation.h"
#include "tests/unit/body/random_pose.h"
#include "tests/unit/mocopi/decode_cases.h"
#include "tests/unit/mocopi/recording.h"

namespace styled::source {
namespace {

using mocopi::testing::Bytes;
using runtime::Counter;
using support::Said;
using support::Translated;

config::Source Config(std::string performer = "") {
  config::Source config;
  config.name = "phone";
  config.type = "mocopi";
  config.performer = std::move(performer);
  return config;
}

mocopi::Frame StandingFrame(std::uint32_t number) {
  mocopi::Frame frame;
  frame.number = number;
  frame.time_s = static_cast<float>(number) / 60;
  for (auto& bone : frame.bones) bone.rotation = {-0.0F, 0.0F, -0.0F, -1.0F};
  frame.bones[0].position_m = {0.1F, 0.9F, 0.2F};
  return frame;
}
Bytes Written(const mocopi::Frame& frame) {
  Bytes bytes(mocopi::kSkeletonSize);
  bytes.resize(mocopi::Encode({}, frame, bytes));
  return bytes;
}
Bytes Written(const mocopi::Skeleton& skeleton) {
  Bytes bytes(mocopi::kSkeletonSize);
  bytes.resize(mocopi::Encode({}, skeleton, bytes));
  return bytes;
}

TEST(MocopiTranslator, RefusesWhatIsNotMocopi) {
  Translated translation(MakeMocopi(Config()));
  EXPECT_TRUE(Said(translation, {}).empty());
  EXPECT_TRUE(Said(translation, mocopi::testing::Text("STYD")).empty());
  EXPECT_EQ(translation.Count(Counter::kSourceMalformed), 2U);
}

TEST(MocopiTranslator, IsCalledAsTheSourceOrAsTheConfigSays) {
  Translated named(MakeMocopi(Config("anna")));
  EXPECT_EQ(Said(named, Written(StandingFrame(1))).back().frame.performer(), "anna");
  Translated unnamed(MakeMocopi(Config()));
  EXPECT_EQ(Said(unnamed, Written(StandingFrame(1))).back().frame.performer(), "phone");
}

TEST(MocopiTranslator, BeforeASkeletonComesTheBodyIsTheUsualOne) {
  Translated translation(MakeMocopi(Config()));
  const auto said = Said(translation, Written(StandingFrame(1)));
  ASSERT_EQ(said.size(), 2U);
  ASSERT_FALSE(said[0].is_frame);
  EXPECT_EQ(said[0].body.names(14), "l_hand");
  EXPECT_EQ(said[0].body.parents(15), 7);
  EXPECT_FLOAT_EQ(said[0].body.offsets(3 * 14), 0.24234F);
  ASSERT_TRUE(said[1].is_frame);
  EXPECT_FLOAT_EQ(said[1].frame.root_position(1), 0.9F);
  EXPECT_FLOAT_EQ(said[1].frame.rotations(3), -1);  // as received: the pipeline sees to the sign
  EXPECT_EQ(said[1].frame.source_time_ns(), 16'666'667U);
  // A T-pose that the pipeline can bind, at the canonical hips' height of a body of this size.
  const auto pose = support::CanonicalPose(said[0].body, said[1].frame);
  ASSERT_TRUE(pose);
  EXPECT_LT(support::Between(*pose, body::Pose()).joint_deg, 0.1F);
}

TEST(MocopiTranslator, TheSkeletonThatComesIsTheBodyFromThenOnInTheSameSession) {
  Translated translation(MakeMocopi(Config()));
  const auto before = Said(translation, Written(StandingFrame(1)));
  mocopi::Skeleton skeleton = mocopi::UsualSkeleton();
  skeleton[20].rest.position_m[1] = -0.5F;
  EXPECT_TRUE(Said(translation, Written(skeleton)).empty());
  const auto after = Said(translation, Written(StandingFrame(2)));
  ASSERT_EQ(after.size(), 2U);
  ASSERT_FALSE(after[0].is_frame);
  EXPECT_FLOAT_EQ(after[0].body.offsets(3 * 20 + 1), -0.5F);
  EXPECT_EQ(after[1].session, before[1].session);
  EXPECT_NE(after[1].frame.body_crc(), before[1].frame.body_crc());
  // The same one again says nothing.
  EXPECT_TRUE(Said(translation, Written(skeleton)).empty());
  EXPECT_EQ(Said(translation, Written(StandingFrame(3))).size(), 1U);
}

TEST(MocopiTranslator, NumbersThatAreMissingAreLost) {
  Translated translation(MakeMocopi(Config()));
  const auto first = Said(translation, Written(StandingFrame(1)));
  const auto second = Said(translation, Written(StandingFrame(5)));
  EXPECT_EQ(second.back().sequence, first.back().sequence + 4);
  EXPECT_EQ(second.back().session, first.back().session);
}

TEST(MocopiTranslator, FramesThatComeTwiceOrLateAreCountedAndNotPassedOn) {
  Translated translation(MakeMocopi(Config()));
  (void)Said(translation, Written(StandingFrame(100)));
  EXPECT_TRUE(Said(translation, Written(StandingFrame(100))).empty());
  EXPECT_TRUE(Said(translation, Written(StandingFrame(99))).empty());
  EXPECT_TRUE(Said(translation, Written(StandingFrame(41))).empty());
  EXPECT_EQ(translation.Count(Counter::kPipelineDuplicate), 1U);
  EXPECT_EQ(translation.Count(Counter::kPipelineReordered), 2U);
  EXPECT_EQ(Said(translation, Written(StandingFrame(101))).size(), 1U);
}

TEST(MocopiTranslator, NumbersThatBeginAnewAreANewSession) {
  Translated translation(MakeMocopi(Config()));
  const auto before = Said(translation, Written(StandingFrame(100)));
  const auto after = Said(translation, Written(StandingFrame(1)));
  ASSERT_EQ(after.size(), 2U);  // the body again
  EXPECT_NE(after.back().session, before.back().session);
  EXPECT_EQ(after.front().sequence, 0U);
  EXPECT_EQ(after.back().frame.body_crc(), before.back().frame.body_crc());
}

TEST(MocopiTranslator, ARestartWithinTheFirstSecondIsSeenWhenOldFramesKeepComing) {
  Translated translation(MakeMocopi(Config()));
  const auto before = Said(translation, Written(StandingFrame(30)));
  for (std::uint32_t number = 1; number < 5; ++number) {
    EXPECT_TRUE(Said(translation, Written(StandingFrame(number))).empty());
  }
  const auto after = Said(translation, Written(StandingFrame(5)));
  ASSERT_EQ(after.size(), 2U);
  EXPECT_NE(after.back().session, before.back().session);
  EXPECT_EQ(Said(translation, Written(StandingFrame(6))).back().session, after.back().session);
}

TEST(MocopiTranslator, TimeThatBeginsAnewIsANewSessionWhateverTheNumber) {
  Translated translation(MakeMocopi(Config()));
  const auto before = Said(translation, Written(StandingFrame(100)));
  mocopi::Frame frame = StandingFrame(101);
  frame.time_s = 0;
  EXPECT_NE(Said(translation, Written(frame)).back().session, before.back().session);
}

TEST(MocopiTranslator, TwoSendersAreTwoSessionsOfOnePerformer) {
  Translated translation(MakeMocopi(Config()));
  const auto one = Said(translation, Written(StandingFrame(100)), 1);
  const auto other = Said(translation, Written(StandingFrame(1)), 2);
  const auto again = Said(translation, Written(StandingFrame(101)), 1);
  EXPECT_NE(one.back().session, other.back().session);
  EXPECT_EQ(one.back().session, again.back().session);
  EXPECT_EQ(one.back().frame.performer(), other.back().frame.performer());
}

TEST(MocopiTranslator, ManySendersAreRefusedUntilOthersFallSilent) {
  Translated translation(MakeMocopi(Config()));
  for (std::uint64_t peer = 1; peer <= 9; ++peer) {
    EXPECT_EQ(Said(translation, Written(StandingFrame(1)), peer).empty(), peer == 9) << peer;
  }
  EXPECT_EQ(translation.Count(Counter::kPipelineSecondSender), 1U);
  translation.now_ns += 11'000'000'000;
  EXPECT_FALSE(Said(translation, Written(StandingFrame(1)), 9).empty());
}

TEST(MocopiTranslator, ARotationThatIsNoNumberStaysNone) {
  Translated translation(MakeMocopi(Config()));
  mocopi::Frame frame = StandingFrame(1);
  frame.bones[14].rotation[2] = std::numeric_limits<float>::quiet_NaN();
  const auto said = Said(translation, Written(frame));
  EXPECT_TRUE(std::isnan(said.back().frame.rotations(4 * 14 + 2)));
  EXPECT_FLOAT_EQ(said.back().frame.rotations(4 * 13 + 3), -1);
}

TEST(MocopiTranslator, FromTheSecondFrameOnNothingIsAllocated) {
  Translated translation(MakeMocopi(Config()));
  const Bytes skeleton = Written(mocopi::UsualSkeleton());
  const auto allocations = [&](const Bytes& bytes) {
    translation.now_ns += 16'666'667;
    return support::Allocations(translation.translator(), bytes, translation.now_ns);
  };
  EXPECT_GT(allocations(skeleton), 0);  // the count counts
  EXPECT_EQ(allocations(Written(StandingFrame(1))), 0);
  for (std::uint32_t number = 2; number < 200; ++number) {
    const Bytes frame = Written(StandingFrame(number == 150 ? 1 : number));  // a restart, too
    EXPECT_EQ(allocations(frame), 0) << number;
    EXPECT_EQ(allocations(skeleton), 0) << number;
  }
}

// Not ours: the published sample is a stranger's T-pose.
TEST(MocopiTranslator, TheRealOnesFirstFrameStandsInTheTPose) {
  const Bytes skeleton =
      mocopi::testing::ReadRecording("mocopi_sample_skdf.bin", STYLED_DATA_DEFAULT);
  const Bytes frame = mocopi::testing::ReadRecording("mocopi_sample_fram.bin", STYLED_DATA_DEFAULT);
  if (skeleton.empty() || frame.empty()) GTEST_SKIP() << "skipped, no data (set STYLED_DATA)";
  Translated translation(MakeMocopi(Config()));
  EXPECT_TRUE(Said(translation, skeleton).empty());
  const auto said = Said(translation, frame);
  ASSERT_EQ(said.size(), 2U);
  const auto pose = support::CanonicalPose(said[0].body, said[1].frame);
  ASSERT_TRUE(pose);
  const auto distance = support::Between(*pose, body::Pose());
  EXPECT_LT(distance.joint_deg, 0.01F);
  EXPECT_LT(distance.hips_m, 0.025F);  // its toes are on the floor, ours 20 mm above
}

// The stand-in's bytes come back as the poses that it was given, whatever the quirk.
TEST(MocopiTranslator, GivesThePosesOfTheStandIn) {
  for (const auto& quirks : std::vector<std::vector<std::string>>{{}, {"tmcd"}, {"early"}}) {
    rigs::Options options;
    options.quirks = quirks;
    auto rig = rigs::MakeMocopi(options);
    ASSERT_TRUE(rig.ok());
    Translated translation(MakeMocopi(Config()));
    v1::Body body;
    for (std::uint64_t index = 0; index < 50; ++index) {
      const body::Pose pose = body::Random(static_cast<unsigned>(index)).AnyPose();
      std::size_t frames = 0;
      rig.value()->Encode({index, static_cast<double>(index) / 60, {&pose, 1}},
                          [&](std::span<const std::byte> bytes) {
                            for (const auto& said : Said(translation, bytes)) {
                              if (!said.is_frame) body = said.body;
                              if (!said.is_frame) continue;
                              ++frames;
                              const auto got = support::CanonicalPose(body, said.frame);
                              ASSERT_TRUE(got);
                              EXPECT_LT(support::Between(*got, pose).joint_deg, 0.1F) << index;
                              EXPECT_LT(support::Between(*got, pose).hips_m, 1e-4F) << index;
                            }
                          });
      EXPECT_EQ(frames, 1U) << index;
    }
    EXPECT_EQ(translation.Count(Counter::kSourceMalformed), 0U);
  }
}

}  // namespace
}  // namespace styled::source

namespace styled::rigs {
namespace {

std::vector<std::vector<std::byte>> Encoded(Rig& rig, const Frame& frame) {
  std::vector<std::vector<std::byte>> datagrams;
  rig.Encode(frame, [&](std::span<const std::byte> bytes) {
    datagrams.emplace_back(bytes.begin(), bytes.end());
  });
  return datagrams;
}

TEST(MocopiStandIn, RefusesWhatTheRigDoesNotHave) {
  Options options;
  options.quirks = {"lz4"};
  EXPECT_FALSE(MakeMocopi(options).ok());
  options.quirks = {};
  options.performers = {"a", "b"};
  EXPECT_FALSE(MakeMocopi(options).ok());
}

TEST(MocopiStandIn, SendsTheSizesOfTheRealOneAndItsSkeletonEveryThreeAndAHalfSeconds) {
  Options options;
  options.quirks = {"tmcd"};
  const auto with = MakeMocopi(options);
  const auto without = MakeMocopi({});
  const body::Pose pose;
  for (std::uint64_t index = 0; index < 500; ++index) {
    const Frame frame{index, static_cast<double>(index) / 60, {&pose, 1}};
    const auto plain = Encoded(*without.value(), frame);
    const auto coded = Encoded(*with.value(), frame);
    ASSERT_EQ(plain.size(), index % 210 == 0 ? 2U : 1U) << index;
    EXPECT_EQ(plain.front().size(), index % 210 == 0 ? 1821U : 1591U);
    EXPECT_EQ(plain.back().size(), 1591U);
    EXPECT_EQ(coded.back().size(), 1605U);
  }
}

TEST(MocopiStandIn, AtRestSendsTheRealOnesBitsForIdentityNumberedFromOne) {
  const auto rig = MakeMocopi({});
  const body::Pose pose;
  mocopi::Datagram datagram;
  ASSERT_EQ(mocopi::Decode(Encoded(*rig.value(), {0, 0, {&pose, 1}}).back(), datagram),
            mocopi::DecodeResult::kOk);
  EXPECT_EQ(datagram.frame.number, 1U);
  for (const auto& bone : datagram.frame.bones) {
    EXPECT_TRUE(std::signbit(bone.rotation[0]) && !std::signbit(bone.rotation[1]) &&
                std::signbit(bone.rotation[2]));
    EXPECT_EQ(bone.rotation, (std::array<float, 4>{0, 0, 0, -1}));
  }
}

}  // namespace
}  // namespace styled::rigs
