#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "daemon/source/rigs/vmc.h"
#include "daemon/source/rigs/vmc_body.h"
#include "sim/rigs/vmc.h"
#include "tests/support/translation.h"
#include "tests/unit/body/random_pose.h"
#include "tests/unit/vmc/bytes.h"

namespace styled::source {
namespace {

using runtime::Counter;
using support::Said;
using support::Translated;
using vmc::testing::BlendMessage;
using vmc::testing::BoneMessage;
using vmc::testing::Bundle;
using vmc::testing::Bytes;
using vmc::testing::RootMessage;
using vmc::testing::TimeMessage;
using Place = std::vector<float>;  // x, y, z of a position and x, y, z, w of a rotation

config::Source Config(std::string performer = "") {
  config::Source config;
  config.name = "stage";
  config.type = "vmc";
  config.performer = std::move(performer);
  return config;
}

// An avatar in the T-pose: +X is its right, as in Unity.
class Avatar {
 public:
  Avatar() {
    places = {{"Hips", {0, 1, 0, 0, 0, 0, 1}},
              {"Spine", {0, 0.1F, 0, 0, 0, 0, 1}},
              {"Head", {0, 0.5F, 0, 0, 0, 0, 1}}};
    for (const auto& [side, x] : {std::pair{"Left", -1.0F}, {"Right", 1.0F}}) {
      const auto add = [&](const char* name, float dx, float dy) {
        places.emplace_back(std::string(side) + name, Place{x * dx, dy, 0, 0, 0, 0, 1});
      };
      add("UpperArm", 0.15F, 0.3F);
      add("LowerArm", 0.3F, 0);
      add("Hand", 0.2F, 0);
      add("UpperLeg", 0.1F, -0.05F);
      add("LowerLeg", 0, -0.4F);
      add("Foot", 0, -0.5F);
    }
  }

  Place& operator[](std::string_view name) {
    for (auto& [bone, place] : places) {
      if (bone == name) return place;
    }
    return places.emplace_back(name, Place{0, 0, 0, 0, 0, 0, 1}).second;
  }
  void Remove(std::string_view name) {
    std::erase_if(places, [name](const auto& row) { return row.first == name; });
  }
  std::vector<Bytes> Messages() const {
    std::vector<Bytes> messages;
    for (const auto& [bone, place] : places) messages.push_back(BoneMessage(bone, place));
    return messages;
  }
  // One bundle, T first.
  Bytes At(float time_s, std::vector<Bytes> more = {}) const {
    more.insert(more.begin(), RootMessage());
    return WithoutRoot(time_s, std::move(more));
  }
  Bytes WithoutRoot(float time_s, std::vector<Bytes> more = {}) const {
    std::vector<Bytes> messages{TimeMessage(time_s)};
    for (Bytes& message : Messages()) messages.push_back(std::move(message));
    for (Bytes& message : more) messages.push_back(std::move(message));
    return Bundle(messages);
  }

  std::vector<std::pair<std::string, Place>> places;
};

// Returns the messages about a datagram, and about the silence that ends a first frame.
std::vector<Translated::Item> SaidWithSilence(Translated& translated, const Bytes& datagram,
                                              std::uint64_t peer = 1) {
  auto said = Said(translated, datagram, peer);
  translated.now_ns += 10'000'000;
  translated.Tick();
  for (auto& item : translated.items) said.push_back(item);
  translated.items.clear();
  translated.now_ns += 6'000'000;
  return said;
}

int JointOf(const v1::Body& body, std::string_view name) {
  for (int j = 0; j < body.names_size(); ++j) {
    if (body.names(j) == name) return j;
  }
  return -1;
}
std::vector<float> Offset(const v1::Body& body, std::string_view name) {
  const int j = JointOf(body, name);
  return {body.offsets(3 * j), body.offsets(3 * j + 1), body.offsets(3 * j + 2)};
}
std::vector<float> Rotation(const v1::Body& body, const v1::SourceFrame& frame,
                            std::string_view name) {
  const int j = JointOf(body, name);
  return {frame.rotations(4 * j), frame.rotations(4 * j + 1), frame.rotations(4 * j + 2),
          frame.rotations(4 * j + 3)};
}
auto Near(const std::vector<float>& values) {
  return ::testing::Pointwise(::testing::FloatNear(1e-5F), values);
}

// A sender of hands alone has no hips, and gives the hand's rotation in the room; its bones may be
// anywhere.
TEST(VmcTranslator, HandsAreEnoughForASourceOfFingers) {
  config::Source config = Config("gloves");
  config.merge_into = "stage.anna";
  config.parts = {"fingers"};
  Translated translated(MakeVmc(config));
  const float half = std::sqrt(0.5F);
  std::vector<Translated::Item> said;
  for (int i = 0; i < 30; ++i) {
    const float x = 0.02F * static_cast<float>(i / 15);  // the hand moves, and stays there
    const std::vector<Bytes> messages{
        TimeMessage(1 + 0.1F * static_cast<float>(i)),
        BoneMessage("LeftHand", {0.5F + x, 1.2F, 0, 0, half, 0, half}),
        BoneMessage("LeftIndexProximal", {-0.09F, 0, 0, 0, 0, half, half}),
        BoneMessage("LeftIndexIntermediate", {-0.03F, 0, 0, 0, 0, 0, 1}), BlendMessage("Joy", 1)};
    for (auto& item : SaidWithSilence(translated, Bundle(messages))) said.push_back(item);
  }
  translated.items = said;
  const auto bodies = translated.Bodies();
  const auto frames = translated.Frames();
  ASSERT_FALSE(bodies.empty());
  ASSERT_GT(frames.size(), 20U);
  const v1::Body& body = bodies.front();
  for (const char* const name : {"Hips", "LeftHand", "RightHand", "LeftIndexProximal"}) {
    EXPECT_GE(JointOf(body, name), 0) << name;
  }
  for (const v1::Body& other : bodies) {
    EXPECT_EQ(other.SerializeAsString(), body.SerializeAsString()) << "one body, wherever it is";
  }
  EXPECT_THAT(Rotation(body, frames.back(), "LeftIndexProximal"), Near({0, 0, -half, half}));
  EXPECT_EQ(frames.back().expressions_size(), 0) << "the face is not merged";
}

TEST(VmcTranslator, FaceAndFingersOfASourceArriveIndependently) {
  config::Source config = Config("gloves");
  config.merge_into = "stage.anna";
  config.parts = {"face", "fingers"};
  Translated translated(MakeVmc(config));
  int faces = 0, poses = 0;
  for (int i = 0; i < 10; ++i) {
    const Bytes datagram = Bundle({TimeMessage(1 + 0.1F * static_cast<float>(i)),
                                   BoneMessage("RightIndexProximal", {0.09F, 0, 0, 0, 0, 0, 1}),
                                   BlendMessage("Joy", 1)});
    for (const auto& item : SaidWithSilence(translated, datagram)) {
      if (!item.is_frame) continue;
      faces += item.frame.expressions_size() > 0 ? 1 : 0;
      poses += item.frame.rotations_size() > 0 ? 1 : 0;
      EXPECT_FALSE(item.frame.expressions_size() > 0 && item.frame.rotations_size() > 0);
    }
  }
  EXPECT_GT(faces, 5);
  EXPECT_GT(poses, 5);
}

// Six hundred instants in one datagram: a cycle of the pipeline must not be made of them.
TEST(VmcTranslator, ADatagramMakesAFewFramesAtMost) {
  Translated translated(MakeVmc(Config()));
  const Avatar avatar;
  for (int i = 0; i < 3; ++i) (void)SaidWithSilence(translated, avatar.At(static_cast<float>(i)));
  std::vector<Bytes> messages;
  for (int i = 0; i < 600; ++i) {
    messages.push_back(TimeMessage(10 + 0.01F * static_cast<float>(i)));
    messages.push_back(BoneMessage("Hips", {0, 1, 0, 0, 0, 0, 1}));
  }
  translated.items.clear();
  translated.Handle(Bundle(messages));
  translated.Handle(Bundle({TimeMessage(20), BoneMessage("Hips", {0, 1, 0, 0, 0, 0, 1})}));
  EXPECT_LE(translated.Frames().size(), 6U);
  EXPECT_GT(translated.Count(Counter::kSourceMalformed), 500U);
}

TEST(VmcTranslator, RefusesWhatIsNotOsc) {
  Translated translation(MakeVmc(Config()));
  EXPECT_TRUE(Said(translation, {}).empty());
  EXPECT_TRUE(Said(translation, vmc::testing::ToBytes("STYD")).empty());
  EXPECT_EQ(translation.Count(Counter::kSourceMalformed), 2U);
  EXPECT_FALSE(SaidWithSilence(translation, Avatar().At(1)).empty());
  EXPECT_TRUE(Said(translation, vmc::testing::ToBytes("STYD")).empty());
  EXPECT_EQ(translation.Count(Counter::kSourceMalformed), 3U);
}

TEST(VmcTranslator, TakesNobodyForASenderWhoSpeaksOfNoBone) {
  Translated translation(MakeVmc(Config()));
  for (std::uint64_t peer = 1; peer < 100; ++peer) {
    EXPECT_TRUE(Said(translation, Bundle({TimeMessage(1), BlendMessage("A", 1)}), peer).empty());
  }
  EXPECT_EQ(translation.Count(Counter::kSourceIgnored), 99U);
  EXPECT_FALSE(SaidWithSilence(translation, Avatar().At(1), 100).empty());
}

TEST(VmcTranslator, CountsMessagesThatItCannotUse) {
  Translated translation(MakeVmc(Config()));
  (void)Said(translation, Avatar().At(1, {BoneMessage("Tail"),
                                          vmc::testing::S("/VMC/Ext/T") + vmc::testing::S(",i") +
                                              vmc::testing::I(1),
                                          vmc::testing::S("/VMC/Ext/Cam") + vmc::testing::S(",")}));
  EXPECT_EQ(translation.Count(Counter::kSourceMalformed), 2U);
  EXPECT_EQ(translation.Count(Counter::kSourceIgnored), 1U);
}

TEST(VmcTranslator, IsCalledAsTheSourceOrAsTheConfigSays) {
  Translated named(MakeVmc(Config("anna")));
  EXPECT_EQ(SaidWithSilence(named, Avatar().At(1)).back().frame.performer(), "anna");
  Translated unnamed(MakeVmc(Config()));
  EXPECT_EQ(SaidWithSilence(unnamed, Avatar().At(1)).back().frame.performer(), "stage");
}

TEST(VmcTranslator, GivesTheBodyAndTheFirstFrameAfterASilenceAndTheNextAtOnce) {
  Translated translation(MakeVmc(Config()));
  EXPECT_TRUE(Said(translation, Avatar().At(1)).empty());
  EXPECT_GT(translation.translator().NextDeadline_ns(), translation.now_ns);
  translation.now_ns = translation.translator().NextDeadline_ns();
  translation.Tick();
  ASSERT_EQ(translation.items.size(), 2U);
  EXPECT_FALSE(translation.items[0].is_frame);
  EXPECT_TRUE(translation.items[1].is_frame);
  EXPECT_EQ(translation.translator().NextDeadline_ns(), Translator::kNever);
  EXPECT_EQ(Said(translation, Avatar().At(1.016F)).size(), 1U);
}

TEST(VmcTranslator, BodyIsMadeOfTheBonesThatComeWithLeftAtPlusX) {
  Translated translation(MakeVmc(Config()));
  Avatar avatar;
  avatar["LeftEye"] = {-0.03F, 0.06F, 0.08F, 0, 0, 0, 1};
  avatar["RightIndexDistal"] = {0.025F, 0, 0, 0, 0, 0, 1};
  const auto said = SaidWithSilence(translation, avatar.At(1));
  ASSERT_EQ(said.size(), 2U);
  const v1::Body& body = said[0].body;
  EXPECT_EQ(body.names_size(), 17);
  EXPECT_EQ(body.names(0), "Hips");
  EXPECT_EQ(body.dialect(), "vmc");
  EXPECT_EQ(body.metres_per_unit(), 1);
  EXPECT_THAT(Offset(body, "LeftLowerArm"), Near({0.3F, 0, 0}));
  EXPECT_THAT(Offset(body, "RightUpperLeg"), Near({-0.1F, -0.05F, 0}));
  EXPECT_THAT(Offset(body, "LeftEye"), Near({0.03F, 0.06F, 0.08F}));
  EXPECT_THAT(Offset(body, "Hips"), Near({0, 0.95F, 0})) << "above the feet, wherever it was";
  // No neck, no chest, no inner finger: the nearest there is.
  EXPECT_EQ(body.parents(JointOf(body, "Head")), JointOf(body, "Spine"));
  EXPECT_EQ(body.parents(JointOf(body, "LeftUpperArm")), JointOf(body, "Spine"));
  EXPECT_EQ(body.parents(JointOf(body, "RightIndexDistal")), JointOf(body, "RightHand"));
  const auto pose = support::CanonicalPose(body, said[1].frame);
  ASSERT_TRUE(pose);
  EXPECT_LT(support::Between(*pose, body::Pose()).joint_deg, 0.1F);
}

// By hand: in Unity the left arm hangs when its quaternion turns -x to -y.
TEST(VmcTranslator, RotationsAreMirrored) {
  Translated translation(MakeVmc(Config()));
  Avatar avatar;
  const float h = std::sqrt(0.5F);
  avatar["LeftUpperArm"] = {-0.15F, 0.3F, 0, 0, 0, h, h};
  avatar["Head"] = {0, 0.5F, 0, 0.1F, 0.7F, -0.1F, 0.7F};
  const auto said = SaidWithSilence(translation, avatar.At(1));
  ASSERT_EQ(said.size(), 2U);
  EXPECT_THAT(Rotation(said[0].body, said[1].frame, "LeftUpperArm"), Near({0, 0, -h, h}));
  EXPECT_THAT(Rotation(said[0].body, said[1].frame, "Head"), Near({0.1F, -0.7F, 0.1F, 0.7F}));
  const auto pose = support::CanonicalPose(said[0].body, said[1].frame);
  ASSERT_TRUE(pose);
  body::WorldPose world;
  body::ForwardKinematics(*pose, world);
  const body::Vec3 arm =
      world.positions_m[body::kLeftLowerArm] - world.positions_m[body::kLeftUpperArm];
  EXPECT_GT(world.positions_m[body::kLeftUpperArm].x(), 0) << "left is +X";
  EXPECT_LT((arm - body::Vec3(0, -0.27F, 0)).norm(), 1e-4F) << "the arm hangs";
}

// By hand: the root stands at (1, 0, 2) and is turned by 90 degrees, which takes Unity's z to x;
// the hips are 1 up and 0.5 ahead in it.
TEST(VmcTranslator, RootAndHipsAreComposed) {
  Translated translation(MakeVmc(Config()));
  Avatar avatar;
  avatar["Hips"] = {0, 1, 0.5F, 0, 0, 0, 1};
  const float h = std::sqrt(0.5F);
  const Bytes root = vmc::testing::S("/VMC/Ext/Root/Pos") + vmc::testing::S(",sfffffff") +
                     vmc::testing::S("root") + vmc::testing::Floats({1, 0, 2, 0, h, 0, h});
  auto said = SaidWithSilence(translation, avatar.At(1, {root}));
  ASSERT_EQ(said.size(), 2U);
  const auto place = [](const v1::SourceFrame& frame) {
    return std::vector<float>(frame.root_position().begin(), frame.root_position().end());
  };
  EXPECT_THAT(place(said[1].frame), Near({-1.5F, 1, 2}));
  EXPECT_THAT(Rotation(said[0].body, said[1].frame, "Hips"), Near({0, -h, 0, h}));
  // It stays where a frame does not repeat it.
  said = SaidWithSilence(translation, avatar.WithoutRoot(1.02F));
  ASSERT_FALSE(said.empty());
  EXPECT_THAT(place(said.back().frame), Near({-1.5F, 1, 2}));
}

// The first frames of a sender that was met in the middle of a frame have no root.
TEST(VmcTranslator, NoFrameLeavesBeforeTheRootCame) {
  Translated translation(MakeVmc(Config()));
  const Avatar avatar;
  for (int i = 0; i < 10; ++i) {
    const float time_s = 1 + 0.016F * static_cast<float>(i);
    EXPECT_TRUE(SaidWithSilence(translation, avatar.WithoutRoot(time_s)).empty());
  }
  EXPECT_EQ(translation.Count(Counter::kSourceIncomplete), 10U);
  const auto said = SaidWithSilence(translation, avatar.At(1.2F, {RootMessage(3)}));
  ASSERT_EQ(said.size(), 2U);
  EXPECT_EQ(said[1].frame.root_position(0), -3);
  EXPECT_TRUE(translation.notes.empty());
  // After a restart the old root may be another one's.
  EXPECT_TRUE(SaidWithSilence(translation, avatar.WithoutRoot(0)).empty());
  EXPECT_EQ(SaidWithSilence(translation, avatar.At(0.1F)).back().frame.root_position(0), 0);
}

TEST(VmcTranslator, ASenderWithoutRootIsAtTheOriginAfterASecondAndThatIsSaidOnce) {
  Translated translation(MakeVmc(Config()));
  Avatar avatar;
  avatar["Hips"] = {0.5F, 1, 0, 0, 0, 0, 1};
  int frames = 0;
  const auto send = [&](float time_s) {
    for (const auto& item : SaidWithSilence(translation, avatar.WithoutRoot(time_s))) {
      if (!item.is_frame) continue;
      ++frames;
      EXPECT_EQ(item.frame.root_position(0), -0.5F);
    }
  };
  for (int i = 0; i < 62; ++i) send(1 + 0.016F * static_cast<float>(i));
  EXPECT_EQ(frames, 0);
  for (int i = 62; i < 1000; ++i) send(1 + 0.016F * static_cast<float>(i));
  EXPECT_GT(frames, 930);
  // Restarted, it is still one that sends none.
  const int before = frames;
  for (int i = 0; i < 10; ++i) send(0.016F * static_cast<float>(i));
  EXPECT_EQ(frames, before + 10);
  ASSERT_EQ(translation.notes.size(), 1U);
  EXPECT_THAT(translation.notes[0], ::testing::HasSubstr("stage: VMC sends no /VMC/Ext/Root/Pos"));
}

// What a sender of these bones is refused for, after `seconds`; "": it is not.
std::vector<std::string> Refusals(const std::vector<std::string>& bones,
                                  const config::Source& config = Config(), int seconds = 20) {
  Translated translation(MakeVmc(config));
  std::vector<std::string> refusals;
  int bodies = 0;
  for (int i = 0; i < 60 * seconds; ++i) {
    std::vector<Bytes> messages{TimeMessage(static_cast<float>(i) / 60), RootMessage()};
    for (const std::string& bone : bones) messages.push_back(BoneMessage(bone, 0.1F));
    messages.push_back(BlendMessage("Joy", 0.5F));
    for (const auto& item : SaidWithSilence(translation, Bundle(messages))) {
      EXPECT_FALSE(item.is_frame && !item.refusal.empty());
      if (!item.is_frame && !item.refusal.empty()) ++bodies;
      if (item.is_frame || item.refusal.empty()) continue;
      if (refusals.empty() || refusals.back() != item.refusal) refusals.push_back(item.refusal);
    }
    EXPECT_TRUE(i > 55 || bodies == 0) << "it may be the end of a frame";
  }
  EXPECT_TRUE(translation.notes.empty()) << "the pipeline logs it";
  EXPECT_LE(bodies, 2 * seconds + 1) << "twice a second is enough to be listed";
  if (!refusals.empty()) EXPECT_GE(bodies, 3 * seconds / 2);
  return refusals;
}

TEST(VmcTranslator, AnUpperBodyHandsOrAFaceAreRefusedForOneReasonThatNamesBones) {
  using ::testing::ElementsAre;
  EXPECT_THAT(Refusals({"LeftHand", "RightHand", "Head"}),
              ElementsAre("VMC sends no leg bones: found Head, LeftHand, RightHand, missing Hips, "
                          "LeftUpperLeg, RightUpperLeg, LeftLowerLeg, RightLowerLeg, LeftUpperArm, "
                          "RightUpperArm, LeftLowerArm, RightLowerArm, expected a whole body: let "
                          "the application send all bones of its avatar"));
  EXPECT_THAT(Refusals({"Hips", "Spine", "Chest", "Neck", "Head", "LeftShoulder", "LeftUpperArm",
                        "LeftLowerArm", "LeftHand", "RightUpperArm", "RightLowerArm"}),
              ElementsAre("VMC sends no leg bones: found Hips, Spine, Chest, Neck, Head, "
                          "LeftShoulder, LeftUpperArm, RightUpperArm and 3 more, missing "
                          "LeftUpperLeg, RightUpperLeg, LeftLowerLeg, RightLowerLeg, expected a "
                          "whole body: let the application send all bones of its avatar"));
  EXPECT_THAT(Refusals({"LeftIndexProximal", "LeftHand"}),
              ElementsAre(::testing::EndsWith(
                  "or give its fingers to a performer by merge_into and parts = [\"fingers\"]")));
  EXPECT_THAT(
      Refusals({"Hips", "Head", "LeftUpperLeg", "RightUpperLeg", "LeftLowerLeg", "RightLowerLeg"}),
      ElementsAre(::testing::StartsWith("VMC sends no arm bones: found Hips,")));
  EXPECT_THAT(Refusals({}), ElementsAre(::testing::StartsWith(
                                "VMC sends expressions and no bones: found a face, expected")));
}

TEST(VmcTranslator, WithJointNamesSetByHandThePipelineJudgesTheBones) {
  config::Source config = Config();
  config.joints = {{"head", "Neck"}};
  EXPECT_THAT(Refusals({"Hips", "Neck", "LeftUpperLeg"}, config, 3), ::testing::IsEmpty());
}

// An application that tracks the legs from its third second on.
TEST(VmcTranslator, ASenderIsAPerformerAsSoonAsItSendsAWholeBody) {
  Translated translation(MakeVmc(Config()));
  Avatar whole, upper;
  for (const char* side : {"Left", "Right"}) {
    for (const char* bone : {"UpperLeg", "LowerLeg", "Foot"}) {
      upper.Remove(std::string(side) + bone);
    }
  }
  int refused = 0, frames = 0;
  for (int i = 0; i < 300; ++i) {
    const float time_s = static_cast<float>(i) / 60;
    for (const auto& item :
         SaidWithSilence(translation, i < 180 ? upper.At(time_s) : whole.At(time_s))) {
      refused += !item.refusal.empty() ? 1 : 0;
      frames += item.is_frame ? 1 : 0;
      if (i >= 180) EXPECT_TRUE(item.refusal.empty());
    }
  }
  EXPECT_GT(refused, 2);
  EXPECT_GE(frames, 118);
}

// A face beside a body: only the body counts.
TEST(VmcTranslator, AFaceOfAnotherApplicationIsNotListedBesideABody) {
  Translated translation(MakeVmc(Config()));
  const Avatar avatar;
  for (int i = 0; i < 300; ++i) {
    const float time_s = static_cast<float>(i) / 60;
    EXPECT_TRUE(Said(translation, Bundle({TimeMessage(time_s), BlendMessage("A", 1)}), 2).empty());
    EXPECT_FALSE(SaidWithSilence(translation, avatar.At(time_s), 1).empty());
  }
}

TEST(VmcTranslator, BonesAreAsLongAsOursWhereAllPositionsAreZero) {
  Translated translation(MakeVmc(Config()));
  Avatar avatar;
  for (auto& [name, place] : avatar.places) {
    if (name != "Hips") place = {0, 0, 0, 0, 0, 0, 1};
  }
  for (const char* name : {"UpperChest", "LeftThumbDistal", "RightLittleDistal", "Jaw"}) {
    (void)avatar[name];
  }
  const auto said = SaidWithSilence(translation, avatar.At(1));
  ASSERT_EQ(said.size(), 2U);
  EXPECT_THAT(Offset(said[0].body, "LeftLowerLeg"), Near({0, -0.42F, 0}));
  EXPECT_THAT(Offset(said[0].body, "UpperChest"), Near({0, 0.205F, 0})) << "past the chest";
  EXPECT_GT(Offset(said[0].body, "LeftThumbDistal")[0], 0.05F);
  EXPECT_LT(Offset(said[0].body, "RightLittleDistal")[0], -0.1F);
  const auto pose = support::CanonicalPose(said[0].body, said[1].frame);
  ASSERT_TRUE(pose);
  EXPECT_LT(support::Between(*pose, body::Pose()).joint_deg, 0.1F);
}

TEST(VmcTranslator, WaitsForTwoFramesAlikeWhereTheFirstLacksWhatEveryAvatarHas) {
  Translated translation(MakeVmc(Config()));
  Avatar avatar;
  avatar.Remove("LeftFoot");
  EXPECT_TRUE(SaidWithSilence(translation, avatar.At(1)).empty());
  const auto said = SaidWithSilence(translation, avatar.At(1.016F));
  ASSERT_EQ(said.size(), 2U);
  EXPECT_EQ(said[0].body.names_size(), 14);
}

TEST(VmcTranslator, NeverMakesABodyWithoutHips) {
  Translated translation(MakeVmc(Config()));
  Avatar avatar;
  avatar.Remove("Hips");
  for (int i = 0; i < 5; ++i) {
    EXPECT_TRUE(SaidWithSilence(translation, avatar.At(static_cast<float>(i))).empty());
  }
}

TEST(VmcTranslator, ABoneThatDoesNotComeIsNotTracked) {
  Translated translation(MakeVmc(Config()));
  Avatar avatar;
  const v1::Body body = SaidWithSilence(translation, avatar.At(1))[0].body;
  avatar.Remove("LeftHand");
  const auto said = SaidWithSilence(translation, avatar.At(1.016F));
  ASSERT_EQ(said.size(), 1U);
  for (const float value : Rotation(body, said[0].frame, "LeftHand")) {
    EXPECT_TRUE(std::isnan(value));
  }
  EXPECT_THAT(Rotation(body, said[0].frame, "Head"), Near({0, 0, 0, 1}));
  EXPECT_EQ(translation.Count(Counter::kSourceIncomplete), 1U);
}

TEST(VmcTranslator, BonesGoneForHalfASecondLeaveTheBodyUnlessNeeded) {
  Translated translation(MakeVmc(Config()));
  Avatar avatar;
  (void)avatar["Jaw"];
  const auto first = SaidWithSilence(translation, avatar.At(1));
  avatar.Remove("Jaw");
  avatar.Remove("LeftHand");
  std::vector<v1::Body> bodies;
  for (int i = 1; i < 60; ++i) {
    for (const auto& item :
         SaidWithSilence(translation, avatar.At(1 + 0.016F * static_cast<float>(i)))) {
      EXPECT_EQ(item.session, first[0].session);
      if (!item.is_frame) bodies.push_back(item.body);
    }
  }
  ASSERT_EQ(bodies.size(), 1U);
  EXPECT_EQ(JointOf(bodies[0], "Jaw"), -1);
  EXPECT_NE(JointOf(bodies[0], "LeftHand"), -1);
}

TEST(VmcTranslator, ABoneThatComesTwiceRunningJoinsTheBody) {
  Translated translation(MakeVmc(Config()));
  Avatar avatar;
  (void)SaidWithSilence(translation, avatar.At(1));
  (void)avatar["Neck"];
  EXPECT_EQ(SaidWithSilence(translation, avatar.At(1.016F)).size(), 1U);
  const auto said = SaidWithSilence(translation, avatar.At(1.032F));
  ASSERT_EQ(said.size(), 2U);
  EXPECT_EQ(said[0].body.parents(JointOf(said[0].body, "Head")), JointOf(said[0].body, "Neck"));
  EXPECT_EQ(said[1].frame.rotations_size(), 4 * said[0].body.names_size());
}

TEST(VmcTranslator, AnAvatarOfOtherMeasuresIsAnotherBodyOnceItStays) {
  Translated translation(MakeVmc(Config()));
  Avatar avatar;
  const auto first = SaidWithSilence(translation, avatar.At(1));
  int frame = 0;
  const auto next = [&] {
    return SaidWithSilence(translation, avatar.At(1 + 0.016F * static_cast<float>(++frame)));
  };
  // Once is nothing, and neither is what never stands still.
  avatar["LeftFoot"][1] = -0.6F;
  EXPECT_EQ(next().size(), 1U);
  avatar["LeftFoot"][1] = -0.5F;
  EXPECT_EQ(next().size(), 1U);
  for (int i = 0; i < 30; ++i) {
    avatar["LeftFoot"][1] = -0.5F - 0.01F * static_cast<float>(i);
    EXPECT_EQ(next().size(), 1U);
  }
  avatar["LeftFoot"][1] = -0.6F;
  std::vector<v1::Body> bodies;
  for (int i = 0; i < 20; ++i) {
    for (const auto& item : next()) {
      if (!item.is_frame) bodies.push_back(item.body);
      EXPECT_EQ(item.session, first[0].session);
    }
  }
  ASSERT_EQ(bodies.size(), 1U);
  EXPECT_THAT(Offset(bodies[0], "LeftFoot"), Near({0, -0.6F, 0}));
}

TEST(VmcTranslator, SourceTimeIsTheSendersOrArrivalAfterIt) {
  Translated translation(MakeVmc(Config()));
  Avatar avatar;
  EXPECT_EQ(SaidWithSilence(translation, avatar.At(1.5F)).back().frame.source_time_ns(),
            1'500'000'000U);
  // 16 ms later by our clock, without T.
  EXPECT_EQ(SaidWithSilence(translation, Bundle(avatar.Messages())).back().frame.source_time_ns(),
            1'516'000'000U);
  EXPECT_EQ(SaidWithSilence(translation, avatar.At(1.75F)).back().frame.source_time_ns(),
            1'750'000'000U);
}

TEST(VmcTranslator, WithoutAnyTimeItIsTheTimeOfArrival) {
  Translated translation(MakeVmc(Config()));
  std::vector<Bytes> messages = Avatar().Messages();
  messages.push_back(RootMessage());
  const Bytes bytes = Bundle(messages);
  const std::int64_t first_ns = translation.now_ns;
  EXPECT_EQ(SaidWithSilence(translation, bytes).back().frame.source_time_ns(), first_ns);
  EXPECT_EQ(SaidWithSilence(translation, bytes).back().frame.source_time_ns(),
            first_ns + 16'000'000);
}

TEST(VmcTranslator, FramesThatComeTwiceOrLateAreCountedAndNotPassedOn) {
  Translated translation(MakeVmc(Config()));
  Avatar avatar;
  (void)SaidWithSilence(translation, avatar.At(5));
  EXPECT_TRUE(SaidWithSilence(translation, avatar.At(5)).empty());
  EXPECT_TRUE(SaidWithSilence(translation, avatar.At(4.5F)).empty());
  EXPECT_EQ(translation.Count(Counter::kPipelineDuplicate), 1U);
  EXPECT_EQ(translation.Count(Counter::kPipelineReordered), 1U);
  EXPECT_EQ(SaidWithSilence(translation, avatar.At(5.1F)).size(), 1U);
}

TEST(VmcTranslator, TimeThatBeginsAnewIsANewSessionPerhapsOfAnotherAvatar) {
  Translated translation(MakeVmc(Config()));
  Avatar avatar;
  (void)avatar["Jaw"];
  const auto before = SaidWithSilence(translation, avatar.At(50));
  avatar.Remove("Jaw");
  const auto after = SaidWithSilence(translation, avatar.At(0));
  ASSERT_EQ(after.size(), 2U);
  EXPECT_NE(after[0].session, before[0].session);
  EXPECT_EQ(after[0].sequence, 0U);
  EXPECT_EQ(JointOf(after[0].body, "Jaw"), -1);
  EXPECT_EQ(after[1].frame.source_time_ns(), 0U);
}

TEST(VmcTranslator, TwoSendersAreTwoSessionsOfOnePerformer) {
  Translated translation(MakeVmc(Config()));
  const auto one = SaidWithSilence(translation, Avatar().At(100), 1);
  const auto other = SaidWithSilence(translation, Avatar().At(1), 2);
  const auto again = SaidWithSilence(translation, Avatar().At(101), 1);
  EXPECT_NE(one.back().session, other.back().session);
  EXPECT_EQ(one.back().session, again.back().session);
  EXPECT_EQ(one.back().frame.performer(), other.back().frame.performer());
}

TEST(VmcTranslator, ManySendersAreRefusedUntilOthersFallSilent) {
  Translated translation(MakeVmc(Config()));
  for (std::uint64_t peer = 1; peer <= 9; ++peer) {
    EXPECT_EQ(SaidWithSilence(translation, Avatar().At(1), peer).empty(), peer == 9) << peer;
  }
  EXPECT_EQ(translation.Count(Counter::kPipelineSecondSender), 1U);
  translation.now_ns += 11'000'000'000;
  EXPECT_FALSE(SaidWithSilence(translation, Avatar().At(1), 9).empty());
}

TEST(VmcTranslator, ExpressionsAloneAreNoFrame) {
  Translated translation(MakeVmc(Config()));
  (void)SaidWithSilence(translation, Avatar().At(1));
  EXPECT_TRUE(SaidWithSilence(translation, Bundle({BlendMessage("Joy", 1)})).empty());
}

TEST(VmcTranslator, NumbersThatAreNoneStayInTheirBone) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  Translated translation(MakeVmc(Config()));
  Avatar avatar;
  const auto first = SaidWithSilence(translation, avatar.At(1));
  avatar["Hips"] = {kNan, 1, 0, 0, 0, 0, 1};
  avatar["Head"] = {kNan, kNan, kNan, kNan, 0, 0, 1};
  const Bytes root = vmc::testing::S("/VMC/Ext/Root/Pos") + vmc::testing::S(",sfffffff") +
                     vmc::testing::S("root") + vmc::testing::Floats({kNan, 0, 2, 0, 0, 0, 0});
  const auto said = SaidWithSilence(translation, avatar.At(1.016F, {root}));
  ASSERT_EQ(said.size(), 1U) << "the body is the same";
  EXPECT_EQ(said[0].frame.root_position(1), 1);
  EXPECT_EQ(said[0].frame.root_position(0), 0);
  EXPECT_TRUE(std::isnan(Rotation(first[0].body, said[0].frame, "Head")[0]));
  EXPECT_THAT(Rotation(first[0].body, said[0].frame, "Hips"), Near({0, 0, 0, 1}));
}

TEST(VmcTranslator, FromTheSecondFrameOnNothingIsAllocated) {
  Translated translation(MakeVmc(Config()));
  Avatar avatar;
  const auto allocations = [&](const Bytes& bytes) {
    translation.now_ns += 16'000'000;
    return support::Allocations(translation.translator(), bytes, translation.now_ns);
  };
  EXPECT_GT(allocations(avatar.At(10)), 0);     // the count counts
  EXPECT_GT(allocations(avatar.At(10.1F)), 0);  // the body, when the first frame ends
  for (int i = 2; i < 200; ++i) {
    const Bytes frame = avatar.At(10 + 0.016F * static_cast<float>(i),
                                  {BlendMessage("Joy", 1), BoneMessage("Tail")});
    EXPECT_EQ(allocations(frame), 0) << i;
  }
}

// The stand-in's bytes come back as the poses that it was given, whatever the quirks.
TEST(VmcTranslator, GivesThePosesOfTheStandIn) {
  for (const auto& quirks : std::vector<std::vector<std::string>>{
           {},
           {"t-first"},
           {"nested"},
           {"single"},
           {"full"},
           {"full", "vrm1"},
           {"moving-root"},
           {"zero-offsets"},
           {"zero-offsets", "full"},
           {"no-t"},
           {"single", "full", "no-t"},
           {"t-first", "full", "vrm1", "moving-root", "zero-offsets"}}) {
    const std::string name = quirks.empty() ? "none" : quirks.front() + "...";
    rigs::Options options;
    options.quirks = quirks;
    auto rig = rigs::MakeVmc(options);
    ASSERT_TRUE(rig.ok());
    Translated translation(MakeVmc(Config()));
    std::vector<body::Pose> sent;
    for (std::uint64_t index = 0; index < 40; ++index) {
      sent.push_back(body::Random(static_cast<unsigned>(index)).AnyPose());
      rig.value()->Encode({index, static_cast<double>(index) / 60, {&sent.back(), 1}},
                          [&](std::span<const std::byte> bytes) { translation.Handle(bytes); });
      translation.now_ns += 16'666'667;
      translation.Tick();
    }
    ASSERT_EQ(translation.Bodies().size(), 1U) << name;
    const v1::Body body = translation.Bodies()[0];
    const auto frames = translation.Frames();
    ASSERT_EQ(frames.size(), sent.size()) << name;
    for (std::size_t i = 0; i < sent.size(); ++i) {
      const auto got = support::CanonicalPose(body, frames[i]);
      ASSERT_TRUE(got) << name;
      EXPECT_LT(support::Between(*got, sent[i]).joint_deg, 0.1F) << name << " " << i;
      EXPECT_LT(support::Between(*got, sent[i]).hips_m, 1e-4F) << name << " " << i;
    }
    EXPECT_EQ(translation.Count(Counter::kSourceMalformed), 0U) << name;
    EXPECT_EQ(translation.Count(Counter::kSourceIncomplete), 0U) << name;
  }
}

}  // namespace
}  // namespace styled::source
