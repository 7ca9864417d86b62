#include "model/rig/name_reading.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <unordered_map>

namespace styled::rig {
namespace {

constexpr std::uint16_t Bit(Part part) {
  return static_cast<std::uint16_t>(1U << static_cast<unsigned>(part));
}
constexpr std::uint16_t kHips = Bit(Part::kHips), kSpine = Bit(Part::kSpine),
                        kChest = Bit(Part::kChest), kNeck = Bit(Part::kNeck),
                        kHead = Bit(Part::kHead), kShoulder = Bit(Part::kShoulder),
                        kUpperArm = Bit(Part::kUpperArm), kLowerArm = Bit(Part::kLowerArm),
                        kHand = Bit(Part::kHand), kUpperLeg = Bit(Part::kUpperLeg),
                        kLowerLeg = Bit(Part::kLowerLeg), kFoot = Bit(Part::kFoot),
                        kToes = Bit(Part::kToes);

// A word and the parts that tools call by it. Many words have two meanings; the tree decides.
struct Word {
  std::string_view text;
  std::uint16_t parts;
};
constexpr Word kWords[] = {
    {"hips", kHips},
    {"hip", kHips | kUpperLeg},
    {"pelvis", kHips},
    {"root", kHips},
    {"roothips", kHips},
    {"center", kHips},
    {"centre", kHips},
    {"cog", kHips},
    {"waist", kHips | kSpine},
    {"hipcenter", kHips},
    {"spinebase", kHips},
    {"lowerbody", kHips},
    {"spine", kSpine | kChest},
    {"spinelower", kSpine},
    {"lowerspine", kSpine},
    {"spinemid", kSpine | kChest},
    {"spinemiddle", kSpine | kChest},
    {"middlespine", kSpine | kChest},
    {"spineupper", kSpine | kChest},
    {"upperspine", kChest},
    {"spineshoulder", kChest},
    {"shouldercenter", kChest | kNeck},
    {"spinechest", kChest},
    {"spinenaval", kSpine},
    {"lowerback", kSpine},
    {"back", kSpine | kChest},
    {"upperback", kChest},
    {"abdomen", kSpine},
    {"abdomenlower", kSpine},
    {"abdomenupper", kSpine | kChest},
    {"ab", kSpine},
    {"belly", kSpine},
    {"lumbar", kSpine},
    {"torso", kSpine | kChest},
    {"upperbody", kSpine | kChest},
    {"trunk", kSpine | kChest},
    {"chest", kChest | kSpine},
    {"chestlower", kChest},
    {"chestupper", kChest},
    {"upperchest", kChest},
    {"thorax", kChest},
    {"ribs", kChest},
    {"ribcage", kChest},
    {"neck", kNeck},
    {"necklower", kNeck},
    {"lowerneck", kNeck},
    {"neckupper", kNeck},
    {"upperneck", kNeck},
    {"necktwist", kNeck},
    {"headnecklower", kNeck},
    {"headneckupper", kHead | kNeck},
    {"cervical", kNeck},
    {"head", kHead},
    {"skull", kHead},
    {"face", kHead},
    {"shoulder", kShoulder | kUpperArm},
    {"clavicle", kShoulder},
    {"clav", kShoulder},
    {"collar", kShoulder},
    {"collarbone", kShoulder},
    {"scapula", kShoulder},
    {"arm", kUpperArm},
    {"upperarm", kUpperArm},
    {"uparm", kUpperArm},
    {"uarm", kUpperArm},
    {"armupper", kUpperArm},
    {"humerus", kUpperArm},
    {"shldr", kUpperArm},
    {"shldrbend", kUpperArm},
    {"bicep", kUpperArm},
    {"forearm", kLowerArm},
    {"forearmbend", kLowerArm},
    {"lowerarm", kLowerArm},
    {"lowarm", kLowerArm},
    {"farm", kLowerArm},
    {"armlower", kLowerArm},
    {"elbow", kLowerArm},
    {"ulna", kLowerArm},
    {"radius", kLowerArm},
    {"hand", kHand},
    {"wrist", kHand},
    {"palm", kHand},
    {"thigh", kUpperLeg},
    {"thighbend", kUpperLeg},
    {"upleg", kUpperLeg},
    {"upperleg", kUpperLeg},
    {"legupper", kUpperLeg},
    {"femur", kUpperLeg},
    {"leg", kUpperLeg | kLowerLeg},
    {"shin", kLowerLeg},
    {"calf", kLowerLeg},
    {"lowerleg", kLowerLeg},
    {"lowleg", kLowerLeg},
    {"leglower", kLowerLeg},
    {"knee", kLowerLeg},
    {"tibia", kLowerLeg},
    {"foot", kFoot | kToes},
    {"ankle", kFoot},
    {"talus", kFoot},
    {"calcn", kFoot | kToes},
    {"toe", kToes},
    {"toes", kToes},
    {"toebase", kToes},
    {"ball", kToes},
};

// Words that no joint of the humanoid has.
constexpr std::string_view kOthers[] = {
    "ik",      "pole",   "target",   "ctrl",   "control", "helper", "hair",       "skirt",
    "breast",  "bust",   "boob",     "tail",   "wing",    "ear",    "eye",        "eyes",
    "eyelid",  "jaw",    "teeth",    "tongue", "brow",    "lip",    "mouth",      "cheek",
    "nose",    "thumb",  "index",    "middle", "ring",    "little", "pinky",      "finger",
    "weapon",  "sword",  "prop",     "hat",    "cape",    "cloak",  "cloth",      "belt",
    "ribbon",  "sleeve", "tie",      "socket", "attach",  "camera", "metacarpal", "heel",
    "buttock", "light",  "gun",      "shield", "bag",     "horn",   "feather",    "jiggle",
    "dummy",   "marker", "hipjoint", "offset"};
constexpr std::string_view kEnds[] = {"end", "nub", "tip", "leaf", "site"};
constexpr std::string_view kTwists[] = {"twist", "roll"};
// Words that tools write around the part.
constexpr std::string_view kNoise[] = {
    "def",   "org", "mch",        "jnt",     "bone",      "bn",       "skel", "bip", "base",
    "cc",    "rig", "cf",         "j",       "mixamorig", "armature", "x",    "m",   "c",
    "valve", "b",   "valvebiped", "stretch", "bnd",       "sk",       "grp"};

struct Side {
  std::string_view text;
  int side;
};
constexpr Side kSides[] = {{"left", 1}, {"right", -1}, {"l", 1},   {"r", -1},
                           {"lt", 1},   {"rt", -1},    {"lft", 1}, {"rgt", -1}};

// Japanese (MMD's standard bones) and Chinese, looked for within the name, the longest first.
struct Sign {
  std::string_view text;
  std::uint16_t parts;
  bool other = false;
};
constexpr Sign kSigns[] = {
    {"上半身", kSpine | kChest},
    {"下半身", kHips},
    {"センター", kHips},
    {"グルーブ", 0, true},
    {"全ての親", 0, true},
    {"ＩＫ", 0, true},
    {"骨盆", kHips},
    {"臀", kHips},
    {"腰", kHips | kSpine},
    {"脊", kSpine | kChest},
    {"胸", kChest},
    {"首", kNeck},  // 手首 and 足首 are longer
    {"颈", kNeck},
    {"頸", kNeck},
    {"頭", kHead},
    {"头", kHead},
    {"肩", kShoulder},
    {"锁骨", kShoulder},
    {"上臂", kUpperArm},
    {"腕", kUpperArm},
    {"ひじ", kLowerArm},
    {"肘", kLowerArm},
    {"前臂", kLowerArm},
    {"手首", kHand},
    {"手腕", kHand},
    {"手", kHand},
    {"大腿", kUpperLeg},
    {"ひざ", kLowerLeg},
    {"膝", kLowerLeg},
    {"小腿", kLowerLeg},
    {"足首", kFoot},
    {"脚踝", kFoot},
    {"踝", kFoot},
    {"脚趾", kToes},
    {"つま先", kToes},
    {"足先", kToes},
    {"足", kUpperLeg | kFoot},  // a leg in Japanese, a foot in Chinese
    {"脚", kFoot | kUpperLeg},
    {"親指", 0, true},
    {"指", 0, true},
    {"目", 0, true},
    {"髪", 0, true},
    {"スカート", 0, true},
    {"捩", 0, true},
};

std::string Lower(std::string_view text) {
  std::string lower(text);
  for (char& c : lower) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return lower;
}

bool IsAlpha(char c) { return std::isalpha(static_cast<unsigned char>(c)) != 0; }
bool IsUpper(char c) { return std::isupper(static_cast<unsigned char>(c)) != 0; }

// The words of a name in lower case, without numbers: "LHipJoint_07" is l, hip, joint.
std::vector<std::string> Split(std::string_view name) {
  std::vector<std::string> words;
  std::string word;
  const auto end = [&] {
    if (!word.empty()) words.push_back(Lower(word));
    word.clear();
  };
  for (std::size_t i = 0; i < name.size(); ++i) {
    if (!IsAlpha(name[i])) {
      end();
      continue;
    }
    const bool begins = i > 0 && IsUpper(name[i]) &&
                        (!IsUpper(name[i - 1]) ||
                         (i + 1 < name.size() && IsAlpha(name[i + 1]) && !IsUpper(name[i + 1])));
    if (begins) end();
    word += name[i];
  }
  end();
  return words;
}

template <typename List>
bool Contains(const List& list, std::string_view word) {
  return std::find(std::begin(list), std::end(list), word) != std::end(list);
}

std::uint16_t PartsOf(std::string_view word) {
  static const auto* const kTable = [] {
    auto* table = new std::unordered_map<std::string_view, std::uint16_t>();
    for (const Word& row : kWords) table->emplace(row.text, row.parts);
    return table;
  }();
  const auto found = kTable->find(word);
  return found == kTable->end() ? 0 : found->second;
}

int SideOf(std::string_view word) {
  for (const Side& row : kSides) {
    if (row.text == word) return row.side;
  }
  return 0;
}

// "lclavicle", "forearmr", "leftupleg": a side at either end of a word of the table.
bool SplitSide(const std::string& word, std::string& rest, int& side) {
  for (const Side& row : kSides) {
    if (word.size() <= row.text.size()) continue;
    for (const bool front : {true, false}) {
      if (front ? !word.starts_with(row.text) : !word.ends_with(row.text)) continue;
      std::string without =
          front ? word.substr(row.text.size()) : word.substr(0, word.size() - row.text.size());
      if (PartsOf(without) == 0) continue;
      rest = std::move(without);
      side = row.side;
      return true;
    }
  }
  return false;
}

void ReadSigns(std::string_view name, NameReading& reading) {
  if (name.find("左") != std::string_view::npos) reading.side = 1;
  if (name.find("右") != std::string_view::npos) reading.side = -1;
  std::size_t longest = 0;
  for (const Sign& sign : kSigns) {
    if (sign.text.size() <= longest || name.find(sign.text) == std::string_view::npos) continue;
    longest = sign.text.size();
    reading.words = reading.hints = sign.parts;
    reading.other = sign.other;
  }
}

// `joints`: the word "joint" is in most names of the skeleton. In a few it is a helper's: CMU's
// "LHipJoint" lies between the hips and the upper leg.
NameReading ReadOne(std::string_view name, bool joints) {
  NameReading reading;
  std::string whole, with_noise;
  for (std::string word : Split(name)) {
    if (Contains(kNoise, word) || (joints && word == "joint")) {
      with_noise += word;
      continue;
    }
    int side = SideOf(word);
    if (side == 0 && word.size() == 1) continue;  // "A_Hips", "Skel1_b_Arm"
    if (side == 0 && PartsOf(word) == 0) {
      std::string rest;
      if (SplitSide(word, rest, side)) word = rest;
    } else if (side != 0) {
      word.clear();
    }
    if (side != 0) reading.side = side;
    if (word.empty()) continue;
    if (Contains(kOthers, word)) reading.other = true;
    if (Contains(kEnds, word)) reading.end = true;
    if (Contains(kTwists, word)) reading.twist = true;
    reading.hints |= PartsOf(word);
    whole += word;
    with_noise += word;
  }
  reading.words = PartsOf(with_noise);  // "SpineBase", Kinect's hips
  if (reading.words == 0) reading.words = PartsOf(whole);
  if (Contains(kOthers, whole)) reading.other = true;
  reading.hints |= reading.words;
  // A neck that tools call "NeckTwist", a "MiddleSpine".
  if (reading.words != 0) reading.twist = reading.other = reading.end = false;
  const bool ascii = std::all_of(name.begin(), name.end(),
                                 [](char c) { return static_cast<unsigned char>(c) < 0x80; });
  if (!ascii) ReadSigns(name, reading);
  return reading;
}

bool IsNoLetterOrDigit(char c) {
  return !IsAlpha(c) && std::isdigit(static_cast<unsigned char>(c)) == 0;
}

// The length of the prefix, up to and including a sign, that all names share ("Skeleton_").
std::size_t CommonPrefix(const std::vector<std::string_view>& names) {
  if (names.size() < 3) return 0;
  std::size_t common = names[0].size();
  for (const std::string_view name : names) {
    std::size_t same = 0;
    while (same < common && same < name.size() && name[same] == names[0][same]) ++same;
    common = same;
  }
  while (common > 0 && (!IsNoLetterOrDigit(names[0][common - 1]) ||
                        static_cast<unsigned char>(names[0][common - 1]) >= 0x80)) {
    --common;
  }
  return common;
}

}  // namespace

std::vector<NameReading> ReadNames(const std::vector<std::string>& names) {
  std::vector<std::string_view> own;
  own.reserve(names.size());
  for (const std::string_view name : names) {
    own.push_back(name.substr(name.find_last_of(":|") + 1));  // npos + 1 is 0
  }
  const std::size_t prefix = CommonPrefix(own);
  std::vector<NameReading> readings;
  readings.reserve(names.size());
  const auto with_joint = std::count_if(own.begin(), own.end(), [](std::string_view name) {
    return Lower(name).find("joint") != std::string::npos;
  });
  const bool joints = 2 * static_cast<std::size_t>(with_joint) > own.size();
  for (const std::string_view name : own) readings.push_back(ReadOne(name.substr(prefix), joints));
  return readings;
}

}  // namespace styled::rig
