#include "model/rig/name_reading.h"

#include <gtest/gtest.h>

namespace styled::rig {
namespace {

NameReading Read(const std::string& name) { return ReadNames({name}).front(); }

TEST(NameReading, WordsSayPartAndSide) {
  struct Row {
    const char* name;
    Part part;
    int side;
  };
  for (const Row& row : {Row{"mixamorig:LeftForeArm_07", Part::kLowerArm, 1},
                         {"DEF-upper_arm.R.001", Part::kUpperArm, -1},
                         {"Bip001 L Thigh", Part::kUpperLeg, 1},
                         {"rclavicle", Part::kShoulder, -1},
                         {"thigh_stretch.l", Part::kUpperLeg, 1},
                         {"l_toeBase_JNT", Part::kToes, 1},
                         {"Armature|RightHand", Part::kHand, -1},
                         {"Scapula_L", Part::kShoulder, 1},
                         {"cf_j_forearm01_R", Part::kLowerArm, -1},
                         {"SpineBase", Part::kHips, 0},
                         {"A_Neck", Part::kNeck, 0},
                         {"左ひじ", Part::kLowerArm, 1},
                         {"右手首", Part::kHand, -1},
                         {"左足", Part::kUpperLeg, 1},
                         {"左足首", Part::kFoot, 1},
                         {"右大腿", Part::kUpperLeg, -1},
                         {"頭", Part::kHead, 0}}) {
    const NameReading read = Read(row.name);
    EXPECT_TRUE(read.Says(row.part)) << row.name;
    EXPECT_EQ(read.side, row.side) << row.name;
    EXPECT_FALSE(read.other || read.end || read.twist) << row.name;
  }
}

TEST(NameReading, AWordMayMeanTwoParts) {
  EXPECT_TRUE(Read("LeftLeg").Says(Part::kUpperLeg));
  EXPECT_TRUE(Read("LeftLeg").Says(Part::kLowerLeg));
  EXPECT_TRUE(Read("LShoulder").Says(Part::kUpperArm));
  EXPECT_FALSE(Read("LClavicle").Says(Part::kUpperArm));
}

TEST(NameReading, PartOfANameIsOnlyAHint) {
  const NameReading read = Read("arm left elbow");
  EXPECT_EQ(read.words, 0);
  EXPECT_TRUE(read.Hints(Part::kLowerArm) && read.Hints(Part::kUpperArm));
}

TEST(NameReading, HelpersAreToldFromJointsOfTheBody) {
  for (const char* name : {"hair_01", "L_Skirt_2", "LeftHandIndex1", "Tail3", "左足ＩＫ", "右親指",
                           "ik_foot_l", "RightEye"}) {
    EXPECT_TRUE(Read(name).other) << name;
  }
  EXPECT_TRUE(Read("LeftToe_End").end);
  EXPECT_TRUE(Read("upperarm_twist_01_l").twist);
  EXPECT_FALSE(Read("NeckTwist01").twist) << "Character Creator's neck";
  EXPECT_FALSE(Read("MiddleSpine").other) << "not the middle finger";
}

TEST(NameReading, WhatAllNamesShareIsNotRead) {
  const auto read = ReadNames({"Hair_Spine", "Hair_Head", "Hair_LeftArm"});
  EXPECT_TRUE(read[1].Says(Part::kHead));
  EXPECT_FALSE(read[1].other);
  // ARKit's joints all end so; with a few it is a helper.
  EXPECT_TRUE(ReadNames({"left_hip_joint", "left_knee_joint"})[0].Says(Part::kUpperLeg));
  EXPECT_TRUE(ReadNames({"LHipJoint", "LeftUpLeg", "LeftLeg"})[0].other);
}

TEST(NameReading, NothingIsReadOutOfNothing) {
  for (const char* name : {"", ":", "_", "wheel", "L", "joint_12", "\xFF\xFE", "kappa", "|"}) {
    const NameReading read = Read(name);
    EXPECT_EQ(read.words | read.hints, 0) << name;
  }
}

}  // namespace
}  // namespace styled::rig
