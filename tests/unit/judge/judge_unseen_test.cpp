#include "model/train/judge/judge_unseen.h"

#include <gtest/gtest.h>

#include "model/body/heading.h"

namespace styled::judge {
namespace {

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
    to[i].rotations[body::kLeftUpperArm] = lift;
    if (i % 2 == 1) to[i].rotations[body::kLeftUpperArm].coeffs() *= -1;  // the same rotation
  }
  const ConstantOffset offset = OffsetBetween(from, to);
  EXPECT_LT(body::Log(offset.offset[body::kChest] * bend.conjugate()).norm(), 1e-4F);
  EXPECT_LT(body::Log(offset.offset[body::kLeftUpperArm] * lift.conjugate()).norm(), 1e-4F);
  EXPECT_LT(body::Log(offset.offset[body::kHips]).norm(), 1e-4F);
  EXPECT_LT(body::Log(offset.offset[body::kRightUpperLeg]).norm(), 1e-4F);
}

}  // namespace
}  // namespace styled::judge
