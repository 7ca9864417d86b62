#include "model/net/offset/stylizer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "model/net/load.h"
#include "tests/support/temporary_folder.h"
#include "tests/unit/body/random_pose.h"
#include "tests/unit/net/offset/weights.h"

namespace styled::offset {
namespace {

using testing::HasSubstr;

constexpr double kClose_rad = 1e-5;

class Offset : public testing::Test {
 protected:
  Result<std::shared_ptr<const net::Stylizer>> LoadOf(const std::vector<Offsets>& offsets) {
    const std::filesystem::path file = folder_ / "offset.safetensors";
    const Status status = Write(file, TestModel(), offsets);
    EXPECT_TRUE(status.ok()) << status.message();
    return net::Load(file);
  }
  // The prediction in `styles` for a pose in `input_style`.
  static net::Prediction Step(const net::Stylizer& stylizer, const body::Pose& pose,
                              std::vector<net::StyleWeight> styles, int input_style = 0) {
    const std::unique_ptr<net::Stream> stream = stylizer.MakeStream();
    stylizer.Start(*stream);
    net::Prediction out;
    const net::StepJob job{&pose, input_style, styles, stream.get(), &out};
    stylizer.Step({&job, 1});
    return out;
  }
  // The rotation vector of a joint from the input to the styled pose, in the joint's own axes.
  static body::Vec3 Turn(const net::Prediction& out, const body::Pose& pose, int joint) {
    const auto j = static_cast<std::size_t>(joint);
    return body::Log(pose.rotations[j].conjugate() * out.styled.rotations[j]);
  }

  support::TemporaryFolder folder_;
  body::Random random_{1};
  body::Pose pose_ = random_.AnyPose();
};

TEST_F(Offset, AWrittenFileIsReadAsItsFamily) {
  const auto loaded = LoadOf(TestOffsets());
  ASSERT_TRUE(loaded.ok()) << loaded.status().message();
  const net::Model& model = loaded.value()->model();
  EXPECT_EQ(model.family, "constant-offset");
  EXPECT_EQ(model.styles[1].name, "bent");
  EXPECT_THAT(model.styles[1].aliases, testing::ElementsAre("stooped"));
  EXPECT_EQ(model.rate_hz, 30);
  EXPECT_EQ(model.licence, "CC0-1.0");
}

TEST_F(Offset, AStyleTurnsItsJointsAndNoOthers) {
  const auto stylizer = LoadOf(TestOffsets()).value();
  for (int round = 0; round < 20; ++round) {
    const body::Pose pose = random_.AnyPose();
    const net::Prediction out = Step(*stylizer, pose, {{1, 1.0F}});
    for (int joint = 0; joint < body::kJointCount; ++joint) {
      const auto j = static_cast<std::size_t>(joint);
      EXPECT_EQ(out.reconstruction.rotations[j].coeffs(), pose.rotations[j].coeffs());
      const body::Vec3 expected(joint == body::kSpine ? kBent_rad : 0.0F, 0, 0);
      EXPECT_LT((Turn(out, pose, joint) - expected).norm(), kClose_rad) << joint;
    }
  }
}

TEST_F(Offset, WeightsScaleAddAndAreClamped) {
  const auto stylizer = LoadOf(TestOffsets()).value();
  const auto bent = [&](std::vector<net::StyleWeight> styles) {
    return Turn(Step(*stylizer, pose_, std::move(styles)), pose_, body::kSpine).x();
  };
  EXPECT_NEAR(bent({{1, 0.5F}}), 0.5F * kBent_rad, kClose_rad);
  EXPECT_NEAR(bent({{1, 0.25F}, {1, 0.5F}}), 0.75F * kBent_rad, kClose_rad);
  EXPECT_NEAR(bent({{1, 99.0F}}), 1.5F * kBent_rad, kClose_rad);
  EXPECT_NEAR(bent({{1, -1.0F}}), 0, kClose_rad);
  EXPECT_NEAR(bent({{1, std::numeric_limits<float>::quiet_NaN()}}), 0, kClose_rad);
  EXPECT_NEAR(bent({{0, 1.0F}, {7, 1.0F}, {-1, 1.0F}}), 0, kClose_rad);
  const net::Prediction mixed = Step(*stylizer, pose_, {{1, 1.0F}, {2, 0.5F}});
  EXPECT_NEAR(Turn(mixed, pose_, body::kSpine).x(), kBent_rad, kClose_rad);
  EXPECT_NEAR(Turn(mixed, pose_, body::kLeftUpperArm).z(), 0.5F * kRaised_rad, kClose_rad);
}

TEST_F(Offset, TheStyleOfTheInputIsTakenAway) {
  const auto stylizer = LoadOf(TestOffsets()).value();
  EXPECT_NEAR(Turn(Step(*stylizer, pose_, {}, 1), pose_, body::kSpine).x(), -kBent_rad, kClose_rad);
  EXPECT_NEAR(Turn(Step(*stylizer, pose_, {{1, 1.0F}}, 1), pose_, body::kSpine).x(), 0, kClose_rad);
}

TEST_F(Offset, RotationsThatAreNoneAreRefused) {
  std::vector<Offsets> offsets = TestOffsets();
  offsets[2][body::kHead].coeffs().setConstant(0.6F);
  EXPECT_THAT(LoadOf(offsets).status().message(),
              HasSubstr("tensor 'offset.rotation': expected a rotation of length 1 for head, found "
                        "one of length 1.2"));
  offsets[2][body::kHead].coeffs().setConstant(std::numeric_limits<float>::infinity());
  EXPECT_THAT(LoadOf(offsets).status().message(), HasSubstr("expected finite values, found inf"));
}

}  // namespace
}  // namespace styled::offset
