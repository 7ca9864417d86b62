#include "model/train/judge/perturb.h"

#include <gtest/gtest.h>

#include "model/synthetic/performer.h"

namespace styled::judge {
namespace {

Poses PlainWalk() {
  synthetic::Performer human(synthetic::Vary(1, 1, {{synthetic::Motion::kWalk, 60}}));
  Poses poses(240);
  for (std::size_t i = 0; i < poses.size(); ++i) human.Pose(static_cast<double>(i) / 120, poses[i]);
  return poses;
}

double Angle_deg(const body::Quat& a, const body::Quat& b) {
  return body::Log(a.conjugate() * b).norm() * 180 / M_PI;
}

TEST(JudgePerturb, EachDoesWhatItSaysAndTheSameForTheSameSeed) {
  const Poses walk = PlainWalk();
  const auto spoilt = [&](Perturbation kind) { return Perturb(kind, walk, 120, 3); };

  const Poses rest = spoilt(Perturbation::kRest);
  for (int joint = 1; joint < body::kJointCount; ++joint) {
    const double first = Angle_deg(walk[0].rotations[joint], rest[0].rotations[joint]);
    EXPECT_GT(first, 4.9);
    EXPECT_LT(first, 15.1);
    EXPECT_NEAR(Angle_deg(walk[200].rotations[joint], rest[200].rotations[joint]), first, 0.05);
  }

  const Poses noise = spoilt(Perturbation::kNoise);
  double square = 0;
  for (std::size_t i = 0; i < walk.size(); ++i) {
    square += std::pow(Angle_deg(walk[i].rotations[5], noise[i].rotations[5]), 2);
  }
  EXPECT_NEAR(std::sqrt(square / static_cast<double>(walk.size())), 0.5, 0.08);

  const Poses drift = spoilt(Perturbation::kDrift);
  EXPECT_NEAR(Angle_deg(walk[239].rotations[0], drift[239].rotations[0]), 20.0 * 239 / 120 / 60,
              0.05);
  EXPECT_EQ(drift[239].hips_position_m.y(), walk[239].hips_position_m.y());

  const Poses floor = spoilt(Perturbation::kFloor);
  EXPECT_NEAR(std::abs(floor[7].hips_position_m.y() - walk[7].hips_position_m.y()), 0.1, 1e-6);

  const Poses frozen = spoilt(Perturbation::kFrozen);
  int still = 0;
  for (int joint = 0; joint < body::kJointCount; ++joint) {
    if (Angle_deg(walk[60].rotations[joint], frozen[60].rotations[joint]) > 0.1) {
      ++still;
      EXPECT_LT(Angle_deg(frozen[0].rotations[joint], frozen[200].rotations[joint]), 0.01);
    }
  }
  EXPECT_EQ(still, 1);

  for (std::size_t kind = 0; kind < kPerturbations.size(); ++kind) {
    const auto of = static_cast<Perturbation>(kind);
    EXPECT_EQ(Perturb(of, walk, 120, 3)[100].hips_position_m, spoilt(of)[100].hips_position_m);
  }
}

}  // namespace
}  // namespace styled::judge
