#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "daemon/source/rigs/natnet_skeleton.h"
#include "tests/unit/natnet/performer.h"

namespace styled::source {
namespace {

using namespace natnet::testing;

natnet::SkeletonDescription Description(std::initializer_list<natnet::BoneDescription> bones,
                                        std::string_view name = "Anna") {
  natnet::SkeletonDescription description;
  description.name = name;
  for (const auto& bone : bones) description.bones[description.bone_count++] = bone;
  return description;
}

TEST(NatNetSkeleton, IsRefusedWithoutOneRootThatAllBonesAreBelow) {
  for (const auto& [what, description] :
       {std::pair{"no bones", Description({})},
        {"two roots", Description({{"Hip", 1, 0, {}}, {"Ab", 2, 0, {}}})},
        {"a parent that there is not", Description({{"Hip", 1, 0, {}}, {"Ab", 2, 5, {}}})},
        {"its own parent", Description({{"Hip", 1, 0, {}}, {"Ab", 2, 2, {}}})},
        {"a circle", Description({{"Hip", 1, 0, {}}, {"Ab", 2, 3, {}}, {"Chest", 3, 2, {}}})},
        {"no root", Description({{"Hip", 1, 2, {}}, {"Ab", 2, 1, {}}})}}) {
    const auto made = NatNetSkeleton::Make(description);
    ASSERT_FALSE(made.ok()) << what;
    EXPECT_TRUE(made.status().message().starts_with("skeleton Anna: ")) << what;
  }
}

TEST(NatNetSkeleton, PutsParentsBeforeTheirChildren) {
  const auto made = NatNetSkeleton::Make(Description(
      {{"Head", 3, 2, {0, 0.5F, 0}}, {"Chest", 2, 1, {0, 0.25F, 0}}, {"Hip", 1, -1, {0, 1, 0}}}));
  ASSERT_TRUE(made.ok()) << made.status().message();
  const auto& skeleton = made.value().body().skeleton;
  EXPECT_EQ(skeleton.names, (std::vector<std::string>{"Hip", "Chest", "Head"}));
  EXPECT_EQ(skeleton.parents, (std::vector<int>{-1, 0, 1}));
  EXPECT_EQ(skeleton.offsets[2], rig::Vec3(0, 0.5F, 0));
  EXPECT_EQ(made.value().body().metres_per_unit, 1);
  EXPECT_EQ(made.value().body().dialect, "motive");
}

TEST(NatNetSkeleton, DropsItsOwnNameFromItsBones) {
  const auto names = [](std::initializer_list<natnet::BoneDescription> bones,
                        std::string_view name = "Anna") {
    const auto made = NatNetSkeleton::Make(Description(bones, name));
    EXPECT_TRUE(made.ok());
    return made.value().body().skeleton.names;
  };
  using Names = std::vector<std::string>;
  EXPECT_EQ(names({{"Anna", 1, 0, {}}, {"Anna_Ab", 2, 1, {}}}), (Names{"Hip", "Ab"}));
  EXPECT_EQ(names({{"Anna:Hips", 1, 0, {}}, {"Anna:Spine", 2, 1, {}}}), (Names{"Hips", "Spine"}));
  EXPECT_EQ(names({{"Anna_Hip", 1, 0, {}}, {"Anna_Ab", 2, 1, {}}}), (Names{"Hip", "Ab"}));
  EXPECT_EQ(names({{"Anna", 1, 0, {}}, {"Ab", 2, 1, {}}}), (Names{"Hip", "Ab"}));
  // Not what only looks like it.
  EXPECT_EQ(names({{"Hips", 1, 0, {}}, {"Left_Leg", 2, 1, {}}, {"Right_Leg", 3, 1, {}}}, "Left"),
            (Names{"Hips", "Left_Leg", "Right_Leg"}));
  EXPECT_EQ(names({{"Hip", 1, 0, {}}, {"_Ab", 2, 1, {}}}, ""), (Names{"Hip", "_Ab"}));
  EXPECT_EQ(names({{"Hip", 1, 0, {}}, {"Anna_", 2, 1, {}}}), (Names{"Hip", "Anna_"}));
}

TEST(NatNetSkeleton, MakesNamesReadable) {
  const auto made = NatNetSkeleton::Make(
      Description({{"H\xFFip", 1, 0, {}}, {"A\nb", 2, 1, {}}, {"Main_gauche_\u00e9", 3, 2, {}}}));
  EXPECT_EQ(made.value().body().skeleton.names,
            (std::vector<std::string>{"H_ip", "A_b", "Main_gauche___"}));
}

TEST(NatNetSkeleton, TurnsADescriptionThatIsZUp) {
  natnet::SkeletonDescription y_up, z_up;
  Describe("Anna", 1, {}, y_up);
  Describe("Anna", 1, {.z_model = true}, z_up);
  EXPECT_TRUE(NatNetSkeleton::Make(z_up).value().body() ==
              NatNetSkeleton::Make(y_up).value().body());
}

struct Stage {
  explicit Stage(const Streaming& as) : streaming(as) {
    natnet::SkeletonDescription description;
    Describe("Anna", 1, as, description);
    skeleton = std::make_unique<NatNetSkeleton>(NatNetSkeleton::Make(description).value());
    pose = rig::RigPose(skeleton->body().skeleton);
    Place(BentPose(), 1, as, bones);
  }
  NatNetConvention convention() const { return {streaming.local, streaming.z_up}; }

  Streaming streaming;
  std::unique_ptr<NatNetSkeleton> skeleton;
  natnet::Skeleton bones;
  rig::RigPose pose;
};

std::vector<Streaming> AllWays() {
  std::vector<Streaming> ways;
  for (int i = 0; i < 8; ++i) ways.push_back({(i & 1) != 0, (i & 2) != 0, (i & 4) != 0});
  return ways;
}

TEST(NatNetSkeleton, GivesTheSameLocalRotationsInEveryConvention) {
  const body::Pose expected = BentPose();
  for (const Streaming& way : AllWays()) {
    Stage stage(way);
    stage.skeleton->Convert(stage.bones, stage.convention(), true, stage.pose);
    EXPECT_LT((stage.pose.translations[0] - expected.hips_position_m).norm(), 1e-6F);
    for (std::size_t j = 0; j < expected.rotations.size(); ++j) {
      EXPECT_LT(stage.pose.rotations[j].angularDistance(expected.rotations[j]), 1e-3F) << j;
    }
  }
}

TEST(NatNetSkeleton, FitsInTheRightConventionAlone) {
  for (const Streaming& way : AllWays()) {
    const Stage stage(way);
    std::array<float, 4> misfits{};
    stage.skeleton->AddMisfits(stage.bones, true, misfits);
    const std::size_t right = (way.local ? 2U : 0U) + (way.z_up ? 1U : 0U);
    for (std::size_t i = 0; i < misfits.size(); ++i) {
      if (i == right) {
        EXPECT_LT(misfits[i], 1e-4F);
      } else {
        EXPECT_GT(misfits[i], 1.0F);
      }
    }
  }
}

TEST(NatNetSkeleton, FindsBonesByTheirIdsWhereTheirOrderIsAnother) {
  Stage stage({});
  std::swap(stage.bones.bones[3], stage.bones.bones[17]);
  stage.skeleton->Convert(stage.bones, {}, true, stage.pose);
  for (std::size_t j = 0; j < kMotiveBones.size(); ++j) {
    EXPECT_LT(stage.pose.rotations[j].angularDistance(BentPose().rotations[j]), 1e-3F) << j;
  }
}

bool IsNan(const rig::Quat& q) { return q.coeffs().hasNaN(); }

TEST(NatNetSkeleton, GivesNanForABoneThatIsNoUse) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  const std::vector<std::function<void(natnet::Skeleton&)>> ways{
      [](auto& bones) { bones.bones[body::kLeftLowerArm].tracked = false; },
      [](auto& bones) {
        bones.bones[body::kLeftLowerArm].rotation = {0, 0, 0, 0};
      },
      [](auto& bones) { bones.bones[body::kLeftLowerArm].rotation[1] = kNan; },
      [](auto& bones) { bones.bones[body::kLeftLowerArm].rotation[1] = 1e30F; },
      [](auto& bones) { bones.bones[body::kLeftLowerArm].position_m[2] = kNan; },
      [](auto& bones) { bones.bones[body::kLeftLowerArm].id = 99; }};
  for (const bool local : {false, true}) {
    for (std::size_t way = 0; way < ways.size(); ++way) {
      Stage stage({.local = local});
      ways[way](stage.bones);
      stage.skeleton->Convert(stage.bones, stage.convention(), true, stage.pose);
      for (int j = 0; j < body::kJointCount; ++j) {
        // In global coordinates the child's local rotation is not known either.
        const bool lost = j == body::kLeftLowerArm || (!local && j == body::kLeftHand);
        EXPECT_EQ(IsNan(stage.pose.rotations[static_cast<std::size_t>(j)]), lost)
            << way << " " << j;
      }
    }
  }
}

TEST(NatNetSkeleton, KeepsTheRootsPlaceWhileTheRootIsNotTracked) {
  Stage stage({});
  stage.skeleton->Convert(stage.bones, {}, true, stage.pose);
  const rig::Vec3 before = stage.pose.translations[0];
  stage.bones.bones[0].tracked = false;
  stage.bones.bones[0].position_m = {9, 9, 9};
  stage.skeleton->Convert(stage.bones, {}, true, stage.pose);
  EXPECT_EQ(stage.pose.translations[0], before);
  EXPECT_TRUE(IsNan(stage.pose.rotations[0]));
}

TEST(NatNetSkeleton, DoesNotBelieveMarksThatAServerNeverSets) {
  Stage stage({});
  for (auto& bone : stage.bones.bones) bone.tracked = false;
  stage.skeleton->Convert(stage.bones, {}, false, stage.pose);
  for (const rig::Quat& rotation : stage.pose.rotations) EXPECT_FALSE(IsNan(rotation));
}

constexpr std::array<float, 4> kGlobalY{0, 9, 9, 9}, kLocalY{9, 9, 0, 9}, kLocalZ{9, 9, 9, 0};

TEST(NatNetConventionFinder, KnowsNothingBeforeAFrameTells) {
  NatNetConventionFinder finder("auto", "auto");
  EXPECT_FALSE(finder.known());
  EXPECT_FALSE(finder.Evaluate({0, 0, 0, 0}));
  EXPECT_FALSE(finder.Evaluate({4, 5, 6, 7}));
  EXPECT_FALSE(finder.Evaluate({NAN, NAN, NAN, NAN}));
  EXPECT_FALSE(finder.known());
  EXPECT_TRUE(finder.Evaluate(kLocalZ));
  EXPECT_TRUE(finder.known());
  EXPECT_EQ(finder.convention(), (NatNetConvention{true, true}));
}

TEST(NatNetConventionFinder, ChangesItsMindAfterTenFramesInARow) {
  NatNetConventionFinder finder("auto", "auto");
  EXPECT_TRUE(finder.Evaluate(kGlobalY));
  for (int i = 0; i < 9; ++i) EXPECT_FALSE(finder.Evaluate(kLocalY));
  EXPECT_FALSE(finder.Evaluate(kGlobalY));
  for (int i = 0; i < 9; ++i) EXPECT_FALSE(finder.Evaluate(kLocalY));
  EXPECT_FALSE(finder.Evaluate(kLocalZ)) << "another one: not in a row";
  for (int i = 0; i < 9; ++i) EXPECT_FALSE(finder.Evaluate(kLocalY));
  EXPECT_TRUE(finder.Evaluate(kLocalY));
  EXPECT_EQ(finder.convention(), (NatNetConvention{true, false}));
}

TEST(NatNetConventionFinder, LeavesAloneWhatIsFixed) {
  NatNetConventionFinder local("local", "auto");
  EXPECT_TRUE(local.Evaluate({0, 9, 5, 1}));
  EXPECT_EQ(local.convention(), (NatNetConvention{true, true}));
  NatNetConventionFinder z_up("auto", "z");
  EXPECT_TRUE(z_up.Evaluate({0, 1, 0, 9}));
  EXPECT_EQ(z_up.convention(), (NatNetConvention{false, true}));
  NatNetConventionFinder all("global", "z");
  EXPECT_TRUE(all.known());
  EXPECT_FALSE(all.Evaluate(kLocalY));
  EXPECT_EQ(all.convention(), (NatNetConvention{false, true}));
}

}  // namespace
}  // namespace styled::source
