// The performer's own gaits, which Neutral learns where the reference has gaits.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <vector>

#include "model/gait/analysis.h"
#include "model/neutral/neutral.h"
#include "tests/unit/gait/performed.h"

namespace styled::neutral {
namespace {

constexpr float kRate_hz = 60, kDt_s = 1 / kRate_hz;

gait::Gait GaitOf(const std::string& script) {
  const gait::Analysis analysis = gait::Analyse(gait::Perform(script, 12, 60), kRate_hz);
  return analysis.walk ? *analysis.walk : *analysis.run;
}

Reference TestReference() {
  const gait::Gait walk = GaitOf("walk:60"), run = GaitOf("run:60");
  Reference reference;
  reference.walking.rotations = walk.curve.mean;
  reference.running.rotations = run.curve.mean;
  reference.standing.rotations = walk.curve.mean;
  reference.gaits = Gaits{walk.curve, run.curve};
  return reference;
}

// A performer who holds the left elbow otherwise, and swings the left arm out with each stride.
constexpr float kElbow_rad = 0.3F, kSwing_rad = 0.25F;
std::vector<body::Pose> OwnWalk(double seconds) {
  std::vector<body::Pose> walk = gait::Perform("walk:60", seconds, 60);
  const std::vector<gait::Phase> phases = gait::PhasesOf(walk, 60);
  for (std::size_t i = 0; i < walk.size(); ++i) {
    auto& arm = walk[i].rotations[body::kLeftUpperArm];
    arm = arm * body::Exp({0, 0, kSwing_rad * std::sin(phases[i].phase_rad)});
    auto& elbow = walk[i].rotations[body::kLeftLowerArm];
    elbow = elbow * body::Exp({0, -kElbow_rad, 0});
  }
  return walk;
}

Neutral Followed(const std::vector<body::Pose>& poses, const Reference& reference,
                 bool learns = true) {
  Neutral neutral;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    neutral.Follow(poses[i], i == 0 ? 0 : kDt_s, learns, reference);
  }
  return neutral;
}

body::Vec3 Term(const gait::Series& series, int term, body::Joint joint) {
  return series.col(term).segment<3>(3 * joint);
}

TEST(OwnGaits, AWalkIsLearnedInSeconds) {
  const Reference reference = TestReference();
  const gait::Series& usual = reference.gaits->walking.series;
  for (const double seconds : {4.0, 8.0, 40.0}) {
    const Neutral neutral = Followed(OwnWalk(seconds), reference);
    const gait::Series& own = neutral.walk().series();
    const double tolerance = seconds < 5 ? 0.12 : 0.06;
    EXPECT_NEAR(Term(own, 0, body::kLeftLowerArm).y(), -kElbow_rad, tolerance) << seconds;
    EXPECT_NEAR(Term(own - usual, gait::kHarmonics + 1, body::kLeftUpperArm).z(), kSwing_rad,
                tolerance)
        << seconds;
    EXPECT_NEAR(Term(own - usual, 1, body::kHead).norm(), 0, 0.03) << seconds;
    EXPECT_LT(neutral.run().seconds(), 0.01F) << seconds;
  }
}

// Before anything is known, and for a gait that was not seen: the gait of many, with the carriage
// that is known.
TEST(OwnGaits, WithoutAGaitItIsThatOfManyWithTheirCarriage) {
  const Reference reference = TestReference();
  const Neutral fresh = Followed({gait::Perform("stand:60", 0.1, 60)}, reference);
  EXPECT_LT((fresh.walk().series() - reference.gaits->walking.series).cwiseAbs().maxCoeff(), 0.1F);
  const Neutral walked = Followed(OwnWalk(12), reference);
  // The turn is the same; its axis is in the parent's frame, and the elbow of a run is bent.
  EXPECT_NEAR(Term(walked.run().series(), 0, body::kLeftLowerArm).norm(), kElbow_rad, 0.05);
}

// Half a stride later the mirror image shows what the other side showed.
TEST(OwnGaits, OfAMirroredPerformerTheyAreTheMirrorImage) {
  const Reference reference = TestReference();
  Neutral neutral = Followed(OwnWalk(12), reference);
  const gait::Series before = neutral.walk().series();
  const Known known = neutral.Tell(reference);
  neutral.Mirror();
  const Known mirrored = Mirrored(known);
  for (const float phase_rad : {0.0F, 0.7F, 2.0F, 4.5F}) {
    const gait::Terms here = gait::TermsAt(phase_rad),
                      there = gait::TermsAt(phase_rad + gait::tuning::kTurn_rad / 2);
    const gait::Vectors expected = before * here;
    const gait::Vectors got = neutral.walk().series() * there;
    const gait::Vectors told = mirrored.walking * there, first = known.walking * here;
    for (int joint = 0; joint < body::kJointCount; ++joint) {
      const int other = body::MirrorJoint(joint);
      const body::Vec3 reflected(1, -1, -1);
      EXPECT_LT((gait::VectorOf(got, joint) -
                 body::Vec3(gait::VectorOf(expected, other).cwiseProduct(reflected)))
                    .norm(),
                1e-4F)
          << joint;
      EXPECT_LT((gait::VectorOf(told, joint) -
                 body::Vec3(gait::VectorOf(first, other).cwiseProduct(reflected)))
                    .norm(),
                1e-4F)
          << joint;
    }
  }
  // The learned sums are mirrored, too: they still hold after the curves are found again.
  EXPECT_NEAR(Term(neutral.walk().series(), 0, body::kRightLowerArm).y(), kElbow_rad, 0.08);
  std::vector<body::Pose> walk = OwnWalk(20);
  for (std::size_t i = 12 * 60; i < walk.size(); ++i) {
    body::Mirror(walk[i], walk[i]);
    neutral.Follow(walk[i], i == 12 * 60 ? 0 : kDt_s, true, reference);
  }
  EXPECT_NEAR(Term(neutral.walk().series(), 0, body::kRightLowerArm).y(), kElbow_rad, 0.08);
  EXPECT_NEAR(Term(neutral.walk().series(), 0, body::kLeftLowerArm).y(),
              -Term(before, 0, body::kRightLowerArm).y(), 0.08);
}

TEST(OwnGaits, AStyledPerformerTeachesNothing) {
  const Reference reference = TestReference();
  const Neutral neutral = Followed(OwnWalk(8), reference, /*learns=*/false);
  EXPECT_EQ(neutral.walk().seconds(), 0);
  EXPECT_GT(neutral.phase().confidence, 0.9F) << "but their gait is followed";
}

TEST(OwnGaits, WhatIsKnownIsToldAndKnownAgain) {
  const Reference reference = TestReference();
  const Neutral neutral = Followed(OwnWalk(12), reference);
  const Known known = neutral.Tell(reference);
  EXPECT_GT(known.walking_s, 5);
  Neutral again;
  again.Know(known, reference);
  EXPECT_LT((again.walk().series() - neutral.walk().series()).cwiseAbs().maxCoeff(), 0.05F);
  // For another network's reference it is the same gait about other means.
  Reference other = reference;
  for (gait::Curve* const curve : {&other.gaits->walking, &other.gaits->running}) {
    curve->mean[body::kLeftLowerArm] =
        curve->mean[body::kLeftLowerArm] * body::Exp({0, -kElbow_rad, 0});
  }
  Neutral elsewhere;
  elsewhere.Know(known, other);
  EXPECT_NEAR(Term(elsewhere.walk().series(), 0, body::kLeftLowerArm).y(), 0, 0.06);
}

TEST(OwnGaits, ForgettingBeginsAgain) {
  const Reference reference = TestReference();
  Neutral neutral = Followed(OwnWalk(8), reference);
  neutral.Forget();
  EXPECT_EQ(neutral.walk().seconds(), 0);
  neutral.Follow(gait::Perform("stand:60", 1, 60).back(), kDt_s, true, reference);
  for (int i = 0; i < 30; ++i) {
    neutral.Follow(gait::Perform("stand:60", 1, 60).back(), kDt_s, true, reference);
  }
  EXPECT_LT(std::abs(Term(neutral.walk().series() - reference.gaits->walking.series,
                          gait::kHarmonics + 1, body::kLeftUpperArm)
                         .z()),
            0.03F);
}

TEST(OwnGaits, ACheckpointContinuesBitForBit) {
  const Reference reference = TestReference();
  const std::vector<body::Pose> walk = OwnWalk(8);
  Neutral one = Followed(walk, reference), other;
  std::vector<std::byte> bytes(32768);
  Checkpoint write = Checkpoint::Into(bytes);
  one.Carry(write);
  ASSERT_TRUE(write.ok());
  Checkpoint read = Checkpoint::From(std::span(bytes).first(write.size()));
  other.Carry(read);
  ASSERT_TRUE(read.complete());
  for (std::size_t i = 0; i < 60; ++i) {
    one.Follow(walk[i], kDt_s, true, reference);
    other.Follow(walk[i], kDt_s, true, reference);
  }
  EXPECT_EQ(one.walk().series(), other.walk().series());
  EXPECT_EQ(one.phase().phase_rad, other.phase().phase_rad);
}

TEST(OwnGaits, ACheckpointWithoutSenseIsRefused) {
  OwnGait gait;
  std::vector<std::byte> bytes(8192);
  Checkpoint write = Checkpoint::Into(bytes);
  gait.Carry(write);
  bytes.resize(write.size());
  const float nan = std::numeric_limits<float>::quiet_NaN();
  for (std::size_t at = 0; at + 4 <= bytes.size(); at += 4) {
    auto damaged = bytes;
    std::memcpy(&damaged[at], &nan, 4);
    Checkpoint from = Checkpoint::From(damaged);
    OwnGait().Carry(from);
    EXPECT_FALSE(from.ok()) << "number " << at / 4;
  }
}

}  // namespace
}  // namespace styled::neutral
