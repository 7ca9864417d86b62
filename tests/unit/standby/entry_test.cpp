// Poses that differ in their last bits, as on processors of another make, and poses that differ.
#include "daemon/log/entry.h"

#include <gtest/gtest.h>

#include <limits>
#include <numbers>
#include <random>

namespace styled::log {
namespace {

using decide::FrameInTransit;

FrameInTransit Styled(std::uint32_t crc, std::span<const std::byte> rounded_pose) {
  FrameInTransit frame;
  frame.decision.fate = v1::FATE_STYLED;
  frame.decision.sequence = 7;
  frame.styled_crc = crc;
  frame.rounded_pose = rounded_pose;
  return frame;
}

// A random pose.
body::Pose PoseOf(unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<float> number;
  body::Pose pose;
  for (auto& rotation : pose.rotations) {
    rotation = body::Quat(number(random), number(random), number(random), number(random));
    rotation.normalize();
  }
  pose.hips_position_m = {3 * number(random), 1, 3 * number(random)};
  return pose;
}

// With one joint turned further.
body::Pose Turned(body::Pose pose, std::size_t joint, double degrees) {
  const auto angle = static_cast<float>(degrees * std::numbers::pi / 180);
  pose.rotations[joint] = pose.rotations[joint] *
                          body::Quat(Eigen::AngleAxisf(angle, body::Vec3(1, 2, 3).normalized()));
  return pose;
}

TEST(RoundedPoseTest, APoseEqualsItselfAndItsRoundingDifferences) {
  for (unsigned seed = 1; seed <= 50; ++seed) {
    const body::Pose pose = PoseOf(seed);
    body::Pose near = pose;
    for (auto& rotation : near.rotations) {
      for (float& number : rotation.coeffs()) number = std::nextafter(number, 2.0F);
    }
    near.hips_position_m *= 1.000001F;
    EXPECT_FALSE(AreApart(Rounded(pose), Rounded(pose)));
    EXPECT_FALSE(AreApart(Rounded(pose), Rounded(near))) << seed;
  }
}

TEST(RoundedPoseTest, AJointIsApartBeyondTheAngleAndNotBelowIt) {
  for (std::size_t joint = 0; joint < body::kJointCount; ++joint) {
    const body::Pose pose = PoseOf(static_cast<unsigned>(joint) + 1);
    EXPECT_FALSE(AreApart(Rounded(pose), Rounded(Turned(pose, joint, 0.08)))) << joint;
    EXPECT_TRUE(AreApart(Rounded(pose), Rounded(Turned(pose, joint, 0.12)))) << joint;
    EXPECT_TRUE(AreApart(Rounded(pose), Rounded(Turned(pose, joint, 180)))) << joint;
  }
}

TEST(RoundedPoseTest, ANegatedQuaternionIsTheSameRotation) {
  const body::Pose pose = PoseOf(1);
  body::Pose other = pose;
  for (auto& rotation : other.rotations) rotation.coeffs() *= -1;
  EXPECT_FALSE(AreApart(Rounded(pose), Rounded(other)));
}

TEST(RoundedPoseTest, MovedHipsAreApart) {
  body::Pose pose = PoseOf(1), near = pose, far = pose;
  near.hips_position_m.x() += 0.0018F;
  far.hips_position_m.z() += 0.0022F;
  EXPECT_FALSE(AreApart(Rounded(pose), Rounded(near)));
  EXPECT_TRUE(AreApart(Rounded(pose), Rounded(far)));
}

TEST(RoundedPoseTest, InvalidNumbersAreRounded) {
  body::Pose pose = PoseOf(1);
  pose.hips_position_m = {std::numeric_limits<float>::quiet_NaN(), 1e30F, -1e30F};
  pose.rotations[3].coeffs().setConstant(std::numeric_limits<float>::infinity());
  const RoundedPose rounded = Rounded(pose);
  EXPECT_EQ(rounded.hips[0], 0);
  EXPECT_EQ(rounded.hips[1], std::numeric_limits<std::int32_t>::max());
  EXPECT_TRUE(AreApart(rounded, Rounded(PoseOf(1))));
  EXPECT_TRUE(AreApart(RoundedPose(), RoundedPose())) << "no rotation at all";
}

TEST(CompareTest, FatesThenBitsThenPosesAreCompared) {
  const RoundedPose pose = Rounded(PoseOf(1)), other = Rounded(PoseOf(2));
  const auto bytes = [](const RoundedPose& of) { return std::as_bytes(std::span(&of, 1)); };
  const FrameInTransit here = Styled(0x11, bytes(pose));
  FrameInTransit there = here;
  EXPECT_EQ(Compare(here, there), Comparison::kSame);
  there.styled_crc = 0x12;
  EXPECT_EQ(Compare(here, there), Comparison::kLastBits);
  there.rounded_pose = bytes(other);
  EXPECT_EQ(Compare(here, there), Comparison::kApart);
  there.rounded_pose = bytes(pose).first(7);
  EXPECT_EQ(Compare(here, there), Comparison::kApart);
  there.rounded_pose = {};
  EXPECT_EQ(Compare(here, there), Comparison::kApart);
  there = here;
  there.decision.fate = v1::FATE_PASSED_OVER;
  EXPECT_EQ(Compare(here, there), Comparison::kApart);
}

TEST(EntryTest, TheJournalContainsTheRoundedPose) {
  const RoundedPose pose = Rounded(PoseOf(1));
  source::SourceFrame frame, read;
  frame.performer = "a";
  v1::Handled entry;
  const auto bytes = std::as_bytes(std::span(&pose, 1));
  FrameInTransit written = Styled(0x11, bytes), back;
  written.given = &frame;
  Write(written, entry);
  ASSERT_TRUE(Read(entry, read, back));
  EXPECT_EQ(back.rounded_pose.size(), sizeof pose);
  EXPECT_EQ(Compare(Styled(0x12, bytes), back), Comparison::kLastBits);
}

// A leader's line is one line of the standby's log, whatever it contains.
TEST(EntryTest, TheJournalContainsWhyABodyIsRefused) {
  const auto read = [](const char* refusal) -> std::string {
    source::SourceFrame body, copy;
    body.is_body = true;
    if (refusal != nullptr) body.refusal = std::make_shared<const std::string>(refusal);
    FrameInTransit transit;
    transit.given = &body;
    v1::Handled entry;
    Write(transit, entry);
    EXPECT_TRUE(Read(entry, copy, transit));
    return copy.refusal == nullptr ? "none" : *copy.refusal;
  };
  EXPECT_EQ(read(nullptr), "none");
  EXPECT_EQ(read("VMC sends no leg bones"), "VMC sends no leg bones");
  EXPECT_EQ(read("a\nb"), "a\\nb");
}

}  // namespace
}  // namespace styled::log
