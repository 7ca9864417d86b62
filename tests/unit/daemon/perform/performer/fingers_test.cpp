// Fingers of other sources on a performer.
#include "daemon/perform/performer/fingers.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "tests/support/fake_pipeline.h"
#include "tests/support/units.h"
#include "tests/unit/daemon/glove.h"
#include "tests/unit/net/erd/random_weights.h"
#include "tests/unit/rig/rigs.h"

namespace styled::pipeline {
namespace {

using runtime::Counter;
using ::testing::HasSubstr;

using support::kMs;
constexpr int kIndex = rig::kTailLeftThumb + 3;
const rig::TailSet kLeft = rig::FingersOf(body::kLeftHand);
const rig::TailSet kBoth = kLeft | rig::FingersOf(body::kRightHand);

// A layer whose index finger is bent, and its glove.
struct Given {
  explicit Given(float degrees, const rig::TailSet& joints = kBoth)
      : glove(joints), layer(kBoth, {}, {}) {
    const auto accepted = layer.AcceptBody(glove.Body(), 0);
    EXPECT_TRUE(accepted.ok() && accepted.value() == FingerLayer::Body::kBound)
        << accepted.status().message();
    glove.Of(kIndex) = Bent(degrees);
  }
  void Send() { EXPECT_EQ(layer.Accept(glove.Frame(), now_ns += 10 * kMs), MergedPart::kAccepted); }
  Glove glove;
  FingerLayer layer;
  std::int64_t now_ns = 0;
};

rig::Binding Humanoid() {
  return rig::WithFingers(rig::Binding::Make(rig::HumanoidSpec()).value(), kBoth);
}
std::size_t JointOf(const rig::Binding& binding, int tail_joint) {
  return static_cast<std::size_t>(
      rig::MapTailNames(binding.skeleton())[static_cast<std::size_t>(tail_joint)]);
}
double Degrees(const rig::Quat& a, const rig::Quat& b) { return 57.29578 * body::Angle_rad(a, b); }

TEST(Fingers, AHandWithoutPlaceForFingersIsNamed) {
  Given given(50);
  FingerLayer* const layer = &given.layer;
  EXPECT_EQ(Fingers({layer}, Humanoid()).HandsWithoutPlace(), "");
  const rig::Binding bare = rig::Binding::Make(rig::HumanoidSpec()).value();
  EXPECT_EQ(Fingers({layer}, bare).HandsWithoutPlace(), "left and right");
  EXPECT_EQ(Fingers({layer}, rig::WithFingers(bare, kLeft)).HandsWithoutPlace(), "right");
  EXPECT_EQ(Fingers({}, bare).HandsWithoutPlace(), "") << "nobody gives any";
}

TEST(Fingers, ReplaceThePerformersOwnAndLeaveTheRestBitForBit) {
  const rig::Binding binding = Humanoid();
  Given given(50, kLeft);
  Fingers fingers({&given.layer}, binding);
  body::Random random(5);
  const rig::RigPose own = rig::AnyRigPose(binding.skeleton(), random, 1);
  rig::RigPose pose = own;
  for (int i = 0; i < 100; ++i) {
    given.Send();
    pose = own;
    fingers.Apply(i * 10 * kMs, pose);
  }
  for (std::size_t j = 0; j < own.rotations.size(); ++j) {
    const auto& name = binding.skeleton().names[j];
    const bool left_finger = j >= body::kJointCount && name.starts_with("left");
    if (left_finger) {
      const bool index = name == "leftIndexProximal";
      EXPECT_LT(Degrees(pose.rotations[j], index ? Bent(50) : rig::Quat::Identity()), 0.05) << name;
    } else {
      EXPECT_EQ(pose.rotations[j].coeffs(), own.rotations[j].coeffs()) << name;
    }
  }
}

TEST(Fingers, FadeToThePerformersOwnWhichMayBeMissing) {
  const rig::Binding binding = Humanoid();
  const std::size_t joint = JointOf(binding, kIndex);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  Given given(50);
  Fingers fingers({&given.layer}, binding);
  rig::Quat last = rig::Quat::Identity();
  double fastest = 0;
  for (int i = 0; i < 300; ++i) {
    if (i < 100) given.Send();
    rig::RigPose pose(binding.skeleton());
    // Its own finger is bent the other way, and not tracked while the glove goes.
    const bool tracked = i < 120 || i > 250;
    pose.rotations[joint] = tracked ? Bent(-20) : rig::Quat(nan, nan, nan, nan);
    fingers.Apply(i * 10 * kMs, pose);
    const rig::Quat shown = pose.rotations[joint];
    if (i == 0) last = shown;
    if (i <= 199) {
      ASSERT_TRUE(shown.coeffs().allFinite()) << i;
      fastest = std::max(fastest, Degrees(shown, std::exchange(last, shown)));
    }
    if (i == 99) EXPECT_NEAR(Degrees(shown, Bent(50)), 0, 0.05);
    if (i == 198) EXPECT_NEAR(Degrees(shown, Bent(-20)), 0, 1);
    if (i == 240) EXPECT_FALSE(shown.coeffs().allFinite()) << "not ours any longer";
    if (i == 280) EXPECT_EQ(shown.coeffs(), Bent(-20).coeffs());
  }
  EXPECT_LT(fastest, 70.0 * 1.6 / 50) << "degrees in 10 ms";
}

TEST(Fingers, TheFirstOfTwoSourcesWithDataCountsForEachFinger) {
  const rig::Binding binding = Humanoid();
  Given first(50, rig::FingersOf(body::kRightHand) | rig::TailSet(7U << kIndex)), second(10);
  second.glove.Of(rig::kTailLeftThumb) = Bent(30);
  Fingers fingers({&first.layer, &second.layer}, binding);
  rig::RigPose pose(binding.skeleton());
  for (int i = 0; i < 200; ++i) {
    if (i < 60) first.Send();
    second.Send();
    pose = rig::RigPose(binding.skeleton());
    fingers.Apply(i * 10 * kMs, pose);
    const rig::Quat index = pose.rotations[JointOf(binding, kIndex)];
    if (i == 59) EXPECT_NEAR(Degrees(index, Bent(50)), 0, 0.05);
    if (i == 59) EXPECT_NEAR(Degrees(pose.rotations[JointOf(binding, 0)], Bent(30)), 0, 0.05);
  }
  EXPECT_NEAR(Degrees(pose.rotations[JointOf(binding, kIndex)], Bent(10)), 0, 0.05);
}

// The whole pipeline: a rig without fingers, gloves beside it.
class MergedFingersTest : public testing::Test {
 protected:
  explicit MergedFingersTest(const std::string& topic = "styled/rig.a/")
      : pipeline_(MakeConfig(), topic, {"rig", "gloves"}) {
    config::Source rig, gloves;
    gloves.name = "gloves";
    gloves.merge_into = "rig.a";
    gloves.parts = {"fingers", "face"};
    pipeline_.pipeline().SetLayers({rig, gloves});
    pipeline_.publisher.events.push_back({true, "styled/rig.a/canonical/"});
    pipeline_.Work();
    pipeline_.Deliver({rig_.Body()});
  }
  static std::shared_ptr<RuntimeConfig> MakeConfig() {
    auto live = std::make_shared<RuntimeConfig>();
    live->network = erd::RandomStylizer(5, 1);
    return live;
  }
  void Glove100Hz(int frames) {
    for (int i = 0; i < frames; ++i) {
      pipeline_.clock.now_ns += 10 * kMs;
      const source::SourceFrame frame = glove_.Frame();
      pipeline_.pipeline().OnFrames(1, {&frame, 1}, false);
      rig_.period_ns = 10'000'000;
      pipeline_.Deliver({rig_.Frame()});
    }
  }
  void GloveBody() {
    const source::SourceFrame body = glove_.Body();
    pipeline_.pipeline().OnFrames(1, {&body, 1}, false);
  }
  rig::Quat Last(int joint) const {
    const float* const q = pipeline_.publisher.frames.back().rotations().data() +
                           static_cast<std::ptrdiff_t>(4 * (body::kJointCount + joint));
    return {q[3], q[0], q[1], q[2]};
  }

  support::FakePipeline pipeline_;
  support::Rig rig_{"a"};
  Glove glove_;
};

TEST_F(MergedFingersTest, ReachAPerformerWhoseRigHasNone) {
  glove_.Of(kIndex) = Bent(50);
  Glove100Hz(5);  // before its body: the performer has fingers, at rest
  ASSERT_FALSE(pipeline_.publisher.frames.empty());
  EXPECT_EQ(pipeline_.publisher.frames.back().rotations_size(), 4 * (body::kJointCount + 30));
  EXPECT_NEAR(Degrees(Last(kIndex), rig::Quat::Identity()), 0, 0.01);
  GloveBody();
  Glove100Hz(60);
  EXPECT_NEAR(Degrees(Last(kIndex), Bent(50)), 0, 0.05);
  EXPECT_NEAR(Degrees(Last(kIndex + 1), rig::Quat::Identity()), 0, 0.05);
  EXPECT_EQ(pipeline_.Count(Counter::kPipelinePerformers), 1U);
  EXPECT_EQ(pipeline_.Count(Counter::kPipelineWrongSize), 0U);
  const v1::PerformerStats row = pipeline_.StatsOf("rig.a");
  ASSERT_EQ(row.layers_size(), 2);
  EXPECT_EQ(row.layers(0).part(), "face");
  EXPECT_FALSE(row.layers(0).live());
  EXPECT_EQ(row.layers(1).source(), "gloves");
  EXPECT_EQ(row.layers(1).part(), "fingers");
  EXPECT_TRUE(row.layers(1).live());
  EXPECT_THAT(pipeline_.Lines(), ::testing::Contains(HasSubstr("source gloves gives the fingers")));
  pipeline_.Pass(2000);
  EXPECT_THAT(pipeline_.Lines(), ::testing::Contains(HasSubstr("gloves is silent: the fingers")));
  EXPECT_FALSE(pipeline_.StatsOf("rig.a").layers(1).live());
}

TEST_F(MergedFingersTest, OnAPerformerWhoIsMirroredTheyAreThoseOfTheOtherHand) {
  v1::Request request;
  request.set_performer("rig.a");
  request.mutable_set()->set_mirror(true);
  ASSERT_EQ(pipeline_.Ask(request).code(), v1::CODE_OK);
  glove_.Of(kIndex) = Bent(50);
  GloveBody();
  Glove100Hz(60);
  EXPECT_NEAR(Degrees(Last(kIndex), rig::Quat::Identity()), 0, 0.05);
  EXPECT_NEAR(Degrees(Last(kIndex + rig::kHandTail), rig::Mirrored(Bent(50))), 0, 0.05);
}

TEST_F(MergedFingersTest, ASourceWithoutFingersIsReportedOnce) {
  glove_ = Glove(rig::TailSet());
  for (int i = 0; i < 5; ++i) {
    GloveBody();
    Glove100Hz(50);
  }
  int said = 0;
  for (const std::string& line : pipeline_.Lines()) {
    if (line.find("gives no fingers: body: found no finger") != std::string::npos) ++said;
  }
  EXPECT_EQ(said, 1);
  EXPECT_EQ(pipeline_.Count(Counter::kPipelineUncalibrated), 250U);
}

}  // namespace
}  // namespace styled::pipeline
