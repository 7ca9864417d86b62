#include "model/train/dataset.h"

#include <gtest/gtest.h>

#include <fstream>

#include "model/body/heading.h"
#include "model/clip/clip.h"
#include "model/clip/entry_reader.h"
#include "tests/support/temporary_folder.h"
#include "tests/unit/train/walker.h"

namespace styled::train {
namespace {

std::vector<float> Window(const TrainingClip& clip, int start, int length, bool mirrored,
                          bool session_start) {
  std::vector<float> features(static_cast<std::size_t>(length) * erd::kFeatureCount);
  FillWindow(clip, start, length, mirrored, session_start, {}, {.features = features.data()});
  return features;
}

// The same frames, whether the stream is computed as a whole or a window is cut out of it.
TEST(Dataset, AWindowContinuesTheClipsOwnPast) {
  const TrainingClip clip = Walker(60);
  for (const bool mirrored : {false, true}) {
    const std::vector<float> whole = Window(clip, 0, 60, mirrored, false);
    const std::vector<float> part = Window(clip, 20, 25, mirrored, false);
    for (std::size_t i = 0; i < part.size(); ++i) {
      ASSERT_NEAR(part[i], whole[20 * erd::kFeatureCount + i], 2e-4) << i % erd::kFeatureCount;
    }
  }
}

TEST(Dataset, ASessionStartHasNoVelocity) {
  const TrainingClip clip = Walker(60);
  const std::vector<float> started = Window(clip, 20, 3, false, true);
  const std::vector<float> continued = Window(clip, 20, 3, false, false);
  float speed = 0, continued_speed = 0;
  for (int i = erd::kVelocityBegin; i < erd::kHipsHeightIndex; ++i) {
    speed += std::abs(started[i]);
    continued_speed += std::abs(continued[i]);
  }
  EXPECT_EQ(speed, 0.0F);
  EXPECT_GT(continued_speed, 1.0F);  // the control: without the flag the past is there
}

// A window cut out of a badly calibrated clip is what a badly calibrated rig's stream shows there.
TEST(Dataset, AMiscalibratedWindowContinuesAMiscalibratedPast) {
  const TrainingClip clip = Walker(90);
  const Miscalibration wrong = DrawMiscalibration(5);
  const auto window = [&](int start, int length, const Miscalibration* of) {
    std::vector<float> features(static_cast<std::size_t>(length) * erd::kFeatureCount);
    FillWindow(clip, start, length, false, false, {}, {.features = features.data()}, of);
    return features;
  };
  const std::vector<float> whole = window(0, 90, &wrong);
  const std::vector<float> part = window(60, 25, &wrong);
  const std::vector<float> right = window(60, 25, nullptr);
  float most = 0;
  float apart = 0;
  for (std::size_t i = 0; i < part.size(); ++i) {
    most = std::max(most, std::abs(part[i] - whole[60 * erd::kFeatureCount + i]));
    apart = std::max(apart, std::abs(part[i] - right[i]));
  }
  EXPECT_LT(most, 0.05F);  // the heading's error is not quite constant
  EXPECT_GT(apart, 4 * most);
}

TEST(Dataset, AMiscalibrationIsDeterministicAndWithinItsBounds) {
  for (std::uint64_t seed = 1; seed < 50; ++seed) {
    const Miscalibration wrong = DrawMiscalibration(seed);
    const Miscalibration again = DrawMiscalibration(seed);
    EXPECT_EQ(wrong.floor_m, again.floor_m);
    EXPECT_LE(std::abs(wrong.floor_m), 0.1F);
    for (int joint = 0; joint < body::kJointCount; ++joint) {
      EXPECT_LE(body::Log(wrong.rotations[joint]).norm(), 0.2619F);
      EXPECT_EQ(wrong.rotations[joint].coeffs(), again.rotations[joint].coeffs());
    }
    EXPECT_TRUE(wrong.rotations[body::kHips].isApprox(body::Quat::Identity()));
  }
}

TEST(Dataset, StatisticsStandardizeAndKeepTheirFloors) {
  std::vector<TrainingClip> clips{Walker(60), Walker(60, 1.0F)};
  const FeatureStatistics statistics = ComputeStatistics(clips, {});
  EXPECT_NEAR(statistics.mean[erd::kHipsHeightIndex], body::kHumanoid[0].y_m, 0.03);
  for (int i = 0; i < erd::kFeatureCount; ++i) EXPECT_GE(statistics.deviation[i], 0.01F);
  EXPECT_FLOAT_EQ(statistics.deviation[erd::kPositionBegin], 0.01F);  // hips: always zero
  // Mirrored clips are in it too, so what points left and right cancels.
  EXPECT_NEAR(statistics.mean[erd::kPositionBegin + 3 * body::kHead], 0.0F, 1e-4);
}

// Over the frames from the second on, mirror images too.
TEST(Dataset, StatisticsAreMeansAndDeviationsOfAllFramesWithAVelocity) {
  const std::vector<TrainingClip> clips{Walker(30), Walker(50, 1.0F)};
  const FeatureStatistics statistics = ComputeStatistics(clips, {});
  erd::FeatureParameters parameters;
  SetHemisphere(statistics.mean, parameters);
  for (int i = 0; i < erd::kFeatureCount; ++i) {
    double sum = 0, square = 0, count = 0;
    for (const TrainingClip& clip : clips) {
      const int length = static_cast<int>(clip.poses.size());
      std::vector<float> window(static_cast<std::size_t>(length) * erd::kFeatureCount);
      for (const bool mirrored : {false, true}) {
        FillWindow(clip, 0, length, mirrored, false, parameters, {.features = window.data()});
        for (int t = 1; t < length; ++t) {
          const double x = window[static_cast<std::size_t>(t * erd::kFeatureCount + i)];
          sum += x;
          square += x * x;
          count += 1;
        }
      }
    }
    const double deviation = std::sqrt(std::max(0.0, square / count - std::pow(sum / count, 2)));
    EXPECT_NEAR(statistics.mean[i], sum / count, 1e-5) << i;
    if (deviation > 0.1) {
      EXPECT_NEAR(statistics.deviation[i], deviation, 1e-4) << i;
    }
  }
}

// A walker that comes back to its first pose after 20 frames, 0.6 m on and turned by 30 degrees.
TEST(Dataset, ALoopGoesOnAlongItsPath) {
  std::vector<body::Pose> loop(21);
  for (int t = 0; t <= 20; ++t) {
    const float round = static_cast<float>(t) / 20.0F;
    loop[t].hips_position_m += body::Vec3(0, 0, 0.6F * round);
    loop[t].rotations[body::kHips] = body::Yaw(0.5236F * round);
    loop[t].rotations[body::kLeftUpperLeg] =
        body::Exp(body::Vec3(0.5F * std::sin(6.2832F * round), 0, 0));
  }
  const std::vector<body::Pose> out = clip::RepeatLoop(loop, 60);
  ASSERT_EQ(out.size(), 61U);
  for (std::size_t i = 1; i < out.size(); ++i) {
    const body::Quat turn = out[i - 1].rotations[body::kHips].conjugate() * out[i].rotations[0];
    EXPECT_NEAR((out[i].hips_position_m - out[i - 1].hips_position_m).norm(), 0.03, 1e-4) << i;
    EXPECT_NEAR(body::Log(turn).y(), 0.5236 / 20, 1e-4) << i;
  }
  // The second round walks where the first one looked at its end.
  const body::Vec3 step = out[21].hips_position_m - out[20].hips_position_m;
  EXPECT_NEAR(std::atan2(step.x(), step.z()), 0.5236, 1e-3);
}

TEST(Dataset, AWindowIsStandingWhereMostOfItIsStill) {
  TrainingClip clip;
  clip.content = 3;
  EXPECT_EQ(clip.ContentOf(0, 10), 3) << "not asked for";
  clip.still_content = 0;
  int still = 0;
  for (int t = 0; t < 40; ++t) clip.still_count.push_back(still += t >= 20 ? 1 : 0);
  EXPECT_EQ(clip.ContentOf(0, 20), 3);
  EXPECT_EQ(clip.ContentOf(14, 10), 3);
  EXPECT_EQ(clip.ContentOf(16, 10), 0);
  EXPECT_EQ(clip.ContentOf(30, 10), 0);
}

// A clip of the humanoid whose arms hang in the zero pose, 1 m above where it should be: T-pose for
// a quarter of a second, then standing, then half a second of steps.
clip::Clip HangingAndHigh() {
  clip::Clip clip;
  for (int joint = 0; joint < body::kJointCount; ++joint) {
    const body::JointRow& row = body::kHumanoid[static_cast<std::size_t>(joint)];
    clip.skeleton.names.emplace_back(row.name);
    clip.skeleton.parents.push_back(row.parent);
    rig::Vec3 offset = body::Offset(joint);
    if (joint == body::kLeftLowerArm || joint == body::kLeftHand || joint == body::kRightLowerArm ||
        joint == body::kRightHand) {
      offset = rig::Vec3(0, -offset.norm(), 0);
    }
    clip.skeleton.offsets.push_back(offset);
  }
  for (int t = 0; t < 30; ++t) {
    rig::RigPose& pose = clip.frames.emplace_back(clip.skeleton);
    pose.translations[0].y() += 1.0F;
    if (t < 8) {
      pose.rotations[body::kLeftUpperArm] = body::Exp(body::Vec3(0, 0, 1.5708F));
      pose.rotations[body::kRightUpperArm] = body::Exp(body::Vec3(0, 0, -1.5708F));
    } else if (t >= 15) {
      pose.rotations[body::kLeftUpperLeg] =
          body::Exp(body::Vec3(-0.8F * std::sin(0.4F * static_cast<float>(t - 15)), 0, 0));
    }
  }
  return clip;
}

// Loads the one clip of the folder under the [[clips]] keys `more`.
Result<std::vector<TrainingClip>> LoadOne(const std::filesystem::path& folder,
                                          const std::string& more) {
  std::ofstream(folder / "m.toml")
      << "name = \"m\"\nlicence = \"none\"\nneutral = \"neutral\"\n"
         "styles = [ { name = \"neutral\", labels = [\"n\"] } ]\n"
         "contents = [ { name = \"stand\" }, { name = \"step\" } ]\n"
         "[still]\ncontent = \"stand\"\nspeed_mps = 0.2\n"
         "[[clips]]\npattern = \"one.bvh\"\nstyle = \"neutral\"\ncontent = \"step\"\n"
      << more;
  const Result<clip::Manifest> manifest = clip::LoadManifest(folder / "m.toml", folder);
  if (!manifest.ok()) return manifest.status();
  return LoadClips(manifest.value(), "train", {}, 2);
}

TEST(Dataset, AClipWithoutAKnownRestPoseOrFloorIsPutRightByItsManifest) {
  const support::TemporaryFolder temporary;
  const auto& folder = temporary.path();
  ASSERT_TRUE(clip::WriteBvh(HangingAndHigh(), folder / "one.bvh").ok());
  EXPECT_NE(LoadOne(folder, "").status().message().find("not a T-pose"), std::string::npos);

  const auto as_it_is = LoadOne(folder, "rig = \"standing\"\n");
  ASSERT_TRUE(as_it_is.ok()) << as_it_is.status().message();
  EXPECT_EQ(as_it_is.value()[0].poses.size(), 30U);
  EXPECT_NEAR(as_it_is.value()[0].poses[12].hips_position_m.y(), 1.98F, 0.01F);
  EXPECT_EQ(as_it_is.value()[0].ContentOf(8, 6), 0) << "it stands there";

  const auto right =
      LoadOne(folder, "rig = \"standing\"\nskip_s = 0.27\nfloor = \"feet\"\nstill = false\n");
  ASSERT_TRUE(right.ok()) << right.status().message();
  const TrainingClip& clip = right.value()[0];
  ASSERT_EQ(clip.poses.size(), 22U) << "less the T-pose";
  EXPECT_EQ(clip.ContentOf(0, 6), 1);
  body::WorldPose world;
  body::ForwardKinematics(clip.poses[4], world);
  EXPECT_NEAR(world.positions_m[body::kRightToes].y(), 0.02F, 0.01F) << "on the floor";
  EXPECT_LT(world.positions_m[body::kLeftHand].y(),
            world.positions_m[body::kLeftUpperArm].y() - 0.4F)
      << "the arms hang, as in the file";

  EXPECT_NE(LoadOne(folder, "rig = \"standing\"\nskip_s = 1\n").status().message().find("skip_s"),
            std::string::npos);
}

TEST(Dataset, ArchivesThatAreNotUnpackedAreNamed) {
  const support::TemporaryFolder temporary;
  const auto& folder = temporary.path();
  std::ofstream(folder / "some.tar.xz") << "x";
  const Status status = CheckDataFolder(folder);
  ASSERT_FALSE(status.ok());
  EXPECT_NE(status.message().find("tar -xJf"), std::string::npos);
  std::filesystem::remove_all(folder);
  EXPECT_FALSE(CheckDataFolder(folder).ok());
}

}  // namespace
}  // namespace styled::train
