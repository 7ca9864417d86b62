#include "model/gait/curve.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "tests/unit/body/random_pose.h"

namespace styled::gait {
namespace {

Curve AnyCurve() {
  body::Random random(2);
  Curve curve;
  for (body::Quat& rotation : curve.mean) rotation = random.Turn(1);
  for (int j = 0; j < 3 * body::kJointCount; ++j) {
    for (int k = 0; k < kTerms; ++k) curve.series(j, k) = random.Between(-0.1F, 0.1F);
  }
  return curve;
}

TEST(CurveTest, TheTermsAreTheHarmonicsOfThePhase) {
  for (const float phase_rad : {-7.0F, 0.0F, 0.5F, 3.0F, 6.2F, 40.0F}) {
    const Terms terms = TermsAt(phase_rad);
    EXPECT_EQ(terms[0], 1);
    for (int k = 1; k <= kHarmonics; ++k) {
      const auto angle = static_cast<float>(k) * phase_rad;
      EXPECT_NEAR(terms[k], std::cos(angle), 1e-5F);
      EXPECT_NEAR(terms[kHarmonics + k], std::sin(angle), 1e-5F);
    }
  }
}

TEST(CurveTest, AJointIsItsMeanTurnedByItsSeries) {
  const Curve curve = AnyCurve();
  const Terms terms = TermsAt(1.3F);
  const Rotations at = curve.At(terms);
  for (int joint = 0; joint < body::kJointCount; ++joint) {
    body::Vec3 vector = body::Vec3::Zero();
    for (int k = 0; k < kTerms; ++k) vector += terms[k] * curve.series.block<3, 1>(3 * joint, k);
    const auto j = static_cast<std::size_t>(joint);
    EXPECT_LT(body::Angle_rad(at[j], curve.mean[j] * body::Exp(vector)), 1e-5);
  }
}

TEST(CurveTest, ATurnLaterItIsTheSame) {
  const Curve curve = AnyCurve();
  const Rotations here = curve.At(TermsAt(2)), later = curve.At(TermsAt(2 + 6.283185307F));
  for (std::size_t j = 0; j < here.size(); ++j) EXPECT_LT(body::Angle_rad(here[j], later[j]), 1e-5);
}

std::vector<std::byte> Written(Curve& curve) {
  Checkpoint count;
  curve.Carry(count);
  std::vector<std::byte> bytes(count.size());
  auto into = Checkpoint::Into(bytes);
  curve.Carry(into);
  return bytes;
}

TEST(CurveTest, ACheckpointGivesTheSameBits) {
  Curve curve = AnyCurve(), other;
  const auto bytes = Written(curve);
  auto from = Checkpoint::From(bytes);
  other.Carry(from);
  ASSERT_TRUE(from.complete());
  EXPECT_EQ(Written(other), bytes);
}

TEST(CurveTest, ACheckpointWithoutSenseIsRefused) {
  Curve curve = AnyCurve();
  const auto bytes = Written(curve);
  for (std::size_t at = 0; at < bytes.size(); at += 4) {
    auto damaged = bytes;
    const float nan = std::numeric_limits<float>::quiet_NaN();
    std::memcpy(&damaged[at], &nan, 4);
    Curve other;
    auto from = Checkpoint::From(damaged);
    other.Carry(from);
    EXPECT_FALSE(from.ok()) << "number " << at / 4;
  }
}

}  // namespace
}  // namespace styled::gait
