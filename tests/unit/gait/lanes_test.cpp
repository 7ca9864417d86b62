#include "model/gait/lanes.h"

#include <gtest/gtest.h>

#include <random>

namespace styled::gait {
namespace {

constexpr float kExact = 2e-6F;

// Turns of all sizes up to `most_rad`, none among them, about all axes.
Vectors RandomVectors(unsigned seed, float most_rad) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> number(-1, 1);
  Vectors vectors = Vectors::Zero();
  for (int joint = 1; joint < body::kJointCount; ++joint) {
    const body::Vec3 axis = body::Vec3(number(random), number(random), number(random)).normalized();
    const float share = static_cast<float>(joint) / (body::kJointCount - 1);
    vectors.segment<3>(3 * joint) = (most_rad * share * share * share) * axis;
  }
  return vectors;
}

Rotations Exps(const Vectors& vectors) {
  Rotations rotations;
  for (int joint = 0; joint < body::kJointCount; ++joint) {
    rotations[static_cast<std::size_t>(joint)] = body::Exp(VectorOf(vectors, joint));
  }
  return rotations;
}

void ExpectSame(const Rotations& a, const Rotations& b) {
  for (std::size_t j = 0; j < a.size(); ++j) {
    EXPECT_LT((a[j].coeffs() - b[j].coeffs()).norm(), kExact) << "joint " << j;
  }
}

// Beyond half a turn and beyond a whole one, too: strengths and several styles add.
TEST(Lanes, ExponentialsAreThoseOfEachJoint) {
  for (const float most_rad : {1e-7F, 0.5F, 3.1F, 12.0F}) {
    const Vectors vectors = RandomVectors(1, most_rad);
    ExpectSame(FromLanes(ExpOf(ToLanes(vectors))), Exps(vectors));
  }
}

TEST(Lanes, LogarithmsAndAnglesAreThoseOfEachJoint) {
  for (const float most_rad : {1e-7F, 0.5F, 3.1F, 6.2F}) {
    const Rotations rotations = Exps(RandomVectors(2, most_rad));
    const Vectors logs = FromLanes(LogOf(ToLanes(rotations)));
    const Lane angles_rad = AnglesOf(ToLanes(rotations));
    for (int joint = 0; joint < body::kJointCount; ++joint) {
      const body::Vec3 expected = body::Log(rotations[static_cast<std::size_t>(joint)]);
      EXPECT_LT((VectorOf(logs, joint) - expected).norm(), kExact) << most_rad << ", " << joint;
      EXPECT_NEAR(angles_rad[joint], expected.norm(), kExact) << most_rad << ", " << joint;
    }
  }
}

TEST(Lanes, ProductsAndInversesAreThoseOfEachJoint) {
  const Rotations a = Exps(RandomVectors(3, 3)), b = Exps(RandomVectors(4, 3));
  Rotations expected;
  for (std::size_t j = 0; j < a.size(); ++j) expected[j] = a[j].conjugate() * b[j];
  ExpectSame(FromLanes(ToLanes(a).Inverse() * ToLanes(b)), expected);
}

TEST(Lanes, RotationsThatDriftedAreNormalized) {
  Rotations rotations = Exps(RandomVectors(5, 3));
  const Rotations expected = rotations;
  for (body::Quat& rotation : rotations) rotation.coeffs() *= 1.01F;
  ExpectSame(FromLanes(ToLanes(rotations)), expected);
}

TEST(Lanes, ASeriesHasTheValuesOfItsCurve) {
  Curve curve;
  for (int term = 0; term < kTerms; ++term) {
    curve.series.col(term) = RandomVectors(6 + static_cast<unsigned>(term), 0.5F);
  }
  const Terms terms = TermsAt(0.7F);
  EXPECT_LT((FromLanes(LanesAt(ToLanes(curve.series), terms)) - curve.VectorsAt(terms)).norm(),
            kExact);
}

}  // namespace
}  // namespace styled::gait
