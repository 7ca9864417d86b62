#include <gtest/gtest.h>

#include <cmath>

#include "tests/unit/body/random_pose.h"
#include "tests/unit/clip/motion.h"

namespace styled::clip {
namespace {

using body::Angle_rad;
using body::Random;
using rig::Quat;
using rig::Vec3;

TEST(Resample, OfNoFramesOrOneGivesNoneOrOne) {
  EXPECT_TRUE(Resample(Waving(30, 0), 120).frames.empty());
  ASSERT_EQ(Resample(Waving(30, 1), 120).frames.size(), 1U);
  EXPECT_TRUE(ResamplePoses({}, 30, 120).empty());
  EXPECT_EQ(ResamplePoses(std::vector<body::Pose>(1), 30, 120).size(), 1U);
}

TEST(Resample, OfTwoFramesIsTheLineBetweenThem) {
  const Clip two = Waving(30, 2);
  const Clip fine = Resample(two, 60);
  ASSERT_EQ(fine.frames.size(), 3U);
  const Vec3 middle = 0.5F * (two.frames[0].translations[0] + two.frames[1].translations[0]);
  EXPECT_TRUE(fine.frames[1].translations[0].isApprox(middle, 1e-6F));
}

TEST(Resample, KeepsTheDurationAtAnyRate) {
  const Clip clip = Waving(30, 91);  // 3 s
  for (double rate_hz : {24.0, 25.0, 29.97, 30.0, 48.0, 60.0, 90.0, 100.0, 119.88, 120.0, 240.0}) {
    const Clip out = Resample(clip, rate_hz);
    EXPECT_EQ(out.rate_hz, rate_hz);
    EXPECT_EQ(out.frames.size(), static_cast<std::size_t>(std::floor(3 * rate_hz + 1e-9)) + 1)
        << rate_hz;
    EXPECT_EQ(out.skeleton, clip.skeleton);
    EXPECT_EQ(out.channels, clip.channels);
    EXPECT_EQ(out.end_sites, clip.end_sites);
  }
}

TEST(Resample, KeepsTheOriginalFramesWhereTheTimesCoincide) {
  const Clip clip = Waving(30, 50);
  for (int times : {1, 2, 4}) {
    const Clip out = Resample(clip, 30.0 * times);
    for (std::size_t frame = 0; frame < clip.frames.size(); ++frame) {
      for (int joint = 0; joint < 2; ++joint) {
        EXPECT_EQ(out.frames[frame * times].translations[joint],
                  clip.frames[frame].translations[joint]);
        EXPECT_LT(Angle_rad(out.frames[frame * times].rotations[joint],
                            clip.frames[frame].rotations[joint]),
                  1e-6);
      }
    }
  }
  const Clip down = Resample(clip, 10);
  for (std::size_t frame = 0; frame < down.frames.size(); ++frame) {
    EXPECT_EQ(down.frames[frame].translations[0], clip.frames[3 * frame].translations[0]);
  }
}

TEST(Resample, ComesCloseToTheMotionBetweenTheFrames) {
  const Clip out = Resample(Waving(30, 91), 120);
  for (std::size_t frame = 20; frame + 20 < out.frames.size(); ++frame) {  // ends are stiffer
    const rig::RigPose truth = At(static_cast<double>(frame) / 120);
    EXPECT_LT((out.frames[frame].translations[0] - truth.translations[0]).norm(), 0.01);  // cm
    for (int joint = 0; joint < 2; ++joint) {
      EXPECT_LT(Angle_rad(out.frames[frame].rotations[joint], truth.rotations[joint]), 5e-4);
    }
  }
}

TEST(Resample, LeavesTranslationsThatNeverChangeExactlyAsTheyAre) {
  for (const rig::RigPose& pose : Resample(Waving(30, 20), 97).frames) {
    EXPECT_EQ(pose.translations[1], Vec3(0.1F, 17.3F, 0.7F));
  }
}

// The reason for splines: the largest jump of angular velocity between neighbouring 120 Hz frames.
double LargestVelocityStep(const std::vector<Quat>& rotations) {
  double largest = 0;
  Vec3 last = Vec3::Zero();
  for (std::size_t i = 1; i < rotations.size(); ++i) {
    const Vec3 velocity =
        120 * body::Log((rotations[i - 1].conjugate() * rotations[i]).normalized());
    if (i > 1) largest = std::max<double>(largest, (velocity - last).norm());
    last = velocity;
  }
  return largest;
}

TEST(Resample, IsSmoothWhereSlerpHasKinks) {
  const Clip clip = Waving(30, 91);
  std::vector<Quat> truth, spline, slerp;
  const Clip out = Resample(clip, 120);
  for (std::size_t frame = 0; frame < out.frames.size(); ++frame) {
    truth.push_back(At(static_cast<double>(frame) / 120).rotations[1]);
    spline.push_back(out.frames[frame].rotations[1]);
    const std::size_t at = frame / 4, next = std::min<std::size_t>(at + 1, 90);
    slerp.push_back(clip.frames[at].rotations[1].slerp(0.25F * static_cast<float>(frame % 4),
                                                       clip.frames[next].rotations[1]));
  }
  const double true_step = LargestVelocityStep(truth);
  EXPECT_LT(LargestVelocityStep(spline), 1.2 * true_step);
  EXPECT_GT(LargestVelocityStep(slerp), 3 * true_step) << "the control: slerp must fail this";
}

TEST(Resample, DoesNotMindSignsThatFlipBetweenFrames) {
  Clip clip = Waving(30, 60), flipped = clip;
  for (std::size_t frame = 0; frame < clip.frames.size(); frame += 3) {
    for (Quat& q : flipped.frames[frame].rotations) q.coeffs() *= -1;
  }
  const Clip a = Resample(clip, 120), b = Resample(flipped, 120);
  for (std::size_t frame = 0; frame < a.frames.size(); ++frame) {
    EXPECT_LT(Angle_rad(a.frames[frame].rotations[1], b.frames[frame].rotations[1]), 1e-6);
    if (frame > 0) {
      EXPECT_GT(b.frames[frame].rotations[1].dot(b.frames[frame - 1].rotations[1]), 0.9F);
    }
  }
}

TEST(ResamplePoses, AgreesWithResamplingTheClip) {
  Random random(1);
  Clip clip;
  for (int c = 0; c < body::kJointCount; ++c) {
    clip.skeleton.names.emplace_back(body::kHumanoid[c].name);
    clip.skeleton.parents.push_back(body::kHumanoid[c].parent);
    clip.skeleton.offsets.push_back(body::Offset(c));
  }
  std::vector<body::Pose> poses;
  body::Pose pose;
  for (int frame = 0; frame < 40; ++frame) {
    pose.hips_position_m += random.Vector(0.02F);
    for (Quat& q : pose.rotations) q = (q * random.Turn(0.1F)).normalized();
    poses.push_back(pose);
    rig::RigPose rig_pose(clip.skeleton);
    rig_pose.translations[0] = pose.hips_position_m;
    std::copy(pose.rotations.begin(), pose.rotations.end(), rig_pose.rotations.begin());
    clip.frames.push_back(rig_pose);
  }
  const std::vector<body::Pose> a = ResamplePoses(poses, 30, 72);
  const Clip b = Resample(clip, 72);
  ASSERT_EQ(a.size(), b.frames.size());
  for (std::size_t frame = 0; frame < a.size(); ++frame) {
    EXPECT_LT((a[frame].hips_position_m - b.frames[frame].translations[0]).norm(), 1e-6);
    for (int joint = 0; joint < body::kJointCount; ++joint) {
      EXPECT_LT(Angle_rad(a[frame].rotations[joint], b.frames[frame].rotations[joint]), 1e-6);
    }
  }
}

}  // namespace
}  // namespace styled::clip
