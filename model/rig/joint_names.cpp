// MapJointNames and MapTailNames: the naming conventions of the field, as tables of aliases.
#include <algorithm>
#include <cctype>
#include <map>
#include <string>
#include <unordered_map>
#include <vector>

#include "model/rig/dialects.h"
#include "model/rig/tail.h"

namespace styled::rig {
namespace {

using body::kJointCount;

// Aliases are lower case without separators, in order of preference.
struct Alias {
  body::Joint joint;
  std::vector<std::string_view> names;
};

// Rigs number spine and chest differently: the first row whose names both exist is used.
struct SpineAlias {
  std::string_view spine, chest;
};
constexpr SpineAlias kSpines[] = {
    {"lowerback", "spine"},      // CMU's BVH files; Spine1 is composed
    {"lowerback", "upperback"},  // CMU's ASF files; thorax is composed
    {"l5", "t12"},               // Xsens; L3 and T8 are composed
    {"ab", "chest"},             // Motive
    {"abdomen", "chest"},
    {"torso2", "torso4"},            // mocopi, of torso_1 to torso_7
    {"spine", "chest"},              // VRM, Rokoko, Bandai-Namco
    {"spine", "spine1"},             // Mixamo, HIK, LaFAN1, Axis, Biped
    {"spine", "spine2"},             // Axis without Spine1
    {"spine01", "spine02"},          // Character Creator
    {"spine", "spine001"},           // numbered by Blender
    {"spine1", "spine2"},            // SMPL
    {"chest", "chest2"},             // Xsens MVN's BVH files; Chest3 and Chest4 are composed
    {"abdomenlower", "chestlower"},  // Daz Genesis; their uppers are composed
};

const std::vector<Alias>& CentreAliases() {
  static const std::vector<Alias> kAliases = {
      {body::kHips, {"hips", "hip", "pelvis"}},
      {body::kNeck, {"neck", "neck1", "neck01", "lowerneck", "necktwist01", "necklower"}},
      {body::kHead, {"head", "face"}},  // used if no joint is called head
  };
  return kAliases;
}

// Names without their side.
const std::vector<Alias>& LeftAliases() {
  static const std::vector<Alias> kAliases = {
      {body::kLeftShoulder, {"shoulder", "clavicle", "collar"}},
      {body::kLeftUpperArm, {"upperarm", "arm", "uarm", "uparm", "humerus", "shldr", "shldrbend"}},
      {body::kLeftLowerArm, {"lowerarm", "forearm", "farm", "lowarm", "radius", "forearmbend"}},
      {body::kLeftHand, {"hand", "wrist"}},
      {body::kLeftUpperLeg, {"upperleg", "upleg", "thigh", "femur", "thighbend"}},
      {body::kLeftLowerLeg, {"lowerleg", "lowleg", "leg", "shin", "calf", "tibia"}},
      {body::kLeftFoot, {"foot"}},
      {body::kLeftToes, {"toes", "toe", "toebase", "toe0", "ball"}},
  };
  return kAliases;
}

// SMPL and MVN's BVH files name a limb by the joint above it, not by the bone: their "shoulder" is
// the upper arm's joint, their "foot" the toes'.
const std::vector<Alias>& JointWiseLeftAliases() {
  static const std::vector<Alias> kAliases = {
      {body::kLeftShoulder, {"collar"}}, {body::kLeftUpperArm, {"shoulder"}},
      {body::kLeftLowerArm, {"elbow"}},  {body::kLeftHand, {"wrist"}},
      {body::kLeftUpperLeg, {"hip"}},    {body::kLeftLowerLeg, {"knee"}},
      {body::kLeftFoot, {"ankle"}},      {body::kLeftToes, {"foot", "toe", "toes"}},
  };
  return kAliases;
}

// One way to name the three joints of a finger, from the hand outwards.
struct FingerAlias {
  std::array<std::string_view, kFingerJoints> names;
  bool first_two;  // both must exist: numbers and abbreviations mean other things elsewhere
};
// Thumb, index, middle, ring, little: the words for it, and names that no word makes.
struct FingerNames {
  std::vector<std::string_view> words;
  std::vector<FingerAlias> others;
};
const std::array<FingerNames, kFingersPerHand>& Fingers() {
  static const std::array<FingerNames, kFingersPerHand> kFingers = {{
      {{"thumb", "handthumb"},
       {{{"firstmc", "firstpp", "firstdp"}, true}, {{"finger0", "finger01", "finger02"}, true}}},
      {{"index", "handindex", "findex", "indexfinger"},
       {{{"secondpp", "secondmp", "seconddp"}, true}, {{"finger1", "finger11", "finger12"}, true}}},
      {{"middle", "handmiddle", "fmiddle", "middlefinger", "mid"},
       {{{"thirdpp", "thirdmp", "thirddp"}, true}, {{"finger2", "finger21", "finger22"}, true}}},
      {{"ring", "handring", "fring", "ringfinger"},
       {{{"fourthpp", "fourthmp", "fourthdp"}, true}, {{"finger3", "finger31", "finger32"}, true}}},
      {{"little", "handlittle", "littlefinger", "pinky", "handpinky", "fpinky", "pinkyfinger"},
       {{{"fifthpp", "fifthmp", "fifthdp"}, true}, {{"finger4", "finger41", "finger42"}, true}}},
  }};
  return kFingers;
}
constexpr FingerAlias kThumbEndings[] = {
    {{"metacarpal", "proximal", "distal"}, false},    // VRM 1.0
    {{"proximal", "intermediate", "distal"}, false},  // Unity, VRM 0.x
    {{"proximal", "medial", "distal"}, false},        // Rokoko
    {{"1", "2", "3"}, true},
    {{"01", "02", "03"}, true},
};
constexpr FingerAlias kFingerEndings[] = {
    {{"proximal", "intermediate", "distal"}, false},
    {{"proximal", "medial", "distal"}, false},
    {{"1", "2", "3"}, true},
    {{"01", "02", "03"}, true},
};

bool IsSeparator(char c) { return c == '_' || c == ' ' || c == '-' || c == '.'; }

// The length of the prefix, up to and including a separator, that all names share ("Skeleton_",
// "J_Bip_").
std::size_t CommonPrefix(const std::vector<std::string>& names) {
  if (names.size() < 3) return 0;
  std::size_t common = names[0].size();
  for (const std::string& name : names) {
    std::size_t same = 0;
    while (same < common && same < name.size() && name[same] == names[0][same]) ++same;
    common = same;
  }
  while (common > 0 && !IsSeparator(names[0][common - 1])) --common;
  return common;
}

std::string Fold(std::string_view name) {
  std::string folded;
  for (char c : name) {
    if (!IsSeparator(c)) {
      folded += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    }
  }
  return folded;
}

// Drops what exporters write before the joint's own name.
std::string_view StripPrefix(std::string_view folded) {
  if (folded.starts_with("mixamorig")) {
    folded.remove_prefix(9);
    while (!folded.empty() && std::isdigit(static_cast<unsigned char>(folded[0])) != 0) {
      folded.remove_prefix(1);
    }
    return folded;
  }
  for (std::string_view prefix : {"valvebiped", "jbip", "bip001", "bip01", "bip", "ccbase"}) {
    if (folded.starts_with(prefix) && folded.size() > prefix.size()) {
      folded.remove_prefix(prefix.size());
    }
  }
  return folded;
}

class NameTable {
 public:
  explicit NameTable(const Skeleton& skeleton) {
    std::vector<std::string> names = skeleton.names;
    for (std::string& name : names) name.erase(0, name.rfind(':') + 1);  // npos + 1 is 0
    const std::size_t prefix = CommonPrefix(names);
    for (std::size_t joint = 0; joint < names.size(); ++joint) {
      const std::string folded = Fold(std::string_view(names[joint]).substr(prefix));
      joints_.emplace(std::string(StripPrefix(folded)), static_cast<int>(joint));
    }
    for (const auto& [name, joint] : joints_) {
      AddSided(name, joint, "left", "l", left_);
      AddSided(name, joint, "right", "r", right_);
    }
  }

  // The joint of that name, the first in file order if there are two; -1 if there is none.
  int Find(const std::string& name) const {
    const auto found = joints_.find(name);
    return found == joints_.end() ? -1 : found->second;
  }
  int FindCentre(std::string_view base) const {
    const int joint = Find(std::string(base));
    return joint >= 0 ? joint : Find(std::string("c").append(base));
  }
  int FindSided(std::string_view base, bool left) const {
    const Sides& sides = left ? left_ : right_;
    const auto found = sides.find(base);
    return found == sides.end() ? -1 : found->second.joint;
  }

 private:
  struct Sided {
    int joint, rank;  // the lowest rank is preferred: of leftArm, armLeft, lArm, armL the first
  };
  struct Hash : std::hash<std::string_view> {
    using is_transparent = void;
  };
  // By the name without its side.
  using Sides = std::unordered_map<std::string, Sided, Hash, std::equal_to<>>;

  // A binding looks for some 400 names of fingers, so that they are taken apart once.
  static void AddSided(std::string_view name, int joint, std::string_view word,
                       std::string_view letter, Sides& sides) {
    const auto add = [&](std::string_view base, int rank) {
      const auto [place, is_new] = sides.try_emplace(std::string(base), Sided{joint, rank});
      if (!is_new && rank < place->second.rank) place->second = {joint, rank};
    };
    int rank = 0;
    for (const std::string_view side : {word, letter}) {
      if (name.starts_with(side)) add(name.substr(side.size()), rank);
      if (name.ends_with(side)) add(name.substr(0, name.size() - side.size()), rank + 1);
      rank += 2;
    }
  }

  std::map<std::string, int> joints_;
  Sides left_, right_;
};

using FingerJoints = std::array<int, kFingerJoints>;

// The joints of one finger by the way of naming that finds most of them.
FingerJoints FindFinger(const NameTable& table, int finger, bool left) {
  FingerJoints best{-1, -1, -1};
  std::ptrdiff_t most = 0;
  std::string name;
  const auto look = [&](std::string_view word, const FingerAlias& alias) {
    FingerJoints found;
    for (std::size_t i = 0; i < found.size(); ++i) {
      found[i] = table.FindSided(name.assign(word).append(alias.names[i]), left);
    }
    const auto count = std::count_if(found.begin(), found.end(), [](int j) { return j >= 0; });
    if (count <= most || (alias.first_two && (found[0] < 0 || found[1] < 0))) return;
    best = found;
    most = count;
  };
  const FingerNames& names = Fingers()[static_cast<std::size_t>(finger)];
  for (const std::string_view word : names.words) {
    if (finger == 0) {
      for (const FingerAlias& alias : kThumbEndings) look(word, alias);
    } else {
      for (const FingerAlias& alias : kFingerEndings) look(word, alias);
    }
  }
  for (const FingerAlias& alias : names.others) look("", alias);
  return best;
}

}  // namespace

TailMap MapTailNames(const Skeleton& skeleton) {
  const NameTable table(skeleton);
  TailMap map = NoTail();
  for (const bool left : {true, false}) {
    int joint = left ? kTailLeftThumb : kTailRightThumb;
    for (int finger = 0; finger < kFingersPerHand; ++finger) {
      for (const int found : FindFinger(table, finger, left)) {
        map[static_cast<std::size_t>(joint++)] = found;
      }
    }
    int& eye = map[left ? kTailLeftEye : kTailRightEye];
    for (const std::string_view name : {"eye", "eyeball", "faceeye", "eyesmplhf"}) {
      if (eye < 0) eye = table.FindSided(name, left);
    }
  }
  for (const std::string_view name : {"jaw", "jawroot", "lowerjaw"}) {
    if (map[kTailJaw] < 0) map[kTailJaw] = table.FindCentre(name);
  }
  return map;
}

std::array<int, kJointCount> MapJointNames(const Skeleton& skeleton) {
  const NameTable table(skeleton);
  std::array<int, kJointCount> map;
  map.fill(-1);

  for (const Alias& alias : CentreAliases()) {
    for (std::string_view name : alias.names) {
      if (map[alias.joint] < 0) map[alias.joint] = table.FindCentre(name);
    }
  }
  // mocopi calls its hips "root"; "torso_1" identifies mocopi.
  if (map[body::kHips] < 0 && table.Find("torso1") >= 0) map[body::kHips] = table.Find("root");

  for (const SpineAlias& alias : kSpines) {
    const int spine = table.FindCentre(alias.spine);
    const int chest = table.FindCentre(alias.chest);
    if (spine < 0 || chest < 0) continue;
    map[body::kSpine] = spine;
    map[body::kChest] = chest;
    break;
  }
  // Skeletons with a single spine joint.
  if (map[body::kSpine] < 0) map[body::kSpine] = table.FindCentre("spine");
  for (std::string_view name : {"chest", "upperchest", "thorax"}) {
    if (map[body::kChest] < 0) map[body::kChest] = table.FindCentre(name);
  }

  const bool joint_wise = table.FindSided("knee", true) >= 0 && table.FindSided("ankle", true) >= 0;
  for (const Alias& alias : joint_wise ? JointWiseLeftAliases() : LeftAliases()) {
    for (bool left : {true, false}) {
      int& joint = map[left ? alias.joint : body::MirrorJoint(alias.joint)];
      for (std::string_view name : alias.names) {
        if (joint < 0) joint = table.FindSided(name, left);
      }
    }
  }
  return map;
}

Result<JointNames> ParseJoints(const std::string& option, const std::vector<std::string>& texts) {
  JointNames joints;
  for (const std::string& text : texts) {
    const std::size_t equals = text.find('=');
    if (equals == 0 || equals == std::string::npos) {
      return Status::Error(option + ": '" + text + "': expected CANONICAL=NAME");
    }
    joints.emplace_back(text.substr(0, equals), text.substr(equals + 1));
  }
  return joints;
}

}  // namespace styled::rig
