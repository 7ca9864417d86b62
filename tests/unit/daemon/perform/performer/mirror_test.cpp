// A performer who is mirrored: everything that leaves is the mirror image of the data that arrives.
#include "model/rig/mirror.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "model/net/weights_file.h"
#include "model/rig/hands.h"
#include "tests/support/fake_pipeline.h"
#include "tests/unit/net/erd/random_weights.h"

namespace styled::pipeline {
namespace {

using rig::Quat;
using rig::Vec3;
using support::FakePipeline;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
// The topics of a subscriber to "", in the order of publishing.
constexpr std::size_t kRigTopic = 0, kCanonicalTopic = 1, kSourceTopic = 2, kTopics = 3;

std::shared_ptr<RuntimeConfig> MakeConfig() {
  auto config = std::make_shared<RuntimeConfig>();
  config->network = erd::RandomStylizer(5, 1);
  config->stylist.limb_gate = false;  // of random weights little is shown
  return config;
}

// The rig of tests/support/rig.h with fingers, eyes and a jaw.
v1::Body BodyWithTail(const support::Rig& rig) {
  v1::Body body = rig.MakeBody();
  std::array<int, rig::kTailCount> joints{};
  for (int t = 0; t < rig::kTailCount; ++t) {
    const auto at = static_cast<std::size_t>(t);
    const int before = rig::TailBefore(t);
    const float side = t == rig::kTailLeftEye ? 1.0F : t == rig::kTailRightEye ? -1.0F : 0.0F;
    const Vec3 offset_m =
        t < rig::kTailLeftEye ? rig::FingerOffset_m(t) : Vec3(0.03F * side, 0.05F, 0.08F);
    joints[at] = body.names_size();
    body.add_names(std::string(rig::kTailNames[at]));
    body.add_parents(before >= 0 ? joints[static_cast<std::size_t>(before)] : rig::TailAnchor(t));
    for (const float value : offset_m) body.add_offsets(value);
  }
  return body;
}

// A frame in which no side is as the other: everything turns, and the performer is beside the
// middle of the stage.
v1::SourceFrame FrameOf(const support::Rig& rig) {
  v1::SourceFrame frame = rig.MakeFrame();
  frame.set_root_position(0, frame.root_position(0) + 2.5F);
  const auto t = static_cast<float>(static_cast<double>(rig.time_ns) * 1e-9);
  const auto set = [&frame](int joint, const Quat& q) {
    for (int i = 0; i < 4; ++i) frame.set_rotations(4 * joint + i, q.coeffs()[i]);
  };
  set(body::kHead, body::Exp({0.1F, 0.2F + 0.1F * std::sin(t), -0.15F}));
  set(body::kLeftLowerArm, body::Exp({0.3F, -0.8F, 0.1F * std::cos(3 * t)}));
  set(body::kRightFoot, body::Exp({0.1F, 0.05F, 0.02F}));
  for (int t_joint = 0; t_joint < rig::kTailCount; ++t_joint) {
    const auto n = static_cast<float>(t_joint);
    const Quat turn = body::Exp({0.1F * std::sin(n + t), 0.02F * n, 0.2F * std::cos(2 * n)});
    for (int i = 0; i < 4; ++i) frame.add_rotations(turn.coeffs()[i]);
  }
  const auto express = [&frame](const char* name, float value) {
    v1::Expression& expression = *frame.add_expressions();
    expression.set_name(name);
    expression.set_value(value);
  };
  express("eyeBlinkLeft", 0.75F);
  express("jawRight", 0.5F);
  express("Blink_R", 0.25F);
  express("jawOpen", 0.125F);
  frame.add_thru("/VMC/Thru/Left");
  v1::Prop& sword = *frame.add_props();
  sword.set_name("sword");
  for (const float value : {1.8F, 0.7F + 0.1F * std::sin(t), 0.3F}) sword.add_position(value);
  for (const float value : {0.0F, 0.6F, 0.0F, 0.8F}) sword.add_rotation(value);
  return frame;
}

int MirrorTail(int t) {
  if (t == rig::kTailJaw) return t;
  if (t >= rig::kTailLeftEye) return rig::kTailLeftEye + rig::kTailRightEye - t;
  return t < rig::kTailRightThumb ? t + rig::kHandTail : t - rig::kHandTail;
}
int MirrorOfJoint(int joint) {
  return joint < body::kJointCount ? body::MirrorJoint(joint)
                                   : body::kJointCount + MirrorTail(joint - body::kJointCount);
}

std::string OtherSide(const std::string& name) {
  static const std::vector<std::pair<std::string, std::string>> kNames{
      {"eyeBlinkLeft", "eyeBlinkRight"}, {"jawRight", "jawLeft"}, {"Blink_R", "Blink_L"}};
  for (const auto& [one, two] : kNames) {
    if (name == one) return two;
    if (name == two) return one;
  }
  return name;
}

// The mirror image of a frame of this rig, or of one that left.
template <typename Frame>
Frame MirrorImage(const Frame& frame) {
  Frame mirrored = frame;
  mirrored.set_root_position(0, -frame.root_position(0));
  for (int joint = 0; joint < frame.rotations_size() / 4; ++joint) {
    for (int i = 0; i < 4; ++i) {
      const float sign = i == 1 || i == 2 ? -1.0F : 1.0F;
      mirrored.set_rotations(4 * joint + i, sign * frame.rotations(4 * MirrorOfJoint(joint) + i));
    }
  }
  for (v1::Expression& expression : *mirrored.mutable_expressions()) {
    expression.set_name(OtherSide(expression.name()));
  }
  for (v1::Prop& prop : *mirrored.mutable_props()) {
    prop.set_position(0, -prop.position(0));
    prop.set_rotation(1, -prop.rotation(1));
    prop.set_rotation(2, -prop.rotation(2));
  }
  return mirrored;
}

// The poses, faces and props are the same within `tolerance`. 0: the same numbers.
void ExpectTheSame(const v1::Frame& a, const v1::Frame& b, float tolerance) {
  ASSERT_EQ(a.rotations_size(), b.rotations_size());
  const auto near = [tolerance](float x, float y, const std::string& what) {
    EXPECT_LE(std::abs(x - y), tolerance) << what << ": " << x << ", expected " << y;
  };
  for (int i = 0; i < 3; ++i) near(a.root_position(i), b.root_position(i), "position");
  for (int i = 0; i < a.rotations_size(); ++i) {
    near(a.rotations(i), b.rotations(i), "joint " + std::to_string(i / 4));
  }
  ASSERT_EQ(a.expressions_size(), b.expressions_size());
  for (int i = 0; i < a.expressions_size(); ++i) {
    EXPECT_EQ(a.expressions(i).name(), b.expressions(i).name());
    EXPECT_EQ(a.expressions(i).value(), b.expressions(i).value());
  }
  ASSERT_EQ(a.thru_size(), b.thru_size());
  for (int i = 0; i < a.thru_size(); ++i) EXPECT_EQ(a.thru(i), b.thru(i));
  ASSERT_EQ(a.props_size(), b.props_size());
  for (int i = 0; i < a.props_size(); ++i) {
    for (int k = 0; k < 3; ++k) near(a.props(i).position(k), b.props(i).position(k), "prop");
    for (int k = 0; k < 4; ++k) near(a.props(i).rotation(k), b.props(i).rotation(k), "prop turns");
  }
}

// A daemon and the rig whose frames it gets.
struct Staged {
  explicit Staged(const std::shared_ptr<RuntimeConfig>& config) : fake(config, "") {
    fake.Deliver({rig.Datagram(native::Kind::kBody, BodyWithTail(rig).SerializeAsString())});
  }
  void Set(const std::function<void(v1::Look&)>& change) {
    v1::Request request;
    request.set_performer("rig.a");
    change(*request.mutable_set());
    const v1::Reply reply = fake.Ask(request);
    ASSERT_EQ(reply.code(), v1::CODE_OK) << reply.reason();
  }
  void Mirror(bool mirror) {
    Set([mirror](v1::Look& look) { look.set_mirror(mirror); });
  }
  void Wear(const std::string& style) {
    Set([&style](v1::Look& look) {
      v1::StyleWeight& mix = *look.add_mix();
      mix.set_style(style);
      mix.set_weight(1);
    });
  }
  // Sends the next frame; returns what leaves, by topic.
  std::vector<v1::Frame> Send(const std::function<void(v1::SourceFrame&)>& change = {}) {
    fake.publisher.frames.clear();
    v1::SourceFrame frame = FrameOf(rig);
    rig.time_ns += rig.period_ns;
    if (change) change(frame);
    fake.clock.now_ns += static_cast<std::int64_t>(rig.period_ns);
    fake.Deliver({rig.Datagram(native::Kind::kSourceFrame, frame.SerializeAsString())});
    EXPECT_EQ(fake.publisher.frames.size(), kTopics);
    return fake.publisher.frames;
  }
  support::Rig rig{"a"};
  FakePipeline fake;
};

TEST(Mirror, WithoutAStyleEverythingThatLeavesIsTheMirrorImage) {
  Staged plain(MakeConfig()), mirrored(MakeConfig());
  mirrored.Mirror(true);
  for (int i = 0; i < 30; ++i) {
    const auto as_captured = plain.Send(), frames = mirrored.Send();
    ASSERT_EQ(frames.size(), as_captured.size());
    for (std::size_t topic = 0; topic < frames.size(); ++topic) {
      SCOPED_TRACE(topic);
      EXPECT_TRUE(frames[topic].flags() & v1::FLAG_BYPASS);
      ExpectTheSame(frames[topic], MirrorImage(as_captured[topic]), 1e-6F);
      ASSERT_EQ(frames[topic].props_size(), 1);
      EXPECT_EQ(frames[topic].expressions(0).name(), "eyeBlinkRight");
      EXPECT_EQ(frames[topic].thru(0), "/VMC/Thru/Left") << "passed on";
    }
    // A prop on the rig is its exact reflection.
    for (const std::size_t topic : {kRigTopic, kSourceTopic}) {
      const v1::Prop& prop = frames[topic].props(0);
      EXPECT_EQ(prop.position(0), -as_captured[topic].props(0).position(0));
      EXPECT_EQ(prop.rotation(1), -as_captured[topic].props(0).rotation(1));
    }
  }
}

// A styled performer who is mirrored leaves as the one whose rig sends the mirror image: filters,
// hands that hold a prop and joints that are not tracked included.
TEST(Mirror, AStyleSeesThePerformerAsIfTheRigWereMirrored) {
  auto config = MakeConfig(), as_if = MakeConfig();
  config->props = {{{"sword", rig::Hand::kRight}}};
  as_if->props = {{{"sword", rig::Hand::kLeft}}};
  for (const bool smooth : {false, true}) {
    SCOPED_TRACE(smooth);
    if (smooth) config->smoothing = as_if->smoothing = {{.rest_hz = 3}};
    Staged mirrored(config), other(as_if);
    mirrored.Mirror(true);
    for (Staged* const staged : {&mirrored, &other}) staged->Wear("style1");
    double turned = 0;
    for (int i = 0; i < 120; ++i) {
      const auto lose = [i](v1::SourceFrame& frame) {
        if (i > 60) frame.set_rotations(4 * body::kLeftHand, kNan);
      };
      const auto frames = mirrored.Send(lose);
      const auto expected = other.Send([&](v1::SourceFrame& frame) {
        lose(frame);
        frame = MirrorImage(frame);
      });
      ASSERT_EQ(frames.size(), expected.size());
      for (std::size_t topic = 0; topic < frames.size(); ++topic) {
        SCOPED_TRACE(topic);
        ExpectTheSame(frames[topic], expected[topic], 1e-4F);
        EXPECT_EQ(frames[topic].flags(), expected[topic].flags());
        EXPECT_EQ(frames[topic].contacts(), expected[topic].contacts());
      }
      if (i > 60) {
        ASSERT_EQ(frames[kRigTopic].held_joints_size(), 1);
        EXPECT_EQ(frames[kRigTopic].held_joints(0), static_cast<unsigned>(body::kRightHand));
      }
      const auto& rig = frames[kRigTopic];
      const auto& source = frames[kSourceTopic];
      for (int k = 0; k < rig.rotations_size(); ++k) {
        turned += static_cast<double>(std::abs(rig.rotations(k) - source.rotations(k)));
      }
    }
    EXPECT_GT(turned, 1) << "the style is seen";
  }
}

TEST(Mirror, OffIsBitForBitAsIfItHadNeverBeenOn) {
  Staged plain(MakeConfig()), other(MakeConfig());
  other.Mirror(true);
  other.Mirror(false);
  for (Staged* const staged : {&plain, &other}) staged->Wear("style1");
  for (int i = 0; i < 60; ++i) {
    const auto expected = plain.Send(), frames = other.Send();
    ASSERT_EQ(frames.size(), expected.size());
    for (std::size_t topic = 0; topic < frames.size(); ++topic) {
      EXPECT_EQ(frames[topic].SerializeAsString(), expected[topic].SerializeAsString()) << topic;
    }
  }
}

// The performer is five metres elsewhere at once; that is a cut, and not a jump that is held. Feet
// that are held start again, so that they are left out here.
TEST(Mirror, SwitchingItIsACutInWhichNoFrameIsHeldAndNoStyleIsLost) {
  auto config = MakeConfig();
  config->stylist.feet = false;
  Staged staged(config);
  staged.Wear("style1");
  v1::Frame last;
  for (int i = 0; i < 120; ++i) last = staged.Send()[kCanonicalTopic];
  const std::uint64_t time_ns = staged.rig.time_ns;
  for (const bool mirror : {true, false}) {
    staged.Mirror(mirror);
    // The same pose again, a frame later.
    staged.rig.time_ns = time_ns - staged.rig.period_ns;
    const auto frames = staged.Send([&](v1::SourceFrame& frame) {
      frame.set_source_time_ns(time_ns + (mirror ? 0 : 1) * staged.rig.period_ns);
    });
    const v1::Frame& now = frames[kCanonicalTopic];
    EXPECT_TRUE(now.flags() & v1::FLAG_NEW_SESSION) << mirror;
    EXPECT_FALSE(now.flags() & (v1::FLAG_HELD | v1::FLAG_BYPASS | v1::FLAG_CONCEALED)) << mirror;
    const v1::Frame expected = MirrorImage(last);
    EXPECT_NEAR(now.root_position(0), expected.root_position(0), 0.05F) << mirror;
    for (int k = 0; k < now.rotations_size(); ++k) {
      EXPECT_NEAR(now.rotations(k), expected.rotations(k), 0.05F) << mirror << " " << k / 4;
    }
    last = now;
  }
}

// A body in left-handed axes, whose rest pose is known by a calibration.
TEST(Mirror, ARigInLeftHandedAxesIsBoundAndMirroredLikeAnother) {
  const auto left_handed = [](v1::SourceFrame& frame) {
    frame.set_root_position(0, -frame.root_position(0));
    for (int k = 0; k < frame.rotations_size(); k += 4) {
      frame.set_rotations(k + 1, -frame.rotations(k + 1));
      frame.set_rotations(k + 2, -frame.rotations(k + 2));
    }
    frame.clear_props();
  };
  support::Rig right("a"), left("a");
  v1::Body body = left.MakeBody();
  for (int i = 0; i < body.offsets_size(); i += 3) body.set_offsets(i, -body.offsets(i));
  FakePipeline here(MakeConfig(), ""), there(MakeConfig(), "");
  here.Deliver({right.Body()});
  there.Deliver({left.Datagram(native::Kind::kBody, body.SerializeAsString())});
  const auto send = [&](bool still) {
    here.publisher.frames.clear();
    there.publisher.frames.clear();
    const auto stand = [still](v1::SourceFrame& frame) {
      for (int k = 0; still && k < frame.rotations_size(); ++k) {
        frame.set_rotations(k, k % 4 == 3 ? 1.0F : 0.0F);
      }
      if (still) frame.set_root_position(0, 0.5F);
      if (still) frame.set_root_position(1, 0.97F);
    };
    here.clock.now_ns += 8'333'333;
    there.clock.now_ns += 8'333'333;
    here.Deliver({right.Frame(stand)});
    there.Deliver({left.Frame([&](v1::SourceFrame& frame) {
      stand(frame);
      left_handed(frame);
    })});
  };
  for (int i = 0; i < 100; ++i) send(true);
  EXPECT_TRUE(there.publisher.frames.empty()) << "it waits for a calibration";
  v1::Request calibrate;
  calibrate.set_performer("rig.a");
  calibrate.mutable_calibrate()->set_pose(v1::Calibrate::POSE_T);
  const v1::Reply reply = there.Ask(calibrate);
  ASSERT_EQ(reply.code(), v1::CODE_OK) << reply.reason();
  ASSERT_TRUE(reply.calibrate().left_handed());
  for (const bool mirror : {false, true}) {
    SCOPED_TRACE(mirror);
    v1::Request set;
    set.set_performer("rig.a");
    set.mutable_set()->set_mirror(mirror);
    for (FakePipeline* const fake : {&here, &there}) {
      ASSERT_EQ(fake->Ask(set).code(), v1::CODE_OK);
    }
    std::uint32_t contacts = 0;
    for (int i = 0; i < 120; ++i) {
      send(i < 60);
      ASSERT_EQ(here.publisher.frames.size(), kTopics);
      ASSERT_EQ(there.publisher.frames.size(), kTopics);
      const v1::Frame& expected = here.publisher.frames[kCanonicalTopic];
      const v1::Frame& got = there.publisher.frames[kCanonicalTopic];
      if (i >= 30) EXPECT_EQ(got.contacts(), expected.contacts()) << i;
      contacts |= got.contacts();
      for (int k = 0; k < 3; ++k) {
        EXPECT_NEAR(got.root_position(k), expected.root_position(k), 2e-3F);
      }
      for (int k = 0; k < expected.rotations_size(); ++k) {
        EXPECT_NEAR(got.rotations(k), expected.rotations(k), 2e-3F) << i << " " << k / 4;
      }
      // And in its own axes.
      EXPECT_NEAR(there.publisher.frames[kRigTopic].root_position(0),
                  -here.publisher.frames[kRigTopic].root_position(0), 2e-3F);
    }
    EXPECT_EQ(contacts, 3U) << "both feet are planted while the performer stands";
  }
}

// The neutral belongs to the performer, not to their mirror image: it is kept as captured.
TEST(Mirror, TheNeutralIsKeptAsThatOfThePerformer) {
  auto config = std::make_shared<RuntimeConfig>();
  erd::WeightsFile weights = erd::RandomWeights(3, 1);
  neutral::Reference reference;
  reference.walking.rotations[body::kSpine] = body::Exp(body::Vec3(0.2F, 0, 0));
  reference.standing = reference.running = reference.walking;
  weights.metadata["version"] = net::kWeightsVersion;
  weights.metadata["reference"] = net::AsJson(reference);
  config->network = erd::StylizerOf(weights);
  const auto learn = [&config](const std::vector<bool>& mirror) {
    support::Rig rig("a", 9);
    FakePipeline fake(config, "styled/rig.a/rig/");
    fake.Deliver({rig.Body()});
    const auto perform = [&](double seconds) {
      for (int i = 0; i < static_cast<int>(seconds * 120); ++i) {
        fake.clock.now_ns += 8'333'333;
        fake.Deliver({rig.Frame([](v1::SourceFrame& frame) {
          const Quat head = body::Exp({0, 0, 0.15F}), collar = body::Exp({0, 0.1F, 0});
          for (int k = 0; k < 4; ++k) {
            frame.set_rotations(4 * body::kHead + k, head.coeffs()[k]);
            frame.set_rotations(4 * body::kLeftShoulder + k, collar.coeffs()[k]);
          }
        })});
      }
    };
    v1::Request calibrate;
    calibrate.set_performer("rig.a");
    calibrate.mutable_calibrate()->set_neutral(true);
    calibrate.mutable_calibrate()->set_seconds(2);
    std::vector<Profile> newest;
    bool asked = false;
    perform(0.5);
    for (const bool on : mirror) {
      v1::Request set;
      set.set_performer("rig.a");
      set.mutable_set()->set_mirror(on);
      EXPECT_EQ(fake.Ask(set).code(), v1::CODE_OK);
      perform(0.1);
      if (!std::exchange(asked, true)) EXPECT_EQ(fake.Ask(calibrate).code(), v1::CODE_OK);
      perform(1.2);
      std::unique_ptr<std::vector<Profile>> kept;
      while (fake.mailboxes.profiles.Pop(kept)) newest = *kept;
    }
    EXPECT_EQ(newest.size(), 1U);
    EXPECT_TRUE(!newest.empty() && newest[0].neutral && newest[0].neutral->known.calibrated);
    return newest.empty() || !newest[0].neutral ? neutral::Known() : newest[0].neutral->known;
  };
  const neutral::Known plain = learn({false, false, false});
  EXPECT_GT(body::Log(plain.own.rotations[body::kHead]).norm(), 0.05F);
  for (const auto& mirror : {std::vector<bool>{true, true, true}, {true, false, true}}) {
    const neutral::Known known = learn(mirror);
    for (std::size_t j = 0; j < body::kJointCount; ++j) {
      EXPECT_LT(known.own.rotations[j].angularDistance(plain.own.rotations[j]), 0.02F) << j;
    }
  }
}

// A standby's performer continues as mirrored as the first one.
TEST(Mirror, ACheckpointContinuesMirrored) {
  Staged first(MakeConfig()), second(MakeConfig());
  first.Mirror(true);
  first.Wear("style1");
  for (int i = 0; i < 60; ++i) (void)first.Send();
  v1::Request take;
  take.set_performer("rig.a");
  take.mutable_take_checkpoint();
  const v1::Reply taken = first.fake.Ask(take);
  ASSERT_EQ(taken.code(), v1::CODE_OK) << taken.reason();
  v1::Request restore;
  *restore.mutable_restore_checkpoint()->mutable_checkpoint() = taken.checkpoint();
  const v1::Reply restored = second.fake.Ask(restore);
  ASSERT_EQ(restored.code(), v1::CODE_OK) << restored.reason();
  second.rig = first.rig;
  for (int i = 0; i < 30; ++i) {
    const auto expected = first.Send(), frames = second.Send();
    ASSERT_EQ(frames.size(), expected.size());
    for (std::size_t topic = 0; topic < frames.size(); ++topic) {
      ExpectTheSame(frames[topic], expected[topic], 0);
      EXPECT_FALSE(frames[topic].flags() & v1::FLAG_NEW_SESSION);
    }
  }
}

}  // namespace
}  // namespace styled::pipeline
