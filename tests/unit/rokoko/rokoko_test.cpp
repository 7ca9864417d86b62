#include "proto/rigs/rokoko/rokoko.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <random>
#include <vector>

#include "tests/unit/rokoko/lz4_frames.h"
#include "tests/unit/rokoko/texts.h"

namespace styled::rokoko {
namespace {

using Json = nlohmann::json;

std::span<const std::byte> BytesOf(std::string_view text) { return std::as_bytes(std::span(text)); }

TEST(Rokoko, EveryCaseOfTheTableGivesItsReason) {
  Decoder decoder;
  Frame frame;
  for (const testing::DecodeCase& c : testing::DecodeCases()) {
    EXPECT_EQ(Name(decoder.Decode(BytesOf(c.text), frame)), Name(c.expected)) << c.name;
  }
}

TEST(Rokoko, EveryReasonIsReachedByTheTable) {
  const auto cases = testing::DecodeCases();
  for (int reason = 0; reason < static_cast<int>(DecodeResult::kCount); ++reason) {
    EXPECT_TRUE(std::any_of(cases.begin(), cases.end(), [reason](const auto& c) {
      return static_cast<int>(c.expected) == reason;
    })) << Name(DecodeResult(reason));
  }
}

TEST(Rokoko, Layout3IsReadAsItIsWritten) {
  Frame frame;
  ASSERT_EQ(Decoder().DecodeText(testing::kLayout3, frame), DecodeResult::kOk);
  EXPECT_EQ(frame.version, 3);
  EXPECT_EQ(frame.fps, 60);
  EXPECT_EQ(frame.time_s, 12.345678);
  ASSERT_EQ(frame.actor_count, 2);
  const Actor& actor = frame.actors[0];
  EXPECT_EQ(actor.name(), "J\xC3\xBCrgen \"M\" \xF0\x9F\x98\x80");
  EXPECT_EQ(actor.hip_height_m, 0.95F);
  EXPECT_EQ(actor.total_height_m, 1.8F);
  EXPECT_EQ(actor.has.count(), 2U);  // the head has no rotation
  EXPECT_EQ(actor.joints[kHip].position_m, (std::array<float, 3>{0.5F, 0.96F, -0.125F}));
  EXPECT_EQ(actor.joints[kHip].rotation, (std::array<float, 4>{0, 0.25F, 0, 1}));
  const auto arm = static_cast<std::size_t>(FindJoint("leftUpperArm", 0));
  ASSERT_TRUE(actor.has[arm]);
  EXPECT_EQ(actor.joints[arm].position_m, (std::array<float, 3>{1, 2, 3}));
  EXPECT_EQ(actor.joints[arm].rotation, (std::array<float, 4>{-0.5F, -0.5F, 0.5F, -0.5F}));
  EXPECT_TRUE(actor.has_face);
  EXPECT_EQ(actor.face[*arkit::Find("jawOpen")], 0.125F);
  EXPECT_EQ(frame.actors[1].name(), "gloves");
  EXPECT_FALSE(frame.actors[1].has_face);
  EXPECT_TRUE(frame.actors[1].has[kJoints - 1]);
  EXPECT_EQ(frame.actors[1].joints[kJoints - 1].position_m, (std::array<float, 3>{7, 8, 9}));
}

TEST(Rokoko, PropsAreReadInBothLayoutsAndWrongOnesMakeNoFrameWrong) {
  const std::string pose =
      R"("position":{"x":1,"y":2,"z":3},"rotation":{"x":0.5,"y":-0.5,"z":0.5,"w":0.25})";
  const auto with = [](const std::string& props) {
    return testing::WithScene(R"("timestamp":1,"actors":[],"props":)" + props);
  };
  Frame frame;
  Decoder decoder;
  for (const std::string& text :
       {with("[{\"name\":\"cup\",\"color\":[1,2,3],\"type\":2," + pose + "}]"),
        R"({"version":2,"timestamp":1,"actors":[],"props":[{"name":"cup",)" + pose + "}]}"}) {
    ASSERT_EQ(decoder.DecodeText(text, frame), DecodeResult::kOk) << text;
    ASSERT_EQ(frame.prop_count, 1);
    EXPECT_EQ(frame.props_left_out, 0);
    EXPECT_EQ(frame.props[0].name(), "cup");
    EXPECT_EQ(frame.props[0].pose.position_m, (std::array<float, 3>{1, 2, 3}));
    EXPECT_EQ(frame.props[0].pose.rotation, (std::array<float, 4>{0.5F, -0.5F, 0.5F, 0.25F}));
  }
  const std::string good = "{\"name\":\"cup\"," + pose + "}";
  for (const std::string& bad :
       {std::string("{}"), std::string("7"), std::string("[]"), std::string("null"),
        std::string(R"({"name":7,"position":{"x":1},"rotation":[]})"),
        std::string(R"({"name":"a","position":null,"rotation":{"x":0,"y":0,"z":0,"w":1}})")}) {
    ASSERT_EQ(decoder.DecodeText(with("[" + bad + "," + good + "]"), frame), DecodeResult::kOk)
        << bad;
    EXPECT_EQ(frame.prop_count, 1) << bad;
    EXPECT_EQ(frame.props_left_out, 1) << bad;
  }
  for (const char* const number : {"1e300", "\"one\"", "true", "null"}) {
    std::string odd = good;
    odd.replace(odd.find(":1,"), 3, std::string(":") + number + ",");
    ASSERT_EQ(decoder.DecodeText(with("[" + odd + "]"), frame), DecodeResult::kOk) << number;
    const bool absent = std::string(number) == "null";
    ASSERT_EQ(frame.prop_count, absent ? 0 : 1) << number;
    if (!absent) {
      EXPECT_TRUE(std::isnan(frame.props[0].pose.position_m[0])) << number;
    }
  }
  ASSERT_EQ(decoder.DecodeText(with("\"none\""), frame), DecodeResult::kOk);
  EXPECT_EQ(frame.prop_count, 0);
  std::string many = good;
  for (int i = 0; i < 18; ++i) many += "," + good;
  ASSERT_EQ(decoder.DecodeText(with("[" + many + "]"), frame), DecodeResult::kOk);
  EXPECT_EQ(frame.prop_count, kMaxProps);
  EXPECT_EQ(frame.props_left_out, 3);
  // Our encoding is decoded to the same values.
  std::string text(kMaxTextSize, '\0');
  text.resize(EncodeText(frame, text));
  Frame again;
  ASSERT_EQ(decoder.DecodeText(text, again), DecodeResult::kOk);
  ASSERT_EQ(again.prop_count, kMaxProps);
  EXPECT_EQ(again.props[15].pose.rotation, frame.props[15].pose.rotation);
}

TEST(Rokoko, Layout2IsReadAsItIsWritten) {
  Frame frame;
  ASSERT_EQ(Decoder().DecodeText(testing::kLayout2, frame), DecodeResult::kOk);
  EXPECT_EQ(frame.version, 2.5F);
  EXPECT_EQ(frame.time_s, 3.5);
  ASSERT_EQ(frame.actor_count, 1);
  EXPECT_EQ(frame.actors[0].name(), "anna");
  EXPECT_EQ(frame.actors[0].hip_height_m, 0.9F);
  EXPECT_EQ(frame.actors[0].has.count(), 2U);
  EXPECT_EQ(frame.actors[0].joints[kHip].position_m, (std::array<float, 3>{1, 2, 3}));
  ASSERT_TRUE(frame.actors[0].has[kRightToe]);
  EXPECT_EQ(frame.actors[0].joints[kRightToe].rotation, (std::array<float, 4>{0, 1, 0, 0}));
}

TEST(Rokoko, AnEarlierFrameLeavesNothingBehind) {
  Frame frame;
  ASSERT_EQ(Decoder().DecodeText(testing::kLayout3, frame), DecodeResult::kOk);
  ASSERT_EQ(Decoder().DecodeText(R"({"scene":{"timestamp":1,"actors":[{}]}})", frame),
            DecodeResult::kOk);
  EXPECT_EQ(frame.actor_count, 1);
  EXPECT_EQ(frame.fps, 0);
  EXPECT_TRUE(frame.actors[0].name().empty());
  EXPECT_TRUE(frame.actors[0].has.none());
  EXPECT_EQ(frame.actors[0].hip_height_m, 0);
  EXPECT_FALSE(frame.actors[0].has_face);
}

// An unknown expression, or one whose value is not a number, leaves the others as they are.
TEST(Rokoko, AFaceIsReadAsFarAsItIsOne) {
  const auto read = [](const std::string& face, Frame& frame) {
    return Decoder().DecodeText(
        testing::WithScene(R"("timestamp":1,"actors":[{"face":)" + face + "}]"), frame);
  };
  Frame frame;
  ASSERT_EQ(read(R"({"jawOpen":"wide","smile":3,"mouthSmileLeft":100,"tongueOut":null})", frame),
            DecodeResult::kOk);
  EXPECT_TRUE(frame.actors[0].has_face);
  EXPECT_EQ(frame.actors[0].face[*arkit::Find("mouthSmileLeft")], 1);
  EXPECT_EQ(frame.actors[0].face[*arkit::Find("jawOpen")], 0);
  for (const auto* const none : {"{}", "[1]", "\"no\"", R"({"faceId":"f"})"}) {
    ASSERT_EQ(read(none, frame), DecodeResult::kOk) << none;
    EXPECT_FALSE(frame.actors[0].has_face) << none;
  }
  EXPECT_EQ(read(R"({"jawOpen":1e300})", frame), DecodeResult::kBadValue);
}

TEST(Rokoko, TheNinthActorIsLeftOut) {
  std::string actors;
  for (int k = 0; k < 9; ++k)
    actors += (k > 0 ? "," : "") + ("{\"name\":\"" + std::to_string(k)) + "\"}";
  Frame frame;
  ASSERT_EQ(
      Decoder().DecodeText(testing::WithScene(R"("timestamp":1,"actors":[)" + actors + "]"), frame),
      DecodeResult::kOk);
  EXPECT_EQ(frame.actor_count, kMaxActors);
  EXPECT_EQ(frame.actors_left_out, 1);
  EXPECT_EQ(frame.actors[7].name(), "7");
}

TEST(Rokoko, ALongNameIsCutAtAWholeCharacter) {
  std::string name;
  while (name.size() < 70) name += "\xE2\x82\xAC";
  Frame frame;
  ASSERT_EQ(Decoder().DecodeText(
                testing::WithScene(R"("timestamp":1,"actors":[{"name":")" + name + "\"}]"), frame),
            DecodeResult::kOk);
  EXPECT_EQ(frame.actors[0].name(), name.substr(0, 63));
  Actor actor;
  actor.set_name(name);
  EXPECT_EQ(actor.name(), name.substr(0, 63));
}

TEST(Rokoko, PackedByTheLz4CommandIsReadAsItsText) {
  Decoder decoder;
  Frame frame;
  ASSERT_EQ(decoder.Decode(std::as_bytes(std::span(testing::kLz4Default)), frame),
            DecodeResult::kOk);
  EXPECT_EQ(frame.time_s, 2.5);
  ASSERT_EQ(frame.actor_count, 3);
  EXPECT_EQ(frame.actors[2].name(), "cleo");
}

TEST(Rokoko, PackedTextBeyondTheBoundIsRefused) {
  Lz4Packer packer;
  std::string text = R"({"scene":{"timestamp":1,"actors":[]}})";
  text.resize(kMaxTextSize, ' ');
  std::vector<std::byte> out(65507);
  const std::size_t size = packer.Pack(BytesOf(text), out);
  ASSERT_GT(size, 0U);
  Decoder decoder;
  Frame frame;
  EXPECT_EQ(decoder.Decode(std::span(out).first(size), frame), DecodeResult::kOk);
}

Frame AnyFrame(unsigned seed) {
  std::mt19937 random(seed);
  const auto number = [&random] {
    return static_cast<float>(static_cast<double>(random()) / 4294967296.0 * 4 - 2);
  };
  Frame frame;
  frame.fps = 30;
  frame.time_s = seed * 0.0166667;
  frame.actor_count = static_cast<int>(seed % (kMaxActors + 1));
  for (std::size_t k = 0; k < static_cast<std::size_t>(frame.actor_count); ++k) {
    Actor& actor = frame.actors[k];
    actor.set_name("actor \"" + std::to_string(k) + "\"\\\n\x01 \xC3\xBC");
    actor.hip_height_m = 1 + 0.01F * static_cast<float>(k);
    actor.total_height_m = 1.8F;
    for (std::size_t j = 0; j < kJoints; ++j) {
      actor.has.set(j, random() % 8 != 0);
      for (float& value : actor.joints[j].position_m) value = number();
      for (float& value : actor.joints[j].rotation) value = number();
    }
  }
  return frame;
}

// The other direction's witness: what we write, nlohmann reads.
TEST(Rokoko, WhatIsWrittenIsReadByTheOracleToTheSameValues) {
  std::string out(kMaxTextSize, '\0');
  for (unsigned seed = 0; seed < 20; ++seed) {
    const Frame frame = AnyFrame(seed);
    const std::size_t size = EncodeText(frame, out);
    ASSERT_GT(size, 0U);
    const Json json = Json::parse(out.substr(0, size));
    EXPECT_EQ(json["version"], "3,0");
    EXPECT_EQ(json["fps"], 30);
    EXPECT_EQ(json["scene"]["timestamp"].get<double>(), frame.time_s);
    ASSERT_EQ(json["scene"]["actors"].size(), static_cast<std::size_t>(frame.actor_count));
    for (std::size_t k = 0; k < static_cast<std::size_t>(frame.actor_count); ++k) {
      const Json& actor = json["scene"]["actors"][k];
      EXPECT_EQ(actor["name"], frame.actors[k].name());
      EXPECT_EQ(actor["dimensions"]["hipHeight"].get<float>(), frame.actors[k].hip_height_m);
      ASSERT_EQ(actor["body"].size(), frame.actors[k].has.count());
      for (std::size_t j = 0; j < kJoints; ++j) {
        if (!frame.actors[k].has[j]) continue;
        const Json& joint = actor["body"][std::string(kJointTable[j].name)];
        const auto& [p, r] = frame.actors[k].joints[j];
        EXPECT_EQ(joint["position"]["x"].get<float>(), p[0]);
        EXPECT_EQ(joint["position"]["y"].get<float>(), p[1]);
        EXPECT_EQ(joint["position"]["z"].get<float>(), p[2]);
        EXPECT_EQ(joint["rotation"]["x"].get<float>(), r[0]);
        EXPECT_EQ(joint["rotation"]["y"].get<float>(), r[1]);
        EXPECT_EQ(joint["rotation"]["z"].get<float>(), r[2]);
        EXPECT_EQ(joint["rotation"]["w"].get<float>(), r[3]);
      }
    }
  }
}

// And what nlohmann writes, in its own order, we read.
TEST(Rokoko, WhatTheOracleWritesIsReadToTheSameValues) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    const Frame frame = AnyFrame(seed);
    Json actors = Json::array();
    for (std::size_t k = 0; k < static_cast<std::size_t>(frame.actor_count); ++k) {
      const Actor& actor = frame.actors[k];
      Json body = Json::object();
      for (std::size_t j = 0; j < kJoints; ++j) {
        if (!actor.has[j]) continue;
        const auto& [p, r] = actor.joints[j];
        body[std::string(kJointTable[j].name)] = {
            {"position", {{"x", p[0]}, {"y", p[1]}, {"z", p[2]}}},
            {"rotation", {{"x", r[0]}, {"y", r[1]}, {"z", r[2]}, {"w", r[3]}}}};
      }
      actors.push_back({{"name", actor.name()},
                        {"dimensions", {{"hipHeight", actor.hip_height_m}}},
                        {"body", body}});
    }
    const Json json{{"version", 3.0}, {"scene", {{"timestamp", frame.time_s}, {"actors", actors}}}};
    Frame got;
    ASSERT_EQ(Decoder().DecodeText(json.dump(seed % 2 == 0 ? -1 : 2, ' ', seed % 3 == 0), got),
              DecodeResult::kOk);
    EXPECT_EQ(got.time_s, frame.time_s);
    ASSERT_EQ(got.actor_count, frame.actor_count);
    for (std::size_t k = 0; k < static_cast<std::size_t>(frame.actor_count); ++k) {
      EXPECT_EQ(got.actors[k].name(), frame.actors[k].name());
      ASSERT_EQ(got.actors[k].has, frame.actors[k].has);
      for (std::size_t j = 0; j < kJoints; ++j) {
        if (!got.actors[k].has[j]) continue;
        EXPECT_EQ(got.actors[k].joints[j].position_m, frame.actors[k].joints[j].position_m);
        EXPECT_EQ(got.actors[k].joints[j].rotation, frame.actors[k].joints[j].rotation);
      }
    }
  }
}

TEST(Rokoko, IsNotWrittenWhereItDoesNotFitOrIsNoNumber) {
  Frame frame = AnyFrame(3);
  std::string out(kMaxTextSize, '\0');
  const std::size_t size = EncodeText(frame, out);
  ASSERT_GT(size, 0U);
  EXPECT_EQ(EncodeText(frame, std::span(out).first(size)), size);
  for (const std::size_t less : {size - 1, size / 2, std::size_t{1}, std::size_t{0}}) {
    EXPECT_EQ(EncodeText(frame, std::span(out).first(less)), 0U);
  }
  frame.actors[1].has.set(3);
  frame.actors[1].joints[3].rotation[2] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(EncodeText(frame, out), 0U);
}

TEST(Rokoko, JointsStandInTheOrderOfTheirParentsAndEachIsFoundByItsName) {
  for (int j = 0; j < kJoints; ++j) {
    const JointRow& row = kJointTable[static_cast<std::size_t>(j)];
    EXPECT_LT(row.parent, j);
    for (const int hint : {-1, 0, j, kJoints}) EXPECT_EQ(FindJoint(row.name, hint), j);
    float length = 0;
    for (const float value : row.t_pose) length += value * value;
    EXPECT_NEAR(length, 1, 2e-3F) << row.name;
  }
  EXPECT_EQ(FindJoint("hips", 0), -1);
  EXPECT_EQ(kJointTable[kLeftHand].name, "leftHand");
  EXPECT_EQ(kJointTable[kRightShoulder].name, "rightShoulder");
  EXPECT_EQ(kJointTable[kRightHand].name, "rightHand");
  EXPECT_EQ(kJointTable[kLeftUpLeg].name, "leftUpLeg");
  EXPECT_EQ(kJointTable[kLeftToe].name, "leftToe");
  EXPECT_EQ(kJointTable[kRightUpLeg].name, "rightUpLeg");
  EXPECT_EQ(kJointTable[kRightToe].name, "rightToe");
}

}  // namespace
}  // namespace styled::rokoko
