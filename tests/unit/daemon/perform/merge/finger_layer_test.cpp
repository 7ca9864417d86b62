#include "daemon/perform/merge/finger_layer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "tests/support/units.h"
#include "tests/unit/body/random_pose.h"
#include "tests/unit/daemon/glove.h"

namespace styled::pipeline {
namespace {

using runtime::Counter;
using ::testing::HasSubstr;

using support::kMs;
constexpr int kLeftIndex = rig::kTailLeftThumb + 3;
constexpr int kRightIndex = rig::kTailRightThumb + 3;
const rig::TailSet kBothHands = rig::FingersOf(body::kLeftHand) | rig::FingersOf(body::kRightHand);

class FingerLayerTest : public testing::Test {
 protected:
  FingerLayer Layer(const rig::TailSet& wanted = kBothHands) { return FingerLayer(wanted, {}, {}); }
  std::string Accept(FingerLayer& layer, const source::SourceFrame& body) {
    const auto accepted = layer.AcceptBody(body, now_ns_);
    became_ = accepted.ok() ? std::optional(accepted.value()) : std::nullopt;
    return accepted.status().message();
  }
  // Plays `ms` of glove frames at 100 Hz, and the performer's time with them.
  void Play(FingerLayer& layer, Glove& glove, int ms) {
    for (int i = 0; i < ms; i += 10) {
      now_ns_ += 10 * kMs;
      EXPECT_EQ(layer.Accept(glove.Frame(), now_ns_), MergedPart::kAccepted);
      layer.Advance(10 * kMs);
    }
  }
  // Degrees by which a joint is turned, over a straight one.
  static double Degrees(const FingerLayer& layer, int joint) {
    rig::Quat turn = rig::Quat::Identity();
    (void)layer.Over(joint, turn);
    return 57.29578 * body::Angle_rad(turn, rig::Quat::Identity());
  }

  std::int64_t now_ns_ = 1'000 * kMs;
  std::optional<FingerLayer::Body> became_;  // empty: refused
};

TEST_F(FingerLayerTest, ThePerformersOwnFingersStayWithoutAFrame) {
  FingerLayer layer = Layer();
  Glove glove;
  EXPECT_EQ(layer.Accept(glove.Frame(), now_ns_), Counter::kPipelineBeforeBody);
  EXPECT_EQ(Accept(layer, glove.Body()), "");
  EXPECT_EQ(became_, FingerLayer::Body::kBound);
  layer.Advance(10 * kMs);
  rig::Quat own = Bent(20);
  EXPECT_FALSE(layer.Over(kLeftIndex, own));
  EXPECT_EQ(own.coeffs(), Bent(20).coeffs());
  EXPECT_FALSE(layer.Live(now_ns_));
}

TEST_F(FingerLayerTest, FingersAreRelativeToTheSourcesOwnHand) {
  FingerLayer layer = Layer();
  Glove glove;
  ASSERT_EQ(Accept(layer, glove.Body()), "");
  body::Random random(3);
  glove.Of(kLeftIndex) = Bent(30);
  glove.Of(kRightIndex) = Bent(-40);
  for (int i = 0; i < 100; ++i) {  // wherever the hands are
    glove.turns[0] = random.Turn(3);
    glove.turns[static_cast<std::size_t>(glove.left_hand)] = random.Turn(3);
    glove.turns[static_cast<std::size_t>(glove.right_hand)] = random.Turn(3);
    glove.root = random.Vector(1e6F);
    Play(layer, glove, 10);
  }
  EXPECT_NEAR(Degrees(layer, kLeftIndex), 30, 0.01);
  EXPECT_NEAR(Degrees(layer, kRightIndex), 40, 0.01);
  EXPECT_NEAR(Degrees(layer, kLeftIndex + 1), 0, 0.01) << "against the joint before it";
  EXPECT_TRUE(layer.Live(now_ns_));
}

TEST_F(FingerLayerTest, TheTPoseIsTheSourcesRestPose) {
  FingerLayer layer = Layer();
  Glove glove;
  auto body = std::make_shared<v1::Body>(*glove.message);
  body::Random random(4);
  std::vector<rig::Quat> rest;  // world
  for (int j = 0; j < body->names_size(); ++j) {
    rest.push_back(random.Turn(3));
    for (const float value : rest.back().coeffs()) body->add_rest(value);
  }
  for (int j = 0; j < body->names_size(); ++j) {
    const int parent = body->parents(j);
    if (parent < 0) continue;
    const auto at = static_cast<std::size_t>(parent);
    rig::Vec3 offset(body->offsets(3 * j), body->offsets(3 * j + 1), body->offsets(3 * j + 2));
    offset = rest[at].conjugate() * offset;
    for (int k = 0; k < 3; ++k) body->set_offsets(3 * j + k, offset[k]);
    glove.turns[static_cast<std::size_t>(j)] =
        rest[at].conjugate() * rest[static_cast<std::size_t>(j)];
  }
  glove.turns[0] = rest[0];
  glove.message = body;
  ASSERT_EQ(Accept(layer, glove.Body()), "");
  Play(layer, glove, 1000);
  for (int t = 0; t < rig::kTailLeftEye; ++t) EXPECT_NEAR(Degrees(layer, t), 0, 0.05) << t;
}

TEST_F(FingerLayerTest, FingersAppearHoldAndVanishWithoutAJump) {
  FingerLayer layer = Layer();
  Glove glove;
  ASSERT_EQ(Accept(layer, glove.Body()), "");
  glove.Of(kLeftIndex) = Bent(80);
  double last = 0, fastest = 0;
  const auto step = [&](bool sends) {
    now_ns_ += 10 * kMs;
    if (sends) EXPECT_EQ(layer.Accept(glove.Frame(), now_ns_), MergedPart::kAccepted);
    layer.Advance(10 * kMs);
    const double degrees = Degrees(layer, kLeftIndex);
    fastest = std::max(fastest, std::abs(degrees - std::exchange(last, degrees)));
    return degrees;
  };
  for (int i = 0; i < 60; ++i) (void)step(true);
  EXPECT_NEAR(last, 80, 0.01);
  for (int i = 0; i < 50; ++i) EXPECT_NEAR(step(false), 80, 0.01) << "held, step " << i;
  for (int i = 0; i < 25; ++i) (void)step(false);
  EXPECT_NEAR(last, 40, 1) << "half of the way";
  for (int i = 0; i < 26; ++i) (void)step(false);
  EXPECT_NEAR(last, 0, 0.01);
  rig::Quat own = Bent(20);
  EXPECT_FALSE(layer.Over(kLeftIndex, own));
  for (int i = 0; i < 20; ++i) (void)step(true);  // and back, from where it is
  for (int i = 0; i < 60; ++i) (void)step(true);
  EXPECT_NEAR(last, 80, 0.01);
  EXPECT_LT(fastest, 80.0 * 1.6 / 50) << "degrees in 10 ms";
}

TEST_F(FingerLayerTest, AppearanceAndSilenceAreReportedOnce) {
  FingerLayer layer = Layer();
  Glove glove;
  ASSERT_EQ(Accept(layer, glove.Body()), "");
  EXPECT_EQ(layer.Change(now_ns_), 0);
  Play(layer, glove, 10);
  EXPECT_EQ(layer.Change(now_ns_), 1);
  EXPECT_EQ(layer.Change(now_ns_ + 1001 * kMs), -1);
  EXPECT_EQ(layer.Change(now_ns_ + 5000 * kMs), 0);
}

TEST_F(FingerLayerTest, AnUntrackedHandFadesAlone) {
  FingerLayer layer = Layer();
  Glove glove;
  ASSERT_EQ(Accept(layer, glove.Body()), "");
  glove.Of(kLeftIndex) = glove.Of(kRightIndex) = Bent(60);
  Play(layer, glove, 600);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  for (int t = 0; t < rig::kTailRightThumb; ++t) glove.Of(t) = rig::Quat(nan, nan, nan, nan);
  Play(layer, glove, 400);
  EXPECT_NEAR(Degrees(layer, kLeftIndex), 60, 0.01) << "held";
  Play(layer, glove, 800);
  EXPECT_NEAR(Degrees(layer, kLeftIndex), 0, 0.01) << "gone";
  EXPECT_NEAR(Degrees(layer, kRightIndex), 60, 0.01);
}

TEST_F(FingerLayerTest, AbsurdValuesAreNotShown) {
  FingerLayer layer = Layer();
  Glove glove;
  ASSERT_EQ(Accept(layer, glove.Body()), "");
  glove.Of(kLeftIndex) = Bent(60);
  Play(layer, glove, 600);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float inf = std::numeric_limits<float>::infinity();
  for (const float bad : {nan, inf, -inf, 1e30F, 0.0F, 1e-30F}) {
    for (rig::Quat& turn : glove.turns) turn = rig::Quat(bad, bad, bad, bad);
    glove.root = rig::Vec3(bad, bad, bad);
    Play(layer, glove, 20);
    for (int t = 0; t < rig::kTailLeftEye; ++t) {
      rig::Quat turn = rig::Quat::Identity();
      (void)layer.Over(t, turn);
      ASSERT_NEAR(turn.norm(), 1, 1e-3) << bad;
    }
    EXPECT_NEAR(Degrees(layer, kLeftIndex), 60, 0.1) << bad;
  }
  // Clocks that jump, and a sequence from the future.
  glove.turns.assign(glove.turns.size(), rig::Quat::Identity());
  for (const std::uint64_t time_ns : {std::uint64_t{0}, ~std::uint64_t{0} / 2}) {
    glove.time_ns = time_ns;
    Play(layer, glove, 20);
  }
  source::SourceFrame future = glove.Frame();
  future.sequence += 1ULL << 40U;
  EXPECT_EQ(layer.Accept(future, now_ns_), Counter::kPipelineFarAhead);
  Play(layer, glove, 20);
  layer.Advance(std::numeric_limits<std::int64_t>::min());
  layer.Advance(std::numeric_limits<std::int64_t>::max());
  EXPECT_GE(Degrees(layer, kLeftIndex), 0);
}

TEST_F(FingerLayerTest, OnlyWantedJointsAreAccepted) {
  FingerLayer layer = Layer(rig::FingersOf(body::kRightHand));
  Glove glove;
  ASSERT_EQ(Accept(layer, glove.Body()), "");
  glove.Of(kLeftIndex) = glove.Of(kRightIndex) = Bent(60);
  Play(layer, glove, 600);
  EXPECT_EQ(Degrees(layer, kLeftIndex), 0);
  EXPECT_NEAR(Degrees(layer, kRightIndex), 60, 0.01);
}

TEST_F(FingerLayerTest, ABodyOfASecondSenderIsRefusedWithItsReason) {
  FingerLayer layer = Layer();
  Glove glove, second;
  second.session = 6;
  second.crc = 78;
  ASSERT_EQ(Accept(layer, glove.Body()), "");
  EXPECT_EQ(Accept(layer, second.Body()), "");
  EXPECT_EQ(became_, FingerLayer::Body::kNotNext);
  EXPECT_EQ(layer.why(), Counter::kPipelineSecondSender);
}

TEST_F(FingerLayerTest, ABodyWithoutFingersIsRefusedOnceASession) {
  FingerLayer layer = Layer();
  Glove bare{rig::TailSet()};
  EXPECT_THAT(Accept(layer, bare.Body()), HasSubstr("found no finger below a hand"));
  EXPECT_EQ(became_, std::nullopt);
  EXPECT_EQ(Accept(layer, bare.Body()), "");
  EXPECT_EQ(became_, FingerLayer::Body::kSame) << "the body comes once a second";
  EXPECT_EQ(layer.Accept(bare.Frame(), now_ns_), Counter::kPipelineUncalibrated);
  Glove right(rig::FingersOf(body::kRightHand));
  right.crc = 78;
  right.sequence = bare.sequence;
  EXPECT_EQ(Accept(layer, right.Body()), "");
  EXPECT_EQ(became_, FingerLayer::Body::kBound) << "another one";
  FingerLayer left = Layer(rig::FingersOf(body::kLeftHand));
  EXPECT_THAT(Accept(left, right.Body()), HasSubstr("no finger that is to be merged"));
  v1::Body odd = *right.message;
  odd.set_parents(2, 40);
  right.message = std::make_shared<v1::Body>(odd);
  right.crc = 79;
  EXPECT_THAT(Accept(layer, right.Body()), HasSubstr("parent 40, expected an earlier joint"));
}

TEST_F(FingerLayerTest, ASecondSenderWaitsUntilTheFirstIsSilent) {
  FingerLayer layer = Layer();
  Glove first, second, other;
  second.session = 99;
  other.performer = "other";
  ASSERT_EQ(Accept(layer, first.Body()), "");
  first.Of(kLeftIndex) = Bent(60);
  Play(layer, first, 600);
  EXPECT_EQ(layer.Accept(second.Frame(), now_ns_), Counter::kPipelineSecondSender);
  EXPECT_EQ(layer.Accept(other.Frame(), now_ns_), Counter::kPipelineSecondSender);
  EXPECT_EQ(Accept(layer, other.Body()), "");
  EXPECT_NEAR(Degrees(layer, kLeftIndex), 60, 0.01);
  now_ns_ += 501 * kMs;
  ASSERT_EQ(Accept(layer, other.Body()), "");
  EXPECT_EQ(layer.Accept(other.Frame(), now_ns_), MergedPart::kAccepted);
  EXPECT_EQ(layer.Accept(first.Frame(), now_ns_), Counter::kPipelineSecondSender);
}

TEST_F(FingerLayerTest, AFrameOfAnotherBodyOrSizeIsRefused) {
  FingerLayer layer = Layer();
  Glove glove;
  ASSERT_EQ(Accept(layer, glove.Body()), "");
  source::SourceFrame frame = glove.Frame();
  frame.body_crc = 1;
  EXPECT_EQ(layer.Accept(frame, now_ns_), Counter::kPipelineWrongBody);
  frame = glove.Frame();
  frame.rotations = frame.rotations.first(frame.rotations.size() - 16);
  EXPECT_EQ(layer.Accept(frame, now_ns_), Counter::kPipelineWrongSize);
  frame = glove.Frame();
  frame.sequence -= 2;
  EXPECT_EQ(layer.Accept(frame, now_ns_), Counter::kPipelineDuplicate);
}

}  // namespace
}  // namespace styled::pipeline
