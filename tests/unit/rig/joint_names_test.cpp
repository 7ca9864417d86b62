#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "model/rig/dialects.h"

namespace styled::rig {
namespace {

// One column of the table of names: in canonical order, "" if the rig has no such joint; `others`
// are joints that must not be mapped.
struct Naming {
  std::string rig;
  std::vector<std::string> names;
  std::vector<std::string> others;
};

std::vector<std::string> Sided(const std::vector<std::string>& centre,
                               const std::vector<std::string>& left_arm,
                               const std::vector<std::string>& left_leg, const std::string& left,
                               const std::string& right) {
  std::vector<std::string> names = centre;
  for (const auto* limb : {&left_arm, &left_leg}) {
    for (const std::string& side : {left, right}) {
      for (const std::string& pattern : *limb) {
        std::string name = pattern;
        if (const auto at = name.find('@'); at != std::string::npos) name.replace(at, 1, side);
        names.push_back(name);
      }
    }
  }
  return names;
}

const std::vector<std::string> kHikArm = {"@Shoulder", "@Arm", "@ForeArm", "@Hand"};
const std::vector<std::string> kHikLeg = {"@UpLeg", "@Leg", "@Foot", "@ToeBase"};
const std::vector<std::string> kVrmArm = {"@Shoulder", "@UpperArm", "@LowerArm", "@Hand"};
const std::vector<std::string> kVrmLeg = {"@UpperLeg", "@LowerLeg", "@Foot", "@Toes"};

std::vector<std::string> Prefixed(const std::string& prefix, std::vector<std::string> names) {
  for (std::string& name : names) {
    if (!name.empty()) name.insert(0, prefix);
  }
  return names;
}

std::vector<Naming> Namings() {
  const auto hik =
      Sided({"Hips", "Spine", "Spine1", "Neck", "Head"}, kHikArm, kHikLeg, "Left", "Right");
  return {
      {"canonical",
       Sided({"hips", "spine", "chest", "neck", "head"}, kVrmArm, kVrmLeg, "left", "right"),
       {"upperChest", "leftThumbProximal", "leftIndexDistal"}},
      {"Unity",
       Sided({"Hips", "Spine", "Chest", "Neck", "Head"}, kVrmArm, kVrmLeg, "Left", "Right"),
       {"UpperChest", "LeftEye", "Jaw"}},
      {"Mixamo", Prefixed("mixamorig:", hik), {"mixamorig:Spine2", "mixamorig:LeftHandThumb1"}},
      {"Mixamo, numbered", Prefixed("mixamorig1:", hik), {"mixamorig1:HeadTop_End"}},
      {"Mixamo, underscore", Prefixed("mixamorig_", hik), {"mixamorig_LeftToe_End"}},
      {"HIK", hik, {"Spine2", "Neck1", "LeftHandIndex1"}},
      {"named skeleton", Prefixed("Skeleton_", hik), {"Skeleton_Spine2"}},
      {"LaFAN1",
       Sided({"Hips", "Spine", "Spine1", "Neck", "Head"}, kHikArm,
             {"@UpLeg", "@Leg", "@Foot", "@Toe"}, "Left", "Right"),
       {"Spine2"}},
      {"CMU",
       Sided({"Hips", "LowerBack", "Spine", "Neck", "Head"}, kHikArm, kHikLeg, "Left", "Right"),
       {"LHipJoint", "RHipJoint", "Spine1", "Neck1", "LeftFingerBase", "LThumb"}},
      {"CMU's ASF",
       Sided({"Hips", "lowerback", "upperback", "lowerneck", "head"},
             {"@clavicle", "@humerus", "@radius", "@hand"}, {"@femur", "@tibia", "@foot", "@toes"},
             "l", "r"),
       {"thorax", "upperneck", "lhipjoint", "lwrist", "lfingers", "lthumb"}},
      {"Xsens",
       Sided({"Pelvis", "L5", "T12", "Neck", "Head"},
             {"@Shoulder", "@UpperArm", "@ForeArm", "@Hand"},
             {"@UpperLeg", "@LowerLeg", "@Foot", "@Toe"}, "Left", "Right"),
       {"L3", "T8"}},
      {"Xsens' BVH",
       Sided({"Hips", "Chest", "Chest2", "Neck", "Head"},
             {"@Collar", "@Shoulder", "@Elbow", "@Wrist"}, {"@Hip", "@Knee", "@Ankle", "@Toe"},
             "Left", "Right"),
       {"Chest3", "Chest4"}},
      {"Motive",
       Sided({"Hip", "Ab", "Chest", "Neck", "Head"}, {"@Shoulder", "@UArm", "@FArm", "@Hand"},
             {"@Thigh", "@Shin", "@Foot", "@Toe"}, "L", "R"),
       {"LThumb1", "LIndex1"}},
      {"Rokoko",
       Sided({"hip", "spine", "chest", "neck", "head"}, kVrmArm,
             {"@UpLeg", "@Leg", "@Foot", "@Toe"}, "left", "right"),
       {"leftThumbMedial", "leftToeEnd"}},
      {"Axis",
       Sided({"Hips", "Spine", "Spine1", "Neck", "Head"}, kHikArm, {"@UpLeg", "@Leg", "@Foot", ""},
             "Left", "Right"),
       {"Spine2", "Spine3", "LeftInHandIndex", "LeftHandIndex1"}},
      {"mocopi",
       Sided({"root", "torso_2", "torso_4", "neck_1", "head"},
             {"@_shoulder", "@_up_arm", "@_low_arm", "@_hand"},
             {"@_up_leg", "@_low_leg", "@_foot", "@_toes"}, "l", "r"),
       {"torso_1", "torso_3", "torso_5", "torso_6", "torso_7", "neck_2"}},
      {"Bandai-Namco",
       Sided({"Hips", "Spine", "Chest", "Neck", "Head"},
             {"Shoulder_@", "UpperArm_@", "LowerArm_@", "Hand_@"},
             {"UpperLeg_@", "LowerLeg_@", "Foot_@", "Toes_@"}, "L", "R"),
       {"joint_Root"}},
      {"Biped",
       Prefixed("Bip01 ", Sided({"Pelvis", "Spine", "Spine1", "Neck", "Head"},
                                {"@ Clavicle", "@ UpperArm", "@ Forearm", "@ Hand"},
                                {"@ Thigh", "@ Calf", "@ Foot", "@ Toe0"}, "L", "R")),
       {"Bip01", "Bip01 Spine2", "Bip01 L Finger0"}},
      {"VRoid",
       Prefixed("J_Bip_", Sided({"C_Hips", "C_Spine", "C_Chest", "C_Neck", "C_Head"},
                                {"@_Shoulder", "@_UpperArm", "@_LowerArm", "@_Hand"},
                                {"@_UpperLeg", "@_LowerLeg", "@_Foot", "@_ToeBase"}, "L", "R")),
       {"J_Bip_C_UpperChest", "J_Sec_Hair1"}},
      {"Unreal",
       Sided({"pelvis", "spine_01", "spine_02", "neck_01", "head"},
             {"clavicle_@", "upperarm_@", "lowerarm_@", "hand_@"},
             {"thigh_@", "calf_@", "foot_@", "ball_@"}, "l", "r"),
       {"root", "spine_03", "upperarm_twist_01_l"}},
      {"SMPL",
       Sided({"pelvis", "spine1", "spine2", "neck", "head"},
             {"@_collar", "@_shoulder", "@_elbow", "@_wrist"},
             {"@_hip", "@_knee", "@_ankle", "@_foot"}, "left", "right"),
       {"spine3", "left_hand"}},
      {"Character Creator",
       Prefixed("CC_Base_", Sided({"Hip", "Spine01", "Spine02", "NeckTwist01", "Head"},
                                  {"@_Clavicle", "@_Upperarm", "@_Forearm", "@_Hand"},
                                  {"@_Thigh", "@_Calf", "@_Foot", "@_ToeBase"}, "L", "R")),
       {"RL_BoneRoot", "CC_Base_Pelvis", "CC_Base_Waist", "CC_Base_L_UpperarmTwist01"}},
      {"Poser",
       Sided({"hip", "abdomen", "chest", "neck", "head"},
             {"@Collar", "@Shldr", "@ForeArm", "@Hand"}, {"@Thigh", "@Shin", "@Foot", ""}, "l",
             "r"),
       {"leftEye", "lThumb1", "lButtock"}},
      {"Daz Genesis",
       Sided({"hip", "abdomenLower", "chestLower", "neckLower", "head"},
             {"@Collar", "@ShldrBend", "@ForearmBend", "@Hand"},
             {"@ThighBend", "@Shin", "@Foot", "@Toe"}, "l", "r"),
       {"pelvis", "abdomenUpper", "chestUpper", "neckUpper", "lShldrTwist", "lForearmTwist",
        "lThighTwist", "lMetatarsals"}},
      {"no head",
       Sided({"pelvis", "spine", "spine.001", "neck", "face"},
             {"shoulder.@", "upper_arm.@", "forearm.@", ""}, {"thigh.@", "shin.@", "foot.@", ""},
             "L", "R"),
       {"pelvis.L", "pelvis.R"}},
      {"dots",
       Sided({"hips", "spine", "chest", "neck", "head"},
             {"shoulder.@", "upper_arm.@", "forearm.@", "hand.@"},
             {"thigh.@", "shin.@", "foot.@", "toe.@"}, "L", "R"),
       {}},
  };
}

TEST(JointNames, EveryNamingHabitMapsToTheHumanoid) {
  for (const Naming& naming : Namings()) {
    ASSERT_EQ(naming.names.size(), body::kJointCount) << naming.rig;
    Skeleton skeleton;
    for (const std::string& name : naming.others) skeleton.names.push_back(name);
    std::array<int, body::kJointCount> expected;
    for (int c = 0; c < body::kJointCount; ++c) {
      expected[c] = naming.names[c].empty() ? -1 : skeleton.joint_count();
      if (!naming.names[c].empty()) skeleton.names.push_back(naming.names[c]);
    }
    const auto map = MapJointNames(skeleton);
    for (int c = 0; c < body::kJointCount; ++c) {
      EXPECT_EQ(map[c], expected[c])
          << naming.rig << ": " << body::kHumanoid[c].name << " should be \"" << naming.names[c]
          << "\", found " << (map[c] < 0 ? "nothing" : skeleton.names[map[c]]);
    }
  }
}

TEST(JointNames, MeaninglessNamesMapToNothing) {
  Skeleton skeleton;
  skeleton.names = {"", ":", "_", "wheel", "left", "L", "mixamorig", "Bip01", "\xFF\xFE"};
  for (int joint : MapJointNames(skeleton)) EXPECT_EQ(joint, -1);
  for (int joint : MapJointNames(Skeleton())) EXPECT_EQ(joint, -1);
}

TEST(JointNames, RepeatedNamesMapToTheFirst) {
  Skeleton skeleton;
  skeleton.names = {"Head", "head"};
  EXPECT_EQ(MapJointNames(skeleton)[body::kHead], 0);
}

TEST(JointNames, GivenByHandWin) {
  Skeleton skeleton;
  skeleton.names = {"hips", "spine", "head", "Arm_01", "leftHand"};
  const auto map =
      MapJoints(skeleton, {{"leftUpperArm", "Arm_01"}, {"spine", ""}, {"neck", "head"}});
  ASSERT_TRUE(map.ok()) << map.status().message();
  EXPECT_EQ(map.value()[body::kLeftUpperArm], 3);
  EXPECT_EQ(map.value()[body::kSpine], -1);
  EXPECT_EQ(map.value()[body::kNeck], 2);
  EXPECT_EQ(map.value()[body::kHead], -1) << "its joint is another's now";
  EXPECT_EQ(map.value()[body::kHips], 0);
}

}  // namespace
}  // namespace styled::rig
