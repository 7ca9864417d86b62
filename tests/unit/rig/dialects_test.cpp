#include "model/rig/dialects.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>

#include "model/clip/clip.h"
#include "model/rig/dialect_rests.h"
#include "tests/unit/rig/rigs.h"

namespace styled::rig {
namespace {

using testing::HasSubstr;

std::string Refusal(const Skeleton& skeleton, std::string_view dialect = "auto") {
  const Result<Binding> result = BindDialect(skeleton, dialect);
  return result.ok() ? "accepted" : result.status().message();
}

TEST(DialectsRefuse, ADialectTheyDoNotKnowAndNameThoseTheyDo) {
  const std::string refusal = Refusal(HumanoidSkeleton(), "klingon");
  EXPECT_THAT(refusal, HasSubstr("found dialect klingon"));
  EXPECT_THAT(Refusal(HumanoidSkeleton(), "\x1b]0;x\a"),
              HasSubstr("found dialect \\x1b]0;x\\x07,"));
  EXPECT_THAT(refusal, HasSubstr("bandai-namco"));
}

TEST(Dialects, SomeAreToldByTheirNamesAlone) {
  const auto named = [](std::initializer_list<std::string> names) {
    Skeleton skeleton;
    skeleton.names = names;
    return std::string(DialectOfNames(skeleton));
  };
  EXPECT_EQ(named({"CC_Base_Hip", "CC_Base_Pelvis", "CC_Base_Waist", "CC_Base_Spine01",
                   "CC_Base_Head", "CC_Base_L_Upperarm", "CC_Base_L_Thigh"}),
            "character-creator");
  EXPECT_EQ(named({"hip", "abdomen", "chest", "lCollar", "lShldr", "lForeArm", "lThigh", "lShin",
                   "rForeArm"}),
            "poser");
  EXPECT_EQ(named({"hips", "spine", "chest", "leftUpperArm"}), "");
  for (const auto* const known : {"auto", "poser", "character-creator", "cmu"}) {
    EXPECT_TRUE(IsDialect(known)) << known;
  }
  EXPECT_FALSE(IsDialect("klingon"));
}

TEST(DialectsRefuse, JointsThatCannotBeMappedByName) {
  Skeleton skeleton = HumanoidSkeleton();
  LoseLeftLeg(skeleton);
  EXPECT_THAT(Refusal(skeleton), HasSubstr("found no joint named like leftLowerLeg,"));
}

TEST(DialectsRefuse, AnEmptyOrDisorderedSkeleton) {
  EXPECT_THAT(Refusal(Skeleton()), HasSubstr("no joints"));
  Skeleton skeleton = HumanoidSkeleton();
  skeleton.parents[3] = 7;
  EXPECT_THAT(Refusal(skeleton), HasSubstr("found parent 7"));
  skeleton = HumanoidSkeleton();
  skeleton.offsets.pop_back();
  EXPECT_THAT(Refusal(skeleton), HasSubstr("offsets"));
}

TEST(DialectsRefuse, AZeroPoseWithHangingArms) {
  Skeleton skeleton = HumanoidSkeleton();
  skeleton.offsets[body::kLeftLowerArm] = Vec3(0, -0.27F, 0);
  EXPECT_THAT(Refusal(skeleton), HasSubstr("leftUpperArm to leftLowerArm 90 degrees away"));
}

TEST(DialectsRefuse, ALeftHandedSkeleton) {
  Skeleton skeleton = HumanoidSkeleton();
  for (Vec3& offset : skeleton.offsets) offset.z() = -offset.z();
  EXPECT_THAT(Refusal(skeleton, "vrm"), HasSubstr("toes that point backward"));
}

TEST(DialectsRefuse, OffsetsThatAreNoNumbers) {
  Skeleton skeleton = HumanoidSkeleton();
  skeleton.offsets[body::kLeftLowerArm].setConstant(std::nanf(""));
  EXPECT_NE(Refusal(skeleton), "accepted");
  skeleton = HumanoidSkeleton();
  for (Vec3& offset : skeleton.offsets) offset.setZero();
  EXPECT_NE(Refusal(skeleton), "accepted");
}

TEST(Dialects, TakeATPoseAsItIs) {
  for (std::string_view dialect : {"auto", "canonical", "vrm", "unity", "vmc", "mixamo", "hik",
                                   "lafan1", "xsens", "motive", "rokoko", "axis", "mocopi"}) {
    const Result<Binding> binding = BindDialect(HumanoidSkeleton(), dialect);
    ASSERT_TRUE(binding.ok()) << binding.status().message();
    EXPECT_NEAR(binding.value().scale(), 1, 1e-5);
    for (const Quat& q : binding.value().spec().rest_rotations) {
      EXPECT_LT(Angle_rad(q, Quat::Identity()), 1e-6);
    }
  }
}

TEST(Dialects, AutoSaysWhatItFound) {
  std::string used;
  ASSERT_TRUE(BindDialect(HumanoidSkeleton(), "auto", &used).ok());
  EXPECT_EQ(used, "canonical");
  ASSERT_TRUE(BindDialect(HumanoidSkeleton(), "mixamo", &used).ok());
  EXPECT_EQ(used, "mixamo");
}

TEST(Dialects, FindTheAxesOfATPoseInAnyOrientation) {
  // Xsens: +Z up, +X forward, +Y left.
  Eigen::Matrix3f axes;
  axes << 0, 1, 0, 0, 0, 1, 1, 0, 0;  // canonical from source
  const Quat expected(axes);
  Skeleton skeleton = HumanoidSkeleton();
  for (Vec3& offset : skeleton.offsets) offset = 100 * (expected.conjugate() * offset);
  const Result<Binding> binding = BindDialect(skeleton, "xsens");
  ASSERT_TRUE(binding.ok()) << binding.status().message();
  EXPECT_LT(Angle_rad(binding.value().spec().canonical_from_source, expected), 1e-5);
  EXPECT_NEAR(binding.value().scale(), 0.01, 1e-6);
}

TEST(Dialects, RokokosConstantsMakeATPoseOfItsFrames) {
  // A body whose joint frames at rest are Rokoko's and whose T-pose is the canonical one.
  Skeleton skeleton = HumanoidSkeleton();
  const auto rest = [](int c) {
    const RestRow& row = kRokokoRest[c];
    return Quat(row.w, row.x, row.y, row.z).normalized();
  };
  for (int c = 1; c < kJointCount; ++c) {
    skeleton.offsets[c] = rest(kHumanoid[c].parent).conjugate() * body::Offset(c);
  }
  const Result<Binding> binding = BindDialect(skeleton, "rokoko");
  ASSERT_TRUE(binding.ok()) << binding.status().message();
  EXPECT_NEAR(binding.value().scale(), 1, 1e-4);
  EXPECT_LT(
      Angle_rad(binding.value().spec().rest_rotations[body::kLeftHand], rest(body::kLeftHand)),
      1e-6);
}

// The folder of test clips, which is not part of the repository.
std::filesystem::path Data() {
  const char* set = std::getenv("STYLED_DATA");
  return set != nullptr ? set : STYLED_DATA_DEFAULT;
}

class DialectsOnData : public testing::Test {
 protected:
  void SetUp() override {
    if (!std::filesystem::exists(Data() / "samples")) {
      GTEST_SKIP() << "skipped, no data in " << Data() << " (set STYLED_DATA)";
    }
  }
  static clip::Clip Read(const std::string& name) {
    Result<clip::Clip> clip = clip::ReadBvh(Data() / name);
    EXPECT_TRUE(clip.ok()) << clip.status().message();
    return clip.ok() ? clip.value() : clip::Clip();
  }
};

TEST_F(DialectsOnData, BandaisConstantsAreTheSwingOfItsStandingFrame) {
  const clip::Clip clip = Read("samples/dataset-2_raise-up-right-hand_normal_001.bvh");
  ASSERT_FALSE(clip.frames.empty());
  const auto map = MapJointNames(clip.skeleton);
  const std::vector<Quat> rest = RestBySwing(clip.skeleton, map, clip.frames[0], Quat::Identity());
  for (int c = 0; c < kJointCount; ++c) {
    ASSERT_GE(map[c], 0) << kHumanoid[c].name;
    const RestRow& row = kBandaiNamcoRest[c];
    EXPECT_LT(Angle_rad(rest[map[c]], Quat(row.w, row.x, row.y, row.z)), 1e-5) << kHumanoid[c].name;
  }
}

TEST_F(DialectsOnData, BandaisClipsBindAndComeBack) {
  for (const char* name :
       {"samples/dataset-1_walk_normal_001.bvh", "samples/dataset-2_walk_elderly_001.bvh",
        "samples/dataset-2_wave-both-hands_normal_001.bvh", "xia/neutral_01_000.bvh",
        "xia/old_13_000.bvh"}) {
    const clip::Clip clip = Read(name);
    std::string used;
    const Result<Binding> binding = BindDialect(clip.skeleton, "auto", &used);
    ASSERT_TRUE(binding.ok()) << binding.status().message();
    EXPECT_EQ(used, std::string_view(name).starts_with("xia") ? "cmu" : "bandai-namco");
    RigPose back(clip.skeleton);
    for (const RigPose& frame : clip.frames) {
      body::Pose pose;
      binding.value().Bind(frame, pose);
      binding.value().Unbind(pose, frame, back);
      for (int joint = 0; joint < clip.skeleton.joint_count(); ++joint) {
        ASSERT_LT(Angle_rad(back.rotations[joint], frame.rotations[joint]), 1.7e-4) << name;
        ASSERT_LT(
            (back.translations[joint] - frame.translations[joint]).norm() * binding.value().scale(),
            1e-4)
            << name;
      }
    }
  }
}

// Properties of a walk on the humanoid, whatever rig it came from: feet near the floor, hips at
// their height, knees and elbows that bend about one axis, and no joint near a half turn.
TEST_F(DialectsOnData, AWalkLooksLikeAWalkOnTheHumanoid) {
  struct Case {
    const char* name;
    float knee_axis_x;  // CMU's knees turn about the zero pose's X; its legs are 20 degrees off
  };
  for (const Case& walk : {Case{"samples/dataset-1_walk_normal_001.bvh", 0.97F},
                           Case{"samples/dataset-2_walk_normal_001.bvh", 0.97F},
                           Case{"xia/neutral_01_000.bvh", 0.9F}}) {
    const clip::Clip clip = Read(walk.name);
    const Result<Binding> binding = BindDialect(clip.skeleton);
    ASSERT_TRUE(binding.ok()) << binding.status().message();
    Vec3 knee = Vec3::Zero(), elbow = Vec3::Zero();
    float knee_turns = 0, elbow_turns = 0;
    for (const body::Pose& pose : clip::ToCanonical(clip, binding.value())) {
      body::WorldPose world;
      body::ForwardKinematics(pose, world);
      EXPECT_NEAR(world.positions_m[body::kHips].y(), 0.97F, 0.1F) << walk.name;
      EXPECT_NEAR(body::LowestFoot_m(world), 0.02F, 0.06F) << walk.name;
      EXPECT_GT(world.positions_m[body::kHead].y(), 1.3F) << walk.name;
      for (int c = 1; c < body::kLeftToes; ++c) {
        EXPECT_LT(body::Log(pose.rotations[c]).norm(), 2.5F) << walk.name << kHumanoid[c].name;
      }
      const Vec3 knee_turn = body::Log(pose.rotations[body::kLeftLowerLeg]);
      const Vec3 elbow_turn = body::Log(pose.rotations[body::kLeftLowerArm]);
      knee += knee_turn;
      elbow += elbow_turn;
      knee_turns += knee_turn.norm();
      elbow_turns += elbow_turn.norm();
    }
    EXPECT_GT(knee.x() / knee.norm(), walk.knee_axis_x) << walk.name << ": bends backward, about X";
    EXPECT_GT(knee.norm() / knee_turns, 0.9F) << walk.name << ": about one axis";
    EXPECT_LT(elbow.y() / elbow.norm(), -0.8F) << walk.name << ": bends forward, about -Y";
    EXPECT_GT(elbow.norm() / elbow_turns, 0.9F) << walk.name << ": about one axis";
  }
}

}  // namespace
}  // namespace styled::rig
