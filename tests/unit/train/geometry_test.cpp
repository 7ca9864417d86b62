#include "model/train/geometry.h"

#include <gtest/gtest.h>

#include "tests/unit/train/walker.h"

namespace styled::train {
namespace {

using torch::Tensor;

constexpr int kFrames = 30;

struct WindowTensors {
  Tensor features = torch::empty({kFrames, 1, erd::kFeatureCount});
  Tensor yaw = torch::empty({kFrames, 1});
  Tensor step = torch::empty({kFrames, 1, 3});

  explicit WindowTensors(bool mirrored, int start = 10) {
    FillWindow(Walker(60), start, kFrames, mirrored, false, {},
               {.features = features.data_ptr<float>(),
                .yaw_change_rad = yaw.data_ptr<float>(),
                .hips_step_m = step.data_ptr<float>()});
  }
  Tensor rotations() const {
    return features.narrow(2, 0, erd::kRotationFeatures).reshape({kFrames, 1, -1, 4});
  }
  Tensor positions() const {
    return features.narrow(2, erd::kPositionBegin, erd::kPositionFeatures)
        .reshape({kFrames, 1, -1, 3});
  }
  Tensor velocities() const {
    return features.narrow(2, erd::kVelocityBegin, erd::kVelocityFeatures)
        .reshape({kFrames, 1, -1, 3});
  }
};

double LargestDifference(const Tensor& a, const Tensor& b) {
  return (a - b).abs().max().item<double>();
}

TEST(Geometry, PositionsAgreeWithTheFeatures) {
  for (const bool mirrored : {false, true}) {
    const WindowTensors window(mirrored);
    EXPECT_LT(LargestDifference(HipsRelativePositions(window.rotations()), window.positions()),
              1e-5);
  }
}

TEST(Geometry, VelocitiesAgreeWithTheFeatures) {
  for (const bool mirrored : {false, true}) {
    for (const int start : {0, 10}) {
      const WindowTensors window(mirrored, start);
      const Tensor velocities = WorldVelocities(window.positions(), window.yaw, window.step,
                                                torch::zeros({kFrames, 1}), 30.0);
      EXPECT_LT(LargestDifference(velocities, window.velocities().narrow(0, 1, kFrames - 1)), 2e-4);
    }
  }
}

TEST(Geometry, LiftingTheBodyIsAVerticalVelocity) {
  const WindowTensors window(false);
  const Tensor lift = torch::arange(kFrames).to(torch::kFloat32).view({-1, 1}) * 0.01;
  const Tensor change = WorldVelocities(window.positions(), window.yaw, window.step, lift, 30.0) -
                        window.velocities().narrow(0, 1, kFrames - 1);
  EXPECT_NEAR(change.select(-1, 1).mean().item<double>(), 0.3, 1e-3);
  EXPECT_NEAR(change.select(-1, 0).abs().max().item<double>(), 0.0, 1e-3);
}

TEST(Geometry, QuaternionsAgreeWithTheBody) {
  const body::Quat a = body::Exp(body::Vec3(0.3F, -1.2F, 0.7F));
  const body::Quat b = body::Exp(body::Vec3(-0.9F, 0.2F, 0.4F));
  const auto tensor = [](const body::Quat& q) {
    return torch::tensor({q.x(), q.y(), q.z(), q.w()}).view({1, 4});
  };
  const body::Quat product = a * b.conjugate();
  EXPECT_LT(LargestDifference(Multiply(tensor(a), Conjugate(tensor(b))), tensor(product)), 1e-6);
  const body::Vec3 log = body::Log(product);
  EXPECT_LT(LargestDifference(LogQuaternion(tensor(product)),
                              torch::tensor({log.x(), log.y(), log.z()}).view({1, 3})),
            1e-5);
  EXPECT_LT(LargestDifference(LogQuaternion(-tensor(product)), LogQuaternion(tensor(product))),
            1e-6);
}

TEST(Geometry, ARotationIsMadeAsManyTimesAsLarge) {
  const Eigen::Quaterniond third(Eigen::AngleAxisd(0.4, Eigen::Vector3d(1, 2, -2) / 3.0));
  const Eigen::Quaterniond whole(Eigen::AngleAxisd(1.2, Eigen::Vector3d(1, 2, -2) / 3.0));
  const auto tensor = [](const Eigen::Quaterniond& q) {
    return torch::tensor({q.x(), q.y(), q.z(), q.w()}, torch::kFloat64);
  };
  const Tensor factor = torch::full({1}, 3.0, torch::kFloat64);
  EXPECT_TRUE(torch::allclose(ScaleRotation(tensor(third), factor), tensor(whole)));
  EXPECT_TRUE(torch::allclose(ScaleRotation(-tensor(third), factor), tensor(whole)));
  const Tensor none = tensor(Eigen::Quaterniond::Identity());
  EXPECT_TRUE(torch::allclose(ScaleRotation(none, factor), none));
}

TEST(Geometry, AQuaternionIsFlippedToItsReferencesSide) {
  torch::manual_seed(5);
  const Tensor q = torch::randn({30, 4}), reference = torch::randn({30, 4});
  const Tensor out = ToHemisphere(q, reference);
  int flipped = 0;
  for (int64_t i = 0; i < 30; ++i) {
    const bool away = q[i].dot(reference[i]).item<double>() < 0;
    EXPECT_TRUE(torch::equal(out[i], away ? -q[i] : q[i])) << i;
    flipped += away ? 1 : 0;
  }
  EXPECT_GT(flipped, 5);
}

TEST(Geometry, HalfAngleFollowsArccosAndStaysDifferentiableAtZero) {
  for (const float angle_rad : {0.02F, 0.2F, 0.8F}) {
    const body::Quat q = body::Exp(body::Vec3(angle_rad, 0, 0));
    const Tensor value = SquaredHalfAngle(torch::tensor({q.x(), 0.0F, 0.0F, q.w()}),
                                          torch::tensor({0.0F, 0.0F, 0.0F, 1.0F}));
    EXPECT_NEAR(value.item<double>(), angle_rad * angle_rad / 4, 2e-3 * angle_rad * angle_rad);
  }
  Tensor same = torch::tensor({0.0F, 0.0F, 0.0F, 1.0F}).requires_grad_(true);
  (SquaredHalfAngle(same, same.detach()) + LogQuaternion(same).sum()).backward();
  EXPECT_TRUE(torch::isfinite(same.grad()).all().item<bool>());
}

}  // namespace
}  // namespace styled::train
