// Fingers, eyes and jaw by the names that rigs give them.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "model/rig/tail.h"

namespace styled::rig {
namespace {

struct TailNaming {
  std::string rig;
  // The left hand's, @ for the side: three of the thumb and so on, "" where the rig has none.
  std::vector<std::string> fingers;
  std::string left, right;
  std::string eye, jaw;
};

std::vector<std::string> Pattern(const std::string& form, const std::vector<std::string>& fingers,
                                 const std::vector<std::string>& joints) {
  std::vector<std::string> names;
  for (const std::string& finger : fingers) {
    for (const std::string& joint : joints) {
      std::string name = form;
      name.replace(name.find('#'), 1, finger);
      name.replace(name.find('*'), 1, joint);
      names.push_back(name);
    }
  }
  return names;
}

std::vector<std::string> WithThumb(const std::vector<std::string>& thumb,
                                   std::vector<std::string> others) {
  others.insert(others.begin(), thumb.begin(), thumb.end());
  return others;
}

std::vector<TailNaming> TailNamings() {
  const std::vector<std::string> five = {"Thumb", "Index", "Middle", "Ring", "Pinky"};
  const std::vector<std::string> little = {"Index", "Middle", "Ring", "Little"};
  const std::vector<std::string> vrm = {"Proximal", "Intermediate", "Distal"};
  return {
      {"VRM 1.0",
       WithThumb({"@ThumbMetacarpal", "@ThumbProximal", "@ThumbDistal"},
                 Pattern("@#*", little, vrm)),
       "left", "right", "@Eye", "jaw"},
      {"Unity",
       WithThumb({"@ThumbProximal", "@ThumbIntermediate", "@ThumbDistal"},
                 Pattern("@#*", little, vrm)),
       "Left", "Right", "@Eye", "Jaw"},
      {"Mixamo", Pattern("mixamorig:@Hand#*", five, {"1", "2", "3"}), "Left", "Right",
       "mixamorig:@Eye", ""},
      {"HIK", Pattern("@Hand#*", five, {"1", "2", "3"}), "Left", "Right", "@Eye", "Jaw"},
      {"Xsens",
       {"@FirstMC", "@FirstPP", "@FirstDP", "@SecondPP", "@SecondMP", "@SecondDP", "@ThirdPP",
        "@ThirdMP", "@ThirdDP", "@FourthPP", "@FourthMP", "@FourthDP", "@FifthPP", "@FifthMP",
        "@FifthDP"},
       "Left",
       "Right",
       "",
       ""},
      {"Rokoko",
       Pattern("@#*", {"Thumb", "Index", "Middle", "Ring", "Little"},
               {"Proximal", "Medial", "Distal"}),
       "left", "right", "", ""},
      {"Motive", Pattern("@#*", five, {"1", "2", "3"}), "L", "R", "", ""},
      {"Unreal",
       Pattern("#_*_@", {"thumb", "index", "middle", "ring", "pinky"}, {"01", "02", "03"}), "l",
       "r", "eye_@", "jaw"},
      {"Rigify",
       WithThumb({"thumb.01.@", "thumb.02.@", "thumb.03.@"},
                 Pattern("f_#.*.@", {"index", "middle", "ring", "pinky"}, {"01", "02", "03"})),
       "L", "R", "eye.@", "jaw"},
      {"Biped", Pattern("Bip01 @ Finger#*", {"0", "1", "2", "3", "4"}, {"", "1", "2"}), "L", "R",
       "", ""},
      {"Character Creator",
       Pattern("CC_Base_@_#*", {"Thumb", "Index", "Mid", "Ring", "Pinky"}, {"1", "2", "3"}), "L",
       "R", "CC_Base_@_Eye", "CC_Base_JawRoot"},
      {"SMPL-X", Pattern("@_#*", {"thumb", "index", "middle", "ring", "pinky"}, {"1", "2", "3"}),
       "left", "right", "@_eye_smplhf", "jaw"},
      {"gloves without tips", Pattern("@Hand#*", five, {"1", "2", ""}), "Left", "Right", "", ""},
  };
}

TEST(TailNames, EveryNamingHabitMapsToVrmsBones) {
  for (TailNaming naming : TailNamings()) {
    ASSERT_EQ(naming.fingers.size(), static_cast<std::size_t>(kHandTail)) << naming.rig;
    const bool no_tips = naming.rig == "gloves without tips";
    Skeleton skeleton;
    skeleton.names = {"Hips"};
    TailMap expected = NoTail();
    const auto add = [&](std::string name, const std::string& side, int joint) {
      if (name.empty()) return;
      if (const auto at = name.find('@'); at != std::string::npos) name.replace(at, 1, side);
      expected[static_cast<std::size_t>(joint)] = skeleton.joint_count();
      skeleton.names.push_back(name);
    };
    for (int i = 0; i < kHandTail; ++i) {
      if (no_tips && i % kFingerJoints == 2) continue;
      add(naming.fingers[static_cast<std::size_t>(i)], naming.left, kTailLeftThumb + i);
      add(naming.fingers[static_cast<std::size_t>(i)], naming.right, kTailRightThumb + i);
    }
    add(naming.eye, naming.left, kTailLeftEye);
    add(naming.eye, naming.right, kTailRightEye);
    add(naming.jaw, "", kTailJaw);
    const TailMap map = MapTailNames(skeleton);
    for (std::size_t t = 0; t < map.size(); ++t) {
      EXPECT_EQ(map[t], expected[t]) << naming.rig << ": " << kTailNames[t];
    }
  }
}

// Names that resemble a finger's: one stiff joint, ends of bones, the body's joints.
TEST(TailNames, OtherNamesMapToNothing) {
  Skeleton skeleton;
  skeleton.names = {"Hips",     "LeftHand",        "LeftFingerBase", "LeftHandIndex1", "LThumb",
                    "RThumb",   "RightHandIndex1", "finger",         "finger_01",      "L_Finger3",
                    "index",    "LeftCarpus",      "HeadTop_End",    "eyes",           "",
                    "\xFF\xFE", "LeftInHandIndex"};
  EXPECT_EQ(MapTailNames(skeleton), NoTail());
  EXPECT_EQ(MapTailNames(Skeleton()), NoTail());
}

TEST(TailNames, TheTablesNamesAreVrms) {
  EXPECT_EQ(kTailNames[kTailLeftThumb], "leftThumbMetacarpal");
  EXPECT_EQ(kTailNames[kTailRightThumb], "rightThumbMetacarpal");
  EXPECT_EQ(kTailNames[kTailRightThumb + 14], "rightLittleDistal");
  EXPECT_EQ(kTailNames[kTailJaw], "jaw");
}

}  // namespace
}  // namespace styled::rig
