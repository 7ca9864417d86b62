#pragma once

#include <algorithm>
#include <array>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "model/body/humanoid.h"
#include "model/rig/skeleton.h"

// Bodies as tools of all kinds name and build them, with the right answer.
namespace styled::rig {

// One way to name the joints: in canonical order, "@" for the side.
struct Convention {
  std::string tool;
  std::array<std::string, 13> names;  // the middle, then one arm and one leg
  std::string left, right;
};
inline const std::vector<Convention>& Conventions() {
  static const std::vector<Convention> kConventions = {
      {"VRM",
       {"hips", "spine", "chest", "neck", "head", "@Shoulder", "@UpperArm", "@LowerArm", "@Hand",
        "@UpperLeg", "@LowerLeg", "@Foot", "@Toes"},
       "left",
       "right"},
      {"Mixamo",
       {"mixamorig:Hips", "mixamorig:Spine", "mixamorig:Spine1", "mixamorig:Neck", "mixamorig:Head",
        "mixamorig:@Shoulder", "mixamorig:@Arm", "mixamorig:@ForeArm", "mixamorig:@Hand",
        "mixamorig:@UpLeg", "mixamorig:@Leg", "mixamorig:@Foot", "mixamorig:@ToeBase"},
       "Left",
       "Right"},
      {"Mixamo, copied in Blender",
       {"mixamorig:Hips.001", "mixamorig:Spine.001", "mixamorig:Spine1.001", "mixamorig:Neck.001",
        "mixamorig:Head.001", "mixamorig:@Shoulder.001", "mixamorig:@Arm.001",
        "mixamorig:@ForeArm.001", "mixamorig:@Hand.001", "mixamorig:@UpLeg.001",
        "mixamorig:@Leg.001", "mixamorig:@Foot.001", "mixamorig:@ToeBase.001"},
       "Left",
       "Right"},
      {"Mixamo, from Sketchfab",
       {"mixamorig:Hips_00", "mixamorig:Spine_01", "mixamorig:Spine1_02", "mixamorig:Neck_03",
        "mixamorig:Head_04", "mixamorig:@Shoulder_05", "mixamorig:@Arm_06", "mixamorig:@ForeArm_07",
        "mixamorig:@Hand_08", "mixamorig:@UpLeg_09", "mixamorig:@Leg_10", "mixamorig:@Foot_11",
        "mixamorig:@ToeBase_12"},
       "Left",
       "Right"},
      {"Rigify, metarig",
       {"spine", "spine.001", "spine.003", "spine.004", "spine.006", "shoulder.@", "upper_arm.@",
        "forearm.@", "hand.@", "thigh.@", "shin.@", "foot.@", "toe.@"},
       "L",
       "R"},
      {"Rigify, DEF",
       {"DEF-spine", "DEF-spine.001", "DEF-spine.003", "DEF-spine.004", "DEF-spine.006",
        "DEF-shoulder.@", "DEF-upper_arm.@", "DEF-forearm.@", "DEF-hand.@", "DEF-thigh.@",
        "DEF-shin.@", "DEF-foot.@", "DEF-toe.@"},
       "L",
       "R"},
      {"Auto-Rig Pro",
       {"root.x", "spine_01.x", "spine_02.x", "neck.x", "head.x", "shoulder.@", "arm_stretch.@",
        "forearm_stretch.@", "hand.@", "thigh_stretch.@", "leg_stretch.@", "foot.@", "toes_01.@"},
       "l",
       "r"},
      {"CATS, VRChat",
       {"Hips", "Spine", "Chest", "Neck", "Head", "@ shoulder", "@ arm", "@ elbow", "@ wrist",
        "@ leg", "@ knee", "@ ankle", "@ toe"},
       "Left",
       "Right"},
      {"MMD",
       {"センター", "上半身", "上半身2", "首", "頭", "@肩", "@腕", "@ひじ", "@手首", "@足", "@ひざ",
        "@足首", "@つま先"},
       "左",
       "右"},
      {"MMD, translated",
       {"center", "upper body", "upper body2", "neck", "head", "shoulder_@", "arm_@", "elbow_@",
        "wrist_@", "leg_@", "knee_@", "ankle_@", "toe_@"},
       "L",
       "R"},
      {"DeepMotion",
       {"hips_JNT", "spine_JNT", "spine1_JNT", "neck_JNT", "head_JNT", "@_shoulder_JNT",
        "@_arm_JNT", "@_foreArm_JNT", "@_hand_JNT", "@_upLeg_JNT", "@_leg_JNT", "@_foot_JNT",
        "@_toeBase_JNT"},
       "l",
       "r"},
      {"SOMA",
       {"Hips", "Spine1", "Chest", "Neck1", "Head", "@Shoulder", "@Arm", "@ForeArm", "@Hand",
        "@Leg", "@Shin", "@Foot", "@ToeBase"},
       "Left",
       "Right"},
      {"iPi",
       {"Hip", "LowerSpine", "Chest", "Neck", "Head", "@Clavicle", "@Shoulder", "@Forearm", "@Hand",
        "@Thigh", "@Shin", "@Foot", "@Toe"},
       "L",
       "R"},
      {"MakeHuman",
       {"root", "spine05", "spine03", "neck01", "head", "clavicle.@", "upperarm01.@",
        "lowerarm01.@", "wrist.@", "upperleg01.@", "lowerleg01.@", "foot.@", "toe1-1.@"},
       "L",
       "R"},
      {"AdvancedSkeleton",
       {"Root_M", "Spine1_M", "Chest_M", "Neck_M", "Head_M", "Scapula_@", "Shoulder_@", "Elbow_@",
        "Wrist_@", "Hip_@", "Knee_@", "Ankle_@", "Toes_@"},
       "L",
       "R"},
      {"OpenSim",
       {"pelvis", "lumbar", "torso", "cervical", "head", "clavicle_@", "humerus_@", "ulna_@",
        "hand_@", "femur_@", "tibia_@", "talus_@", "toes_@"},
       "l",
       "r"},
      {"Biped",
       {"Bip001 Pelvis", "Bip001 Spine", "Bip001 Spine1", "Bip001 Neck", "Bip001 Head",
        "Bip001 @ Clavicle", "Bip001 @ UpperArm", "Bip001 @ Forearm", "Bip001 @ Hand",
        "Bip001 @ Thigh", "Bip001 @ Calf", "Bip001 @ Foot", "Bip001 @ Toe0"},
       "L",
       "R"},
      {"XNALara",
       {"root hips", "spine lower", "spine upper", "head neck lower", "head neck upper",
        "arm @ shoulder 1", "arm @ shoulder 2", "arm @ elbow", "arm @ wrist", "leg @ thigh",
        "leg @ knee", "leg @ ankle", "leg @ toes"},
       "left",
       "right"},
      {"Koikatsu",
       {"cf_j_hips", "cf_j_spine01", "cf_j_spine02", "cf_j_neck", "cf_j_head", "cf_j_shoulder_@",
        "cf_j_arm00_@", "cf_j_forearm01_@", "cf_j_hand_@", "cf_j_thigh00_@", "cf_j_leg01_@",
        "cf_j_foot_@", "cf_j_toes_@"},
       "L",
       "R"},
      {"CMU's ASF",
       {"root", "lowerback", "upperback", "neck", "head", "@clavicle", "@humerus", "@radius",
        "@hand", "@femur", "@tibia", "@foot", "@toes"},
       "l",
       "r"},
      {"SMPL",
       {"pelvis", "spine1", "spine2", "neck", "head", "@_collar", "@_shoulder", "@_elbow",
        "@_wrist", "@_hip", "@_knee", "@_ankle", "@_foot"},
       "left",
       "right"},
      {"Unreal",
       {"pelvis", "spine_01", "spine_02", "neck_01", "head", "clavicle_@", "upperarm_@",
        "lowerarm_@", "hand_@", "thigh_@", "calf_@", "foot_@", "ball_@"},
       "l",
       "r"},
      {"shoulder, arm, elbow",
       {"Hips", "Spine", "Chest", "Neck", "Head", "@Shoulder", "@Arm", "@Elbow", "@Wrist", "@Hip",
        "@Knee", "@Ankle", "@Toe"},
       "Left",
       "Right"},
      {"Chinese",
       {"骨盆", "脊柱", "胸", "颈", "头", "@肩", "@上臂", "@前臂", "@手", "@大腿", "@小腿", "@脚",
        "@脚趾"},
       "左",
       "右"},
      {"Bandai-Namco",
       {"Hips", "Spine", "Chest", "Neck", "Head", "Shoulder_@", "UpperArm_@", "LowerArm_@",
        "Hand_@", "UpperLeg_@", "LowerLeg_@", "Foot_@", "Toes_@"},
       "L",
       "R"},
      {"Daz Genesis",
       {"hip", "abdomenLower", "chestLower", "neckLower", "head", "@Collar", "@ShldrBend",
        "@ForearmBend", "@Hand", "@ThighBend", "@Shin", "@Foot", "@Toe"},
       "l",
       "r"},
      {"numbered",
       {"joint_0", "joint_1", "joint_2", "joint_3", "joint_4", "joint_5@", "joint_6@", "joint_7@",
        "joint_8@", "joint_9@", "joint_10@", "joint_11@", "joint_12@"},
       "0",
       "1"},
      {"words that mean nothing",
       {"alpha", "beta", "gamma", "delta", "epsilon", "zeta@", "eta@", "theta@", "iota@", "kappa@",
        "lambda@", "mu@", "nu@"},
       "P",
       "Q"},
  };
  return kConventions;
}

// The name of canonical joint c.
inline std::string NameBy(const Convention& convention, int c) {
  const bool right = body::MirrorJoint(c) < c;
  int place = right ? body::MirrorJoint(c) : c;
  if (place >= body::kLeftUpperLeg) place -= 4;  // the table has one arm
  std::string name = convention.names[static_cast<std::size_t>(place)];
  if (const auto at = name.find('@'); at != std::string::npos) {
    name.replace(at, 1, right ? convention.right : convention.left);
  }
  return name;
}

struct RandomBody {
  Skeleton skeleton;
  std::array<int, body::kJointCount> joint;  // the right answer; spine and chest: one of several
  std::vector<int> trunk;                    // all joints between hips and the arms
  std::string built;                         // how, for messages
  // Sides are exchanged by the names; that can be seen by the toes, or in `pose`, whose knees bend.
  bool sides_swapped = false;
  std::optional<RigPose> pose;
};

// One body of random convention and proportions with random oddities. Pose: a T-pose.
inline RandomBody MakeRandomBody(unsigned seed) {
  std::mt19937 random(seed);
  const auto number = [&](float low, float high) {
    return std::uniform_real_distribution<float>(low, high)(random);
  };
  const auto chance = [&](float p) { return number(0, 1) < p; };
  const auto pick = [&](std::size_t count) { return static_cast<std::size_t>(random() % count); };

  RandomBody body;
  const Convention& convention = Conventions()[pick(Conventions().size())];
  body.built = convention.tool;
  const auto told = [&](bool is, const char* what) {
    if (is) body.built.append(", ").append(what);
    return is;
  };
  const float leg = number(0.85F, 1.2F), arm = number(0.85F, 1.2F), trunk = number(0.85F, 1.2F);
  const float unit = chance(0.5F) ? 1.0F : chance(0.5F) ? 100.0F : 39.37F;
  const bool toes = !told(chance(0.15F), "no toes");
  const bool clavicles = !told(chance(0.15F), "no shoulders");
  const bool neck = !told(chance(0.1F), "no neck");
  const bool twists_inline = told(chance(0.15F), "twists between");
  const bool twists_beside = told(chance(0.2F), "twists beside");
  const bool helpers = told(chance(0.2F), "helpers at the hips");
  const bool fingers = told(chance(0.4F), "fingers");
  const bool nubs = told(chance(0.25F), "ends");
  const bool tail = told(chance(0.15F), "tail");
  const bool hair = told(chance(0.25F), "hair");
  const bool skirt = told(chance(0.15F), "skirt");
  const bool above = told(chance(0.3F), "joints above the hips");
  const bool wings = told(chance(0.1F), "wings");
  const bool two = told(chance(0.05F), "two people");
  const bool shuffled = told(chance(0.08F), "names shuffled");
  body.sides_swapped = told(!shuffled && chance(0.08F), "sides swapped");
  const int spines = chance(0.5F) ? 2 : 1 + static_cast<int>(pick(7));
  if (spines != 2) body.built += ", " + std::to_string(spines) + " spines";

  Skeleton& s = body.skeleton;
  const auto add = [&](const std::string& name, int parent, const Vec3& offset) {
    s.names.push_back(name);
    s.parents.push_back(parent);
    s.offsets.push_back(unit * offset);
    return s.joint_count() - 1;
  };
  const auto build = [&](const std::string& prefix, int root, const Vec3& at, bool answer) {
    std::array<int, body::kJointCount> joint;
    joint.fill(-1);
    const auto name = [&](int c) {
      return prefix + NameBy(convention, body.sides_swapped ? body::MirrorJoint(c) : c);
    };
    const auto rest = [](int c) {
      const auto& row = body::kHumanoid[static_cast<std::size_t>(c)];
      return Vec3(row.x_m, row.y_m, row.z_m);
    };
    joint[body::kHips] = add(name(body::kHips), root, at);
    int last = joint[body::kHips];
    std::vector<int> chain;
    const float step = 0.24F * trunk / static_cast<float>(spines);
    for (int i = 0; i < spines; ++i) {
      const int c = i == 0 ? body::kSpine : i == 1 ? body::kChest : -1;
      std::string own = c >= 0 ? name(c) : name(body::kChest) + "_" + std::to_string(i + 10);
      last = add(own, last, Vec3(0, step, 0));
      chain.push_back(last);
    }
    joint[body::kSpine] = chain[0];
    joint[body::kChest] = spines > 1 ? chain[1] : -1;
    if (answer) body.trunk = chain;
    const int chest = last;
    int head_parent = chest;
    if (neck) {
      head_parent = joint[body::kNeck] = add(name(body::kNeck), chest, trunk * Vec3(0, 0.19F, 0));
    }
    joint[body::kHead] =
        add(name(body::kHead), head_parent, neck ? Vec3(0, 0.08F, 0.01F) : Vec3(0, 0.25F, 0));
    if (nubs) add(prefix + "Head_End", joint[body::kHead], Vec3(0, 0.18F, 0));
    if (hair) {
      for (int lock = 0; lock < 6; ++lock) {
        int from = joint[body::kHead];
        for (int i = 0; i < 4; ++i) {
          from = add(prefix + "hair_" + std::to_string(lock) + "_" + std::to_string(i), from,
                     i == 0 ? Vec3(0.05F * static_cast<float>(lock) - 0.125F, 0.1F, -0.08F)
                            : Vec3(0, -0.07F, -0.01F));
        }
      }
    }
    for (const bool left : {true, false}) {
      const auto side = [&](int c) { return left ? c : body::MirrorJoint(c); };
      const std::string letter = left ? "L" : "R";
      const float x = left ? 1.0F : -1.0F;
      int from = chest;
      Vec3 reach = rest(side(body::kLeftShoulder));
      if (clavicles) {
        from = joint[side(body::kLeftShoulder)] = add(name(side(body::kLeftShoulder)), from, reach);
        reach = Vec3::Zero();
      }
      reach += rest(side(body::kLeftUpperArm));
      for (const int c : {body::kLeftUpperArm, body::kLeftLowerArm, body::kLeftHand}) {
        if (c != body::kLeftUpperArm) reach = arm * rest(side(c));
        if (twists_inline && c != body::kLeftUpperArm) {
          from = add(name(side(c - 1)) + "Twist", from, 0.5F * reach);
          reach *= 0.5F;
        }
        if (twists_beside && c != body::kLeftUpperArm) {
          add(name(side(c - 1)) + "Twist1", from, 0.5F * reach);
        }
        from = joint[side(c)] = add(name(side(c)), from, reach);
      }
      if (fingers) {
        const std::array<std::string, 5> kNames = {"Thumb", "Index", "Middle", "Ring", "Little"};
        for (std::size_t finger = 0; finger < kNames.size(); ++finger) {
          int bone = joint[side(body::kLeftHand)];
          for (int i = 1; i <= 3; ++i) {
            bone = add(prefix + kNames[finger] + std::to_string(i) + "_" + letter, bone,
                       i == 1 ? Vec3(x * 0.08F, 0, 0.03F - 0.02F * static_cast<float>(finger))
                              : Vec3(x * 0.03F, 0, 0));
          }
        }
      } else if (nubs) {
        add(prefix + "Hand_End_" + letter, joint[side(body::kLeftHand)], Vec3(x * 0.15F, 0, 0));
      }
      from = joint[body::kHips];
      reach = rest(side(body::kLeftUpperLeg));
      if (helpers) {
        from = add(prefix + (left ? "LHipJoint" : "RHipJoint"), from, 0.5F * reach);
        reach *= 0.5F;
      }
      for (const int c : {body::kLeftUpperLeg, body::kLeftLowerLeg, body::kLeftFoot}) {
        if (c != body::kLeftUpperLeg) reach = leg * rest(side(c));
        if (twists_beside && c != body::kLeftUpperLeg) {
          add(name(side(c - 1)) + "Twist1", from, 0.5F * reach);
        }
        from = joint[side(c)] = add(name(side(c)), from, reach);
      }
      if (toes)
        from = joint[side(body::kLeftToes)] =
            add(name(side(body::kLeftToes)), from, rest(body::kLeftToes));
      if (nubs) add(prefix + "Toe_End_" + letter, from, Vec3(0, 0, 0.06F));
      if (skirt) {
        for (int piece = 0; piece < 2; ++piece) {
          from = joint[body::kHips];
          for (int i = 0; i < 4; ++i) {
            from = add(prefix + "Skirt_" + letter + std::to_string(piece) + std::to_string(i), from,
                       i == 0 ? Vec3(x * 0.12F, 0, piece == 0 ? 0.1F : -0.1F) : Vec3(0, -0.12F, 0));
          }
        }
      }
      if (wings) {
        from = chest;
        for (int i = 0; i < 4; ++i) {
          from = add(prefix + "Wing" + std::to_string(i) + "_" + letter, from,
                     i == 0 ? Vec3(x * 0.05F, 0.1F, -0.1F) : Vec3(x * 0.25F, 0.05F, -0.05F));
        }
      }
    }
    if (tail) {
      int from = joint[body::kHips];
      for (int i = 0; i < 5; ++i) {
        from = add(prefix + "Tail" + std::to_string(i), from, Vec3(0, -0.05F, -0.12F));
      }
    }
    if (answer) body.joint = joint;
  };
  int root = -1;
  if (above || two) {
    root = add("World", -1, Vec3::Zero());
    if (above && !two) root = add("Motion", root, Vec3::Zero());
  }
  if (two) {
    build("A_", root, Vec3(0, 0.98F, 0), true);
    build("B_", root, Vec3(1, 0.98F, 0), false);
  } else {
    build("", root, Vec3(0, 0.98F, 0), true);
  }
  if (shuffled) std::shuffle(s.names.begin(), s.names.end(), random);

  // Children in another order: a depth-first walk that visits them backwards.
  if (told(chance(0.3F), "children reversed")) {
    std::vector<std::vector<int>> children(s.names.size());
    for (int j = 1; j < s.joint_count(); ++j) {
      children[static_cast<std::size_t>(s.parents[static_cast<std::size_t>(j)])].push_back(j);
    }
    std::vector<int> order, open{0}, place(s.names.size());
    while (!open.empty()) {
      const int joint = open.back();
      open.pop_back();
      place[static_cast<std::size_t>(joint)] = static_cast<int>(order.size());
      order.push_back(joint);
      for (const int child : children[static_cast<std::size_t>(joint)]) open.push_back(child);
    }
    Skeleton turned;
    for (const int joint : order) {
      const auto j = static_cast<std::size_t>(joint);
      turned.names.push_back(s.names[j]);
      turned.parents.push_back(s.parents[j] < 0 ? -1
                                                : place[static_cast<std::size_t>(s.parents[j])]);
      turned.offsets.push_back(s.offsets[j]);
    }
    s = std::move(turned);
    const auto move = [&](int& joint) {
      if (joint >= 0) joint = place[static_cast<std::size_t>(joint)];
    };
    std::for_each(body.joint.begin(), body.joint.end(), move);
    std::for_each(body.trunk.begin(), body.trunk.end(), move);
  }
  if (body.sides_swapped && !toes) {
    body.pose.emplace(s);
    for (const auto& [joint, turn_rad] :
         {std::pair{body::kLeftUpperLeg, -0.4F}, std::pair{body::kRightUpperLeg, -0.4F},
          std::pair{body::kLeftLowerLeg, 0.8F}, std::pair{body::kRightLowerLeg, 0.8F}}) {
      body.pose->rotations[static_cast<std::size_t>(body.joint[static_cast<std::size_t>(joint)])] =
          Quat(Eigen::AngleAxisf(turn_rad, Vec3::UnitX()));
    }
  }
  return body;
}

}  // namespace styled::rig
