#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "daemon/source/rigs/qtm_skeleton.h"
#include "sim/rigs/qtm_skeleton.h"
#include "tests/unit/qtm/decode_cases.h"

namespace styled::source {
namespace {

using ::testing::HasSubstr;

std::string Refusal(const qtm::SkeletonDescription& description) {
  const auto made = QtmSkeleton::Make(description, qtm::Axis::kZ);
  return made.ok() ? "" : made.status().message();
}

TEST(QtmSkeleton, IsRefusedWithWhatWasExpected) {
  EXPECT_EQ(Refusal({"a", false, {}}), "skeleton a: found no segments, expected one root at least");
  EXPECT_EQ(Refusal({"a", false, {{"Hips", 1}, {"Hips2", 2}}}),
            "skeleton a: found several roots, expected one");
  EXPECT_EQ(Refusal({"a", false, {{"Hips", 1}, {"Hips", 2, 0}}}),
            "skeleton a: segment Hips: its name, or its ID 2, is another's");
  EXPECT_EQ(Refusal({"a", false, {{"Hips", 1}, {"Spine", 1, 0}}}),
            "skeleton a: segment Spine: its name, or its ID 1, is another's");
  EXPECT_EQ(Refusal({"a", false, {{"Hips", 1, -1, {}, {0, 0, 0, 0}}}}),
            "skeleton a: segment Hips: its T-pose has no valid rotation");
  qtm::SkeletonDescription many{"a", false, {{"Hips", 0}}};
  for (std::uint32_t s = 1; s <= qtm::kMaxSegments; ++s) {
    many.segments.push_back({"s" + std::to_string(s), s, 0});
  }
  EXPECT_EQ(Refusal(many), "skeleton a: found 129 segments, expected at most 128");
  many.segments.pop_back();
  many.segments_left_out = 7;
  EXPECT_EQ(Refusal(many), "skeleton a: found 135 segments, expected at most 128");
}

TEST(QtmSkeleton, EveryAxisBecomesYUp) {
  const std::array<rig::Vec3, 6> axes{rig::Vec3(1, 0, 0),  rig::Vec3(0, 1, 0),
                                      rig::Vec3(0, 0, 1),  rig::Vec3(-1, 0, 0),
                                      rig::Vec3(0, -1, 0), rig::Vec3(0, 0, -1)};
  for (std::size_t a = 0; a < axes.size(); ++a) {
    const rig::Quat turn = YUpFrom(static_cast<qtm::Axis>(a));
    EXPECT_LT((turn * axes[a] - rig::Vec3(0, 1, 0)).norm(), 1e-6F) << a;
    EXPECT_NEAR(turn.norm(), 1, 1e-6F) << a;
  }
}

// Both forms describe the same skeleton.
TEST(QtmSkeleton, IsTheSameOfTheNestedAndTheFlatForm) {
  const auto nested =
      QtmSkeleton::Make(rigs::DescribeQtmSkeleton("a", 1, true, false), qtm::Axis::kZ);
  const auto flat = QtmSkeleton::Make(rigs::DescribeQtmSkeleton("a", 1, true, true), qtm::Axis::kZ);
  ASSERT_TRUE(nested.ok() && flat.ok());
  const rig::RigBody &a = nested.value().body(), &b = flat.value().body();
  EXPECT_EQ(a.skeleton.names, b.skeleton.names);
  EXPECT_EQ(a.skeleton.parents, b.skeleton.parents);
  ASSERT_EQ(a.rest.size(), b.rest.size());
  for (std::size_t j = 0; j < a.rest.size(); ++j) {
    EXPECT_LT((a.skeleton.offsets[j] - b.skeleton.offsets[j]).norm(), 0.01F) << j << ", mm";
    EXPECT_LT(a.rest[j].angularDistance(b.rest[j]), 1e-4F) << j;
  }
  EXPECT_NEAR(a.metres_per_unit, 0.001F, 1e-9F);
}

class ConvertTest : public testing::Test {
 protected:
  void SetUp() override {
    auto made = QtmSkeleton::Make({"a", false, {{"Hips", 10}, {"Spine", 11, 0}, {"Head", 12, 1}}},
                                  qtm::Axis::kZ);
    ASSERT_TRUE(made.ok());
    skeleton_ = std::move(made.value());
    pose_ = rig::RigPose(skeleton_.body().skeleton);
    segments_->segment_count = 3;
    for (std::uint32_t s = 0; s < 3; ++s) {
      segments_->segments[s] = {10 + s, {100.0F, 200, 300}, {0, 0, 0.6F, 0.8F}};
    }
  }
  QtmSkeleton skeleton_;
  rig::RigPose pose_;
  std::unique_ptr<qtm::SkeletonPose> segments_ = std::make_unique<qtm::SkeletonPose>();
};

TEST_F(ConvertTest, TurnsTheRootAloneToYUp) {
  ASSERT_TRUE(skeleton_.Convert(*segments_, pose_));
  EXPECT_LT((pose_.translations[0] - rig::Vec3(100, 300, -200)).norm(), 1e-3F);
  // About +Z by QTM, so about +Y here.
  EXPECT_LT((pose_.rotations[0] * rig::Vec3(0, 0, 1) -
             YUpFrom(qtm::Axis::kZ) * rig::Quat(0.8F, 0, 0, 0.6F) * rig::Vec3(0, 0, 1))
                .norm(),
            1e-5F);
  EXPECT_LT(pose_.rotations[1].angularDistance(rig::Quat(0.8F, 0, 0, 0.6F)), 1e-4F);
}

TEST_F(ConvertTest, FindsSegmentsByTheirIdInAnyOrder) {
  std::swap(segments_->segments[0], segments_->segments[2]);
  segments_->segments[2].position_mm = {1, 2, 3};
  ASSERT_TRUE(skeleton_.Convert(*segments_, pose_));
  EXPECT_LT((pose_.translations[0] - rig::Vec3(1, 3, -2)).norm(), 1e-4F);
}

TEST_F(ConvertTest, WhatIsMissingOrNotTrackedIsNan) {
  const float nan = std::nanf("");
  segments_->segments[1].rotation = {nan, nan, nan, nan};
  segments_->segment_count = 2;
  ASSERT_TRUE(skeleton_.Convert(*segments_, pose_));
  EXPECT_TRUE(pose_.rotations[0].coeffs().allFinite());
  EXPECT_TRUE(std::isnan(pose_.rotations[1].w()));
  EXPECT_TRUE(std::isnan(pose_.rotations[2].w()));
  const rig::Vec3 before = pose_.translations[0];
  segments_->segments[0].position_mm = {nan, nan, nan};
  ASSERT_TRUE(skeleton_.Convert(*segments_, pose_));
  EXPECT_TRUE(std::isnan(pose_.rotations[0].w()));
  EXPECT_EQ(pose_.translations[0], before) << "the last place that was seen";
  segments_->segments[0] = {10, {1e30F, INFINITY, 0}, {0, 0, 0, 0}};
  ASSERT_TRUE(skeleton_.Convert(*segments_, pose_));
  EXPECT_TRUE(std::isnan(pose_.rotations[0].w()));
}

TEST_F(ConvertTest, AnotherSkeletonIsTold) {
  for (std::uint32_t s = 0; s < 3; ++s) segments_->segments[s].id = 500 + s;
  EXPECT_FALSE(skeleton_.Convert(*segments_, pose_));
}

}  // namespace
}  // namespace styled::source
