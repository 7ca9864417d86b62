#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

#include "daemon/perform/performer/body_binding.h"
#include "daemon/source/rigs/rokoko.h"
#include "model/rig/dialect_rests.h"
#include "proto/rigs/rokoko/rokoko.h"
#include "sim/rigs/rokoko.h"
#include "tests/support/translation.h"
#include "tests/unit/body/random_pose.h"
#include "tests/unit/rokoko/texts.h"

namespace styled::source {
namespace {

using runtime::Counter;
using support::Said;
using support::Translated;
using Bytes = std::vector<std::byte>;

config::Source Config(std::string performer = "") {
  config::Source config;
  config.name = "studio";
  config.type = "rokoko";
  config.performer = std::move(performer);
  return config;
}

// The stand-in's datagram of a pose.
Bytes Sent(const std::vector<std::string>& names, double time_s,
           const std::vector<std::string>& quirks = {},
           const std::vector<body::Pose>& poses = std::vector<body::Pose>(8)) {
  rigs::Options options;
  options.performers = names;
  options.quirks = quirks;
  auto rig = rigs::MakeRokoko(options);
  Bytes bytes;
  rig.value()->Encode(
      {0, time_s, std::span(poses).first(names.size())},
      [&](std::span<const std::byte> datagram) { bytes.assign(datagram.begin(), datagram.end()); });
  return bytes;
}

// The same, changed before it is written again.
Bytes Changed(const Bytes& bytes, const std::function<void(rokoko::Frame&)>& change) {
  rokoko::Decoder decoder;
  static rokoko::Frame frame;
  EXPECT_EQ(decoder.Decode(bytes, frame), rokoko::DecodeResult::kOk);
  change(frame);
  std::string text(rokoko::kMaxTextSize, '\0');
  text.resize(rokoko::EncodeText(frame, text));
  const auto written = std::as_bytes(std::span(text));
  return {written.begin(), written.end()};
}

TEST(RokokoTranslator, TheScenesPropsComeWithEveryActorMirrored) {
  Translated translation(MakeRokoko(Config()));
  const Bytes bytes = Changed(Sent({"Anna", "Bert"}, 1), [](rokoko::Frame& frame) {
    frame.prop_count = 1;
    frame.props[0].set_name("sword");
    frame.props[0].pose = {{1, 2, 3}, {0.5F, 0.1F, -0.7F, 0.5F}};
  });
  int frames = 0;
  for (const auto& item : Said(translation, bytes)) {
    if (!item.is_frame) continue;
    ++frames;
    ASSERT_EQ(item.frame.props_size(), 1);
    const v1::Prop& prop = item.frame.props(0);
    EXPECT_EQ(prop.name(), "sword");
    EXPECT_EQ(prop.position(0), -1);
    EXPECT_EQ(prop.position(1), 2);
    EXPECT_EQ(prop.position(2), 3);
    EXPECT_EQ(prop.rotation(0), 0.5F);
    EXPECT_EQ(prop.rotation(1), -0.1F);
    EXPECT_EQ(prop.rotation(2), 0.7F);
    EXPECT_EQ(prop.rotation(3), 0.5F);
  }
  EXPECT_EQ(frames, 2);
  // A record without a pose is counted once, for any number of performers.
  std::string text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  text.replace(text.find("\"props\":[") + 9, 0, "{},");
  text[text.find("\"timestamp\":1") + 12] = '2';
  EXPECT_FALSE(Said(translation, std::as_bytes(std::span(text))).empty());
  EXPECT_EQ(translation.Count(Counter::kPipelinePropsLeftOut), 1U);
}

TEST(RokokoTranslator, RefusesWhatIsNotRokoko) {
  Translated translation(MakeRokoko(Config()));
  for (const auto& c : rokoko::testing::DecodeCases()) {
    if (c.expected == rokoko::DecodeResult::kOk) continue;
    const std::uint64_t before = translation.Count(Counter::kSourceMalformed);
    EXPECT_TRUE(Said(translation, std::as_bytes(std::span(c.text))).empty()) << c.name;
    EXPECT_EQ(translation.Count(Counter::kSourceMalformed), before + 1) << c.name;
  }
}

TEST(RokokoTranslator, EachActorIsAPerformerByAValidName) {
  Translated translation(MakeRokoko(Config("nobody")));
  const auto said = Said(
      translation,
      Sent({"Anna", "J\xC3\xBCrgen M.", "J//rgen M.", "J//rgen M.", "", std::string(40, 'x')}, 1));
  std::vector<std::string> names;
  for (const auto& item : said) {
    if (item.is_frame) names.push_back(item.frame.performer());
  }
  EXPECT_EQ(names, (std::vector<std::string>{"Anna", "J__rgen_M_", "J__rgen_M_-2", "J__rgen_M_-3",
                                             "nobody", std::string(32, 'x')}));
}

TEST(RokokoTranslator, AnActorKeepsHisNameWhateverHisPlaceInTheFrame) {
  Translated translation(MakeRokoko(Config()));
  (void)Said(translation, Sent({"anna", "ben"}, 1));
  const auto said = Said(translation, Sent({"ben", "anna"}, 1.1));
  ASSERT_EQ(said.size(), 2U);
  EXPECT_EQ(said[0].frame.performer(), "ben");
  EXPECT_EQ(said[1].frame.performer(), "anna");
}

TEST(RokokoTranslator, TheBodyIsRightHandedUnderTheDialectRokoko) {
  Translated translation(MakeRokoko(Config()));
  const auto said = Said(translation, Sent({"anna"}, 1.5));
  ASSERT_EQ(said.size(), 2U);
  const v1::Body& body = said[0].body;
  EXPECT_EQ(body.names_size(), 23);
  EXPECT_EQ(body.dialect(), "rokoko");
  EXPECT_EQ(body.metres_per_unit(), 1);
  EXPECT_EQ(body.names(8), "leftHand");
  EXPECT_EQ(body.parents(8), 7);
  const auto bound = pipeline::BindBody(body, {});
  ASSERT_TRUE(bound.ok()) << bound.status().message();
  EXPECT_EQ(bound.value().dialect, "rokoko");
  EXPECT_NEAR(std::hypot(body.offsets(24), body.offsets(25), body.offsets(26)), 0.25, 1e-5);
  EXPECT_EQ(said[1].frame.source_time_ns(), 1'500'000'000U);
}

// Studio's reference rotations stand in two tables: the wire's, and the dialect's, which another
// author mirrored by hand.
TEST(RokokoTranslator, TheWiresReferenceRotationsAreTheDialectsMirrored) {
  for (int c = 0; c < body::kJointCount; ++c) {
    const int toe_end = c > body::kLeftToes ? 1 : 0;
    const auto& t = rokoko::kJointTable[static_cast<std::size_t>(c + toe_end)].t_pose;
    const auto& row = rig::kRokokoRest[static_cast<std::size_t>(c)];
    const double dot = t[0] * row.x - t[1] * row.y - t[2] * row.z + t[3] * row.w;
    EXPECT_NEAR(std::abs(dot), 1, 1e-4) << body::kHumanoid[static_cast<std::size_t>(c)].name;
  }
}

TEST(RokokoTranslator, GivesThePosesOfTheStandInWhateverTheQuirk) {
  for (const auto& quirks :
       std::vector<std::vector<std::string>>{{}, {"lz4"}, {"gloves"}, {"lz4", "gloves"}}) {
    Translated translation(MakeRokoko(Config()));
    std::array<v1::Body, 2> bodies;
    for (unsigned index = 0; index < 40; ++index) {
      const std::vector<body::Pose> poses{body::Random(index).AnyPose(),
                                          body::Random(index + 1000).AnyPose()};
      const auto said = Said(translation, Sent({"a", "b"}, 0.02 * index, quirks, poses));
      std::size_t frames = 0;
      for (const auto& item : said) {
        if (!item.is_frame) {
          bodies[item.body.performer() == "a" ? 0 : 1] = item.body;
          continue;
        }
        const std::size_t k = item.frame.performer() == "a" ? 0 : 1;
        ++frames;
        const auto got = support::CanonicalPose(bodies[k], item.frame);
        ASSERT_TRUE(got);
        EXPECT_LT(support::Between(*got, poses[k]).joint_deg, 0.1F) << index;
        EXPECT_LT(support::Between(*got, poses[k]).hips_m, 1e-3F) << index;
      }
      EXPECT_EQ(frames, 2U);
    }
    const bool gloves = quirks.size() == 2 || (quirks.size() == 1 && quirks[0] == "gloves");
    EXPECT_EQ(bodies[0].names_size(), gloves ? 63 : 23);
  }
}

// Fingers included: the plug-ins' T-pose has the thumbs turned away from the hand.
TEST(RokokoTranslator, TheTPoseIsThatOfThePlugIns) {
  Translated translation(MakeRokoko(Config()));
  const auto said = Said(translation, Sent({"anna"}, 1, {"gloves"}));
  const v1::Body& body = said.front().body;
  ASSERT_EQ(body.names_size(), rokoko::kJoints);
  const auto skeleton = pipeline::ReadSkeleton(body);
  ASSERT_TRUE(skeleton.ok());
  const auto bound = rig::BindDialect(skeleton.value(), body.dialect());
  ASSERT_TRUE(bound.ok()) << bound.status().message();
  for (std::size_t j = 0; j < rokoko::kJoints; ++j) {
    const auto& t = rokoko::kJointTable[j].t_pose;
    const rig::Quat expected = rig::Mirrored(rig::Quat(t[3], t[0], t[1], t[2])).normalized();
    EXPECT_LT(expected.angularDistance(bound.value().spec().rest_rotations[j]), 2e-3F)
        << rokoko::kJointTable[j].name;
  }
}

TEST(RokokoTranslator, GlovesPutOnAreAnotherBodyOfTheSameSession) {
  Translated translation(MakeRokoko(Config()));
  const auto bare = Said(translation, Sent({"anna"}, 1));
  const auto gloved = Said(translation, Sent({"anna"}, 1.1, {"gloves"}));
  ASSERT_EQ(gloved.size(), 2U);
  EXPECT_EQ(gloved[0].body.names_size(), 63);
  EXPECT_EQ(gloved[1].session, bare[1].session);
  // Taken off they are untracked fingers.
  const auto off = Said(translation, Sent({"anna"}, 1.2));
  ASSERT_EQ(off.size(), 1U);
  EXPECT_EQ(off[0].frame.rotations_size(), 4 * 63);
  EXPECT_TRUE(std::isnan(off[0].frame.rotations(4 * 62)));
  EXPECT_FALSE(std::isnan(off[0].frame.rotations(4 * 22)));
}

TEST(RokokoTranslator, AnotherHipHeightIsAnotherBody) {
  Translated translation(MakeRokoko(Config()));
  (void)Said(translation, Sent({"anna"}, 1));
  const Bytes taller = Changed(Sent({"anna"}, 1.1), [](rokoko::Frame& frame) {
    frame.actors[0].hip_height_m = 1.2F;
    for (auto& joint : frame.actors[0].joints) joint.position_m[1] *= 1.2F;
  });
  const auto said = Said(translation, taller);
  ASSERT_EQ(said.size(), 2U);
  EXPECT_FALSE(said[0].is_frame);
}

TEST(RokokoTranslator, AJointThatIsMissingOrHasNoRotationIsNotTracked) {
  Translated translation(MakeRokoko(Config()));
  (void)Said(translation, Sent({"anna"}, 1));
  const Bytes broken = Changed(Sent({"anna"}, 1.1), [](rokoko::Frame& frame) {
    frame.actors[0].has.reset(7);                       // the left lower arm
    frame.actors[0].joints[4].rotation = {0, 0, 0, 0};  // the head
  });
  const auto said = Said(translation, broken);
  ASSERT_EQ(said.size(), 1U);
  for (const int joint : {4, 7, 8}) {  // the hand is relative to the lower arm
    EXPECT_TRUE(std::isnan(said[0].frame.rotations(4 * joint + 3))) << joint;
  }
  EXPECT_FALSE(std::isnan(said[0].frame.rotations(4 * 6 + 3)));
}

TEST(RokokoTranslator, WithoutAHipThereIsNobody) {
  Translated translation(MakeRokoko(Config()));
  const Bytes headless = Changed(
      Sent({"anna"}, 1), [](rokoko::Frame& frame) { frame.actors[0].has.reset(rokoko::kHip); });
  EXPECT_TRUE(Said(translation, headless).empty());
  EXPECT_EQ(translation.Count(Counter::kSourceIncomplete), 1U);
}

TEST(RokokoTranslator, FramesThatComeTwiceOrLateAreCountedAndNotPassedOn) {
  Translated translation(MakeRokoko(Config()));
  (void)Said(translation, Sent({"anna"}, 10));
  EXPECT_TRUE(Said(translation, Sent({"anna"}, 10)).empty());
  EXPECT_TRUE(Said(translation, Sent({"anna"}, 9.98)).empty());
  EXPECT_EQ(translation.Count(Counter::kPipelineDuplicate), 1U);
  EXPECT_EQ(translation.Count(Counter::kPipelineReordered), 1U);
  EXPECT_EQ(Said(translation, Sent({"anna"}, 10.02)).size(), 1U);
}

TEST(RokokoTranslator, TimeThatJumpsBackIsANewSession) {
  Translated translation(MakeRokoko(Config()));
  const auto before = Said(translation, Sent({"anna"}, 10));
  const auto after = Said(translation, Sent({"anna"}, 2));
  ASSERT_EQ(after.size(), 2U);  // the body again
  EXPECT_NE(after[1].session, before[1].session);
  EXPECT_EQ(after[1].frame.body_crc(), before[1].frame.body_crc());
  EXPECT_EQ(Said(translation, Sent({"anna"}, 2.02)).back().session, after[1].session);
}

TEST(RokokoTranslator, AShortLoopIsANewSessionWhenItsFramesKeepComing) {
  Translated translation(MakeRokoko(Config()));
  const auto before = Said(translation, Sent({"anna"}, 10));
  for (const double time_s : {9.5, 9.52, 9.54, 9.56}) {
    EXPECT_TRUE(Said(translation, Sent({"anna"}, time_s)).empty());
  }
  const auto after = Said(translation, Sent({"anna"}, 9.58));
  ASSERT_EQ(after.size(), 2U);
  EXPECT_NE(after[1].session, before[1].session);
}

TEST(RokokoTranslator, TwoStudiosAreTwoSessions) {
  Translated translation(MakeRokoko(Config()));
  const auto one = Said(translation, Sent({"anna"}, 1), 1);
  const auto other = Said(translation, Sent({"anna"}, 1), 2);
  EXPECT_NE(one[1].session, other[1].session);
  EXPECT_EQ(other[1].frame.performer(), "anna");
}

TEST(RokokoTranslator, ActorsBeyondTheBoundAreRefusedAndCounted) {
  Translated translation(MakeRokoko(Config()));
  std::string nine;
  for (int k = 0; k < 9; ++k) nine += k > 0 ? ",{}" : "{}";
  const std::string text = rokoko::testing::WithScene(R"("timestamp":1,"actors":[)" + nine + "]");
  EXPECT_TRUE(Said(translation, std::as_bytes(std::span(text))).empty());
  EXPECT_EQ(translation.Count(Counter::kPipelinePerformersRefused), 1U);
  for (std::uint64_t peer = 1; peer <= 70; ++peer) {
    (void)Said(translation, Sent({"anna"}, 2), peer);
  }
  EXPECT_GT(translation.Count(Counter::kPipelinePerformersRefused), 5U);
  translation.now_ns += 11'000'000'000;
  EXPECT_FALSE(Said(translation, Sent({"anna"}, 3), 100).empty());
}

TEST(RokokoTranslator, FromTheSecondFrameOnNothingIsAllocated) {
  Translated translation(MakeRokoko(Config()));
  const auto allocations = [&](const Bytes& bytes) {
    translation.now_ns += 16'666'667;
    return support::Allocations(translation.translator(), bytes, translation.now_ns);
  };
  EXPECT_GT(allocations(Sent({"anna", "ben"}, 0, {"gloves"})), 0);  // the count counts
  for (int index = 1; index < 50; ++index) {
    const double time_s = index == 40 ? 0.001 : 0.02 * index;  // a restart, too
    const Bytes plain = Sent({"anna", "ben"}, time_s, {"gloves"});
    const Bytes packed = Sent({"anna", "ben"}, time_s + 0.01, {"lz4", "gloves"});
    EXPECT_EQ(allocations(plain), 0) << index;
    EXPECT_EQ(allocations(packed), 0) << index;
  }
}

TEST(RokokoTranslator, AnActorsFaceGoesWithThePose) {
  Translated plain(MakeRokoko(Config()));
  EXPECT_EQ(Said(plain, Sent({"anna"}, 0.2)).back().frame.expressions_size(), 0);
  const Bytes bytes = Sent({"anna"}, 0.1, {"face"});  // in the middle of a blink
  Translated arkit(MakeRokoko(Config()));
  const auto said = Said(arkit, bytes).back().frame;
  ASSERT_EQ(said.expressions_size(), 52);
  EXPECT_EQ(said.expressions(0).name(), "eyeBlinkLeft");
  EXPECT_NEAR(said.expressions(0).value(), 1, 0.01);
  config::Source vrm = Config();
  vrm.expressions = "vrm";
  Translated presets(MakeRokoko(vrm));
  EXPECT_EQ(Said(presets, bytes).back().frame.expressions(0).name(), "Blink_L");
}

}  // namespace
}  // namespace styled::source

namespace styled::rigs {
namespace {

TEST(RokokoStandIn, RefusesWhatTheRigOrADatagramDoesNotHold) {
  Options options;
  options.quirks = {"tmcd"};
  EXPECT_FALSE(MakeRokoko(options).ok());
  options.quirks = {};
  options.performers = std::vector<std::string>(9, "a");
  EXPECT_FALSE(MakeRokoko(options).ok());
  options.quirks = {"gloves"};
  options.performers = std::vector<std::string>(6, "a");
  EXPECT_FALSE(MakeRokoko(options).ok());
}

TEST(RokokoStandIn, SendsOneDatagramForAllThatFitsWhateverTheyDo) {
  for (const auto& [quirks, performers] :
       std::vector<std::pair<std::vector<std::string>, std::size_t>>{
           {{}, 8}, {{"gloves"}, 5}, {{"lz4"}, 8}, {{"lz4", "gloves"}, 8}}) {
    Options options;
    options.performers = std::vector<std::string>(performers, std::string(32, 'x'));
    options.quirks = quirks;
    auto rig = MakeRokoko(options);
    ASSERT_TRUE(rig.ok());
    for (unsigned seed = 0; seed < 10; ++seed) {
      std::vector<body::Pose> poses;
      for (unsigned k = 0; k < performers; ++k) {
        poses.push_back(body::Random(100 * seed + k).AnyPose());
      }
      int sent = 0;
      rig.value()->Encode(
          {seed, 0.02 * seed + 0.123456789, poses}, [&](std::span<const std::byte> datagram) {
            ++sent;
            EXPECT_LE(datagram.size(), 65507U);
            EXPECT_EQ(rokoko::IsLz4Frame(datagram), quirks.size() > 0 && quirks[0] == "lz4");
          });
      EXPECT_EQ(sent, 1) << performers;
    }
  }
}

// In the T-pose the wire has the reference rotations, and the body's left at -X.
TEST(RokokoStandIn, StandsInStudiosTPose) {
  auto rig = MakeRokoko({});
  const body::Pose pose;
  rokoko::Frame frame;
  rokoko::Decoder decoder;
  rig.value()->Encode({0, 0, {&pose, 1}}, [&](std::span<const std::byte> datagram) {
    ASSERT_EQ(decoder.Decode(datagram, frame), rokoko::DecodeResult::kOk);
  });
  ASSERT_EQ(frame.actor_count, 1);
  EXPECT_LT(frame.actors[0].joints[rokoko::kLeftHand].position_m[0], -0.5F);
  for (std::size_t j = 0; j < rokoko::kBodyJoints; ++j) {
    ASSERT_TRUE(frame.actors[0].has[j]);
    const auto& expected = rokoko::kJointTable[j].t_pose;
    for (std::size_t i = 0; i < 4; ++i) {
      EXPECT_NEAR(frame.actors[0].joints[j].rotation[i], expected[i], 1e-6F);
    }
  }
}

}  // namespace
}  // namespace styled::rigs
