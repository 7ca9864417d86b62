#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <map>

#include "daemon/source/rigs/live_link_face.h"
#include "proto/arkit/shapes.h"
#include "sim/rigs/live_link_face.h"
#include "tests/support/translation.h"
#include "tests/unit/livelinkface/decode_cases.h"

namespace styled::source {
namespace {

using live_link_face::testing::Smile;
using live_link_face::testing::Written;
using runtime::Counter;
using support::Said;
using support::Translated;

config::Source Config(std::string expressions = "arkit") {
  config::Source config;
  config.name = "phone";
  config.type = "livelinkface";
  config.merge_into = "stage.anna";
  config.expressions = std::move(expressions);
  return config;
}

std::map<std::string, float> FaceOf(const Translated::Item& item) {
  std::map<std::string, float> face;
  for (const auto& one : item.frame.expressions()) face[one.name()] = one.value();
  return face;
}

TEST(LiveLinkFaceTranslator, WhatIsNoFaceIsCounted) {
  Translated translation(MakeLiveLinkFace(Config()));
  EXPECT_TRUE(Said(translation, {}).empty());
  EXPECT_TRUE(Said(translation, live_link_face::testing::ByHand()).empty());  // no face is seen
  EXPECT_EQ(translation.Count(Counter::kSourceMalformed), 1U);
  EXPECT_EQ(translation.Count(Counter::kSourceIncomplete), 1U);
}

TEST(LiveLinkFaceTranslator, AFaceHasArkitsNamesOrVrmsPresets) {
  Translated named(MakeLiveLinkFace(Config()));
  const auto said = Said(named, Written(Smile()));
  ASSERT_EQ(said.size(), 1U);
  ASSERT_TRUE(said[0].is_frame);
  EXPECT_EQ(said[0].frame.rotations_size(), 0);
  auto face = FaceOf(said[0]);
  EXPECT_EQ(face.size(), arkit::kShapes);
  EXPECT_EQ(face["mouthSmileLeft"], 0.75F);
  EXPECT_EQ(face["jawOpen"], 0);
  Translated vrm(MakeLiveLinkFace(Config("vrm")));
  face = FaceOf(Said(vrm, Written(Smile())).at(0));
  EXPECT_EQ(face.size(), arkit::kPresets.size());
  EXPECT_EQ(face["Joy"], 0.75F);
}

TEST(LiveLinkFaceTranslator, AbsurdWeightsStayBetween0And1) {
  Translated translation(MakeLiveLinkFace(Config()));
  live_link_face::Frame frame = Smile(1);
  (void)Said(translation, Written(frame));
  frame.frame = 2;
  frame.values[23] = std::numeric_limits<float>::quiet_NaN();
  frame.values[24] = 1e30F;
  frame.values[17] = -3;
  auto face = FaceOf(Said(translation, Written(frame)).at(0));
  EXPECT_EQ(face["mouthSmileLeft"], 0.75F) << "the last value is held";
  EXPECT_EQ(face["mouthSmileRight"], 1);
  EXPECT_EQ(face["jawOpen"], 0);
}

TEST(LiveLinkFaceTranslator, OldFramesAreCountedAndARestartIsANewSession) {
  Translated translation(MakeLiveLinkFace(Config()));
  const auto first = Said(translation, Written(Smile(1000)));
  EXPECT_TRUE(Said(translation, Written(Smile(1000))).empty());
  EXPECT_TRUE(Said(translation, Written(Smile(990))).empty());
  EXPECT_EQ(translation.Count(Counter::kPipelineDuplicate), 1U);
  EXPECT_EQ(translation.Count(Counter::kPipelineReordered), 1U);
  const auto next = Said(translation, Written(Smile(1001)));
  ASSERT_EQ(next.size(), 1U);
  EXPECT_EQ(next[0].session, first.at(0).session);
  EXPECT_GT(next[0].sequence, first.at(0).sequence);
  const auto again = Said(translation, Written(Smile(5)));  // the app was restarted
  ASSERT_EQ(again.size(), 1U);
  EXPECT_NE(again[0].session, first.at(0).session);
}

TEST(LiveLinkFaceTranslator, AnotherPhoneWaitsUntilTheFirstIsSilent) {
  Translated translation(MakeLiveLinkFace(Config()));
  (void)Said(translation, Written(Smile(1000)));
  live_link_face::Frame other = Smile(7);
  other.device = "DEVICE-2";
  EXPECT_TRUE(Said(translation, Written(other)).empty());
  EXPECT_EQ(translation.Count(Counter::kPipelineSecondSender), 1U);
  translation.now_ns += 3'000'000'000;
  EXPECT_EQ(Said(translation, Written(other)).size(), 1U);
}

TEST(LiveLinkFaceTranslator, DoesNotAllocate) {
  const auto translator = MakeLiveLinkFace(Config());
  (void)support::Allocations(*translator, Written(Smile(1)), 1);
  EXPECT_EQ(support::Allocations(*translator, Written(Smile(2)), 2), 0);
}

TEST(LiveLinkFaceStandIn, IsReadAndLosesTheFaceWhereAsked) {
  EXPECT_FALSE(rigs::MakeLiveLinkFace({.quirks = {"nonsense"}}).ok());
  rigs::Options options;
  options.quirks = {"lost"};
  auto rig = rigs::MakeLiveLinkFace(options);
  ASSERT_TRUE(rig.ok());
  Translated translation(MakeLiveLinkFace(Config()));
  int faces = 0;
  float widest = 0;
  for (std::uint64_t i = 0; i < 600; ++i) {
    rigs::Frame frame;
    frame.index = i;
    frame.time_s = static_cast<double>(i) / 60;
    rig.value()->Encode(frame, [&](std::span<const std::byte> datagram) {
      for (const auto& item : Said(translation, datagram)) {
        ++faces;
        widest = std::max(widest, FaceOf(item)["jawOpen"]);
      }
    });
  }
  EXPECT_EQ(faces, 480);
  EXPECT_GT(widest, 0.4F);
}

}  // namespace
}  // namespace styled::source
