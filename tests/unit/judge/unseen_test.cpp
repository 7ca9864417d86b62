#include "model/train/judge/unseen.h"

#include <gtest/gtest.h>

#include "model/body/heading.h"
#include "model/train/judge/unseen_live.h"
#include "tests/unit/judge/arm_network.h"
#include "tests/unit/train/walker.h"

namespace styled::judge {
namespace {

float Angle_rad(const body::Quat& a, const body::Quat& b) {
  return body::Log(a * b.conjugate()).norm();
}

TEST(Unseen, TheOffsetIsTheTurnOfEachJointWhereverTheClipsHead) {
  Poses from(7);
  Poses to(5);
  const body::Quat bend = body::Exp(body::Vec3(0.4F, 0, 0));
  const body::Quat lift = body::Exp(body::Vec3(0, 0, 0.7F));
  for (std::size_t i = 0; i < from.size(); ++i) {
    from[i].rotations[body::kHips] = body::Yaw(0.3F * static_cast<float>(i));
  }
  for (std::size_t i = 0; i < to.size(); ++i) {
    to[i].rotations[body::kHips] = body::Yaw(-2.0F);
    to[i].rotations[body::kChest] = bend;
    const float sway_rad = 0.1F * (static_cast<float>(i) - 2);  // about the third frame
    to[i].rotations[body::kSpine] = body::Exp(body::Vec3(0.3F + sway_rad, 0, 0));
    to[i].rotations[body::kLeftUpperArm] = lift;
    if (i % 2 == 1) to[i].rotations[body::kLeftUpperArm].coeffs() *= -1;  // the same rotation
  }
  const ConstantOffset offset = OffsetBetween(from, to);
  EXPECT_LT(Angle_rad(offset.offset[body::kChest], bend), 1e-4F);
  EXPECT_LT(Angle_rad(offset.offset[body::kLeftUpperArm], lift), 1e-4F);
  const body::Quat mean = body::Exp(body::Vec3(0.3F, 0, 0));
  EXPECT_LT(Angle_rad(offset.offset[body::kSpine], mean), 1e-3F);
  EXPECT_LT(body::Log(offset.offset[body::kHips]).norm(), 1e-4F);
  EXPECT_LT(body::Log(offset.offset[body::kRightUpperLeg]).norm(), 1e-4F);
}

// The arms of a Walker swing, so that its mean rotations are no frame's and differ from identity.
TEST(Unseen, TheOffsetOfMotionToItselfIsNoneAndToItselfTurnedIsTheTurn) {
  const Poses walk = train::Walker(90).poses;
  for (const body::Quat& none : OffsetBetween(walk, walk).offset) {
    EXPECT_LT(body::Log(none).norm(), 1e-3F);
  }
  const auto turn = [](int joint) {
    const float size = 0.03F * static_cast<float>(joint);
    return body::Exp(body::Vec3(size, -0.5F * size, 0.2F));
  };
  Poses turned = walk;
  for (body::Pose& pose : turned) {
    for (int joint = body::kHips + 1; joint < body::kJointCount; ++joint) {
      pose.rotations[joint] = pose.rotations[joint] * turn(joint);
    }
  }
  const ConstantOffset offset = OffsetBetween(walk, turned);
  const ConstantOffset back = OffsetBetween(turned, walk);
  // Not of the hips: the turns change the heading that theirs is relative to.
  for (int joint = body::kHips + 1; joint < body::kJointCount; ++joint) {
    EXPECT_LT(Angle_rad(offset.offset[joint], turn(joint)), 1e-3F) << joint;
    EXPECT_LT(Angle_rad(back.offset[joint], turn(joint).conjugate()), 1e-3F) << joint;
  }
}

// A performer whose left arm hangs at kNormal_rad in both normal clips and at kExample_rad in the
// example, which heads another way.
struct UnseenTest : testing::Test {
  static constexpr float kNormal_rad = ArmHabits::kDeaf_rad;
  static constexpr float kExample_rad = 0.9F;
  Poses source = train::Walker(120).poses;
  Poses normal = train::Walker(130).poses;
  Poses example = train::Walker(130).poses;

  void SetUp() override {
    SetArm(source, kNormal_rad);
    SetArm(normal, kNormal_rad);
    SetArm(example, kExample_rad);
    for (body::Pose& pose : example) {
      pose.rotations[body::kHips] = body::Yaw(1.2F) * pose.rotations[body::kHips];
    }
  }
  UnseenFigures Measured(float share) const {
    const auto network = std::make_shared<ArmNetwork>(ArmHabits{.share = share});
    const ClipRestyler restyler(network, {}, {}, {});
    return MeasureUnseen(ByCodeOf(restyler), source, normal, example);
  }
};

TEST_F(UnseenTest, ANetworkThatDoesNothingExpressesNothing) {
  const UnseenFigures figures = Measured(0);
  EXPECT_NEAR(figures.network.fraction, 0, 1e-3);
  EXPECT_NEAR(figures.offset.fraction, 1, 0.02) << "the offset does not ask the network";
  EXPECT_NEAR(figures.offset.cosine, 1, 0.01);
}

TEST_F(UnseenTest, ANetworkThatMakesTheExamplesShiftExpressesAllOfIt) {
  const UnseenFigures figures = Measured(1);
  EXPECT_NEAR(figures.network.fraction, 1, 0.02);
  EXPECT_NEAR(figures.network.cosine, 1, 0.01);
  EXPECT_EQ(figures.nearest.style, 2);
  EXPECT_NEAR(figures.nearest.distance, (1 - kExample_rad) / 0.5F, 1e-4F);
}

TEST_F(UnseenTest, HalfOfTheShiftAndItsOppositeAreToldApart) {
  EXPECT_NEAR(Measured(0.5F).network.fraction, 0.5, 0.05);
  EXPECT_GT(Measured(0.5F).network.cosine, 0.97);
  EXPECT_NEAR(Measured(-1).network.fraction, -1, 0.2);
  EXPECT_LT(Measured(-1).network.cosine, -0.9);
}

TEST_F(UnseenTest, TheShiftIsThatFromTheSourceWhereverTheSourceBegins) {
  SetArm(source, kExample_rad);  // the network leaves it there, the offset lifts it further
  const UnseenFigures figures = Measured(1);
  EXPECT_NEAR(figures.network.fraction, 0, 1e-3);
  EXPECT_GT(figures.offset.fraction, 0.8);
}

// The example's arm swings, too.
TEST_F(UnseenTest, MovementIsMeasuredBesideTheMeanPoseAndWithoutTheBeginning) {
  for (std::size_t i = 0; i < example.size(); ++i) {
    example[i].rotations[body::kLeftUpperArm] =
        Arm(kExample_rad + 0.5F * std::sin(0.4F * static_cast<float>(i)));
  }
  const ArmNetwork network({});
  const auto measured = [&](Poses output) {
    for (std::size_t i = 0; i < kSettling; ++i) {
      output[i].rotations[body::kLeftUpperArm] = Arm(-1.5F);
    }
    const ByCode by_code{network, [&](const Poses&, const net::StyleCode&) { return output; }};
    return MeasureLiveUnseen(by_code, {}, normal, normal, example, nullptr, 1);
  };
  const LiveUnseenFigures same = measured(example);
  EXPECT_NEAR(same.network.fraction, 1, 0.1);
  EXPECT_GT(same.network.cosine, 0.95);
  EXPECT_LT(same.movement, 0.2);
  EXPECT_GT(same.jerk, 1) << "of the arm's swing";
  const LiveUnseenFigures none = measured(normal);
  EXPECT_NEAR(none.network.fraction, 0, 1e-3);
  EXPECT_NEAR(none.movement, 1, 1e-3);
  EXPECT_NEAR(none.jerk, 1, 1e-3);
  EXPECT_NEAR(none.offset.fraction, 1, 0.1);
  // A lifted arm moves a little otherwise with the body, but it does not swing.
  EXPECT_GT(none.offset_movement, 0.5);
  EXPECT_EQ(none.recognized.count, 0) << "without judges";
}

// Stores the requests for a code.
class AskedArm final : public ArmNetwork {
 public:
  AskedArm() : ArmNetwork({}) {}
  net::StyleCode MakeCode(const net::StyleRequest& request) const override {
    requests.push_back(request);
    return ArmNetwork::MakeCode(request);
  }
  mutable std::vector<net::StyleRequest> requests;
};

TEST_F(UnseenTest, TheNetworkSeesTheWholeExampleAndNoLabel) {
  const auto network = std::make_shared<AskedArm>();
  const ClipRestyler restyler(network, {}, {}, {});
  MeasureUnseen(ByCodeOf(restyler), source, normal, example);
  ASSERT_EQ(network->requests.size(), 1U);
  ASSERT_EQ(network->requests[0].sources.size(), 1U);
  const net::StyleSource& asked = network->requests[0].sources[0];
  EXPECT_EQ(asked.style, -1);
  EXPECT_FALSE(asked.seed);
  EXPECT_EQ(asked.weight, 1);
  EXPECT_EQ(asked.reference.data(), example.data());
  EXPECT_EQ(asked.reference.size(), example.size());
}

}  // namespace
}  // namespace styled::judge
