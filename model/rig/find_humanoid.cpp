#include "model/rig/find_humanoid.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <tuple>
#include <utility>
#include <vector>

#include "model/base/text.h"
#include "model/rig/body_sides.h"
#include "model/rig/name_reading.h"
#include "model/rig/tree_reading.h"

namespace styled::rig {
namespace {

using body::kJointCount;

// The lead of a reading over the next one, and cosines. These numbers were set by hand; they
// hold on the conventions and random skeletons of the test.
constexpr std::size_t kMaxTree = 1024;      // joints; avatars have hair and skirts
constexpr std::size_t kMaxJointShown = 64;  // bytes of a joint's name in a message
constexpr float kDoubt = 1.0F;              // a lead below this is a question to the user
constexpr float kSecondBody = 12.0F;        // a lead below this over other limbs is mentioned
constexpr float kOpposite = 0.5F;           // of a cosine: two ways to tell sides disagree
// Of 2,000 random bodies the tree alone scores -0.9 at least and 0.6 for 95 of 100; hands with
// their fingers -5 to -12.
constexpr float kImplausible = -3.0F, kPlausible = 0.5F;
constexpr std::ptrdiff_t kFewWords = 5;     // below it names do not outvote the tree
constexpr std::size_t kContradictions = 3;  // names that contradict the tree before it is alone

constexpr JointMap kNone = [] {
  JointMap none{};
  none.fill(-1);
  return none;
}();

// The canonical joint of a limb's place on the left; -1 where the limb has no such part.
constexpr std::array<std::array<int, kPlaces>, 2> kLimbJoints = {
    {{body::kLeftShoulder, body::kLeftUpperArm, body::kLeftLowerArm, body::kLeftHand, -1},
     {-1, body::kLeftUpperLeg, body::kLeftLowerLeg, body::kLeftFoot, body::kLeftToes}}};

std::string NameOf(const Skeleton& skeleton, int joint) {
  return Printable(skeleton.names[static_cast<std::size_t>(joint)], kMaxJointShown);
}
std::string Shown(const Skeleton& skeleton, int joint) {
  return "\"" + NameOf(skeleton, joint) + "\"";
}

// The parts of the canonical joints.
constexpr std::array<Part, kJointCount> kParts = {
    Part::kHips,     Part::kSpine,    Part::kChest,    Part::kNeck,     Part::kHead,
    Part::kShoulder, Part::kUpperArm, Part::kLowerArm, Part::kHand,     Part::kShoulder,
    Part::kUpperArm, Part::kLowerArm, Part::kHand,     Part::kUpperLeg, Part::kLowerLeg,
    Part::kFoot,     Part::kToes,     Part::kUpperLeg, Part::kLowerLeg, Part::kFoot,
    Part::kToes};
// 1 for a joint of the left, -1 of the right, 0 of the middle.
constexpr int SideOf(int c) {
  return c < body::kLeftShoulder ? 0 : body::MirrorJoint(c) > c ? 1 : -1;
}

// The joints whose names say another part, or the other side.
std::vector<int> Contradictions(const JointMap& map, const std::vector<NameReading>& names) {
  std::vector<int> contradicting;
  for (int c = 0; c < kJointCount; ++c) {
    const int joint = map[static_cast<std::size_t>(c)];
    if (joint < 0) continue;
    const NameReading& name = names[static_cast<std::size_t>(joint)];
    const Part part = kParts[static_cast<std::size_t>(c)];
    const bool trunk = IsTrunk(part) && (name.words & kTrunkParts) != 0;
    const bool other = name.other || (name.words != 0 && !name.Says(part) && !name.Hints(part));
    if ((other && !trunk) || name.side * SideOf(c) < 0) contradicting.push_back(joint);
  }
  return contradicting;
}

// The number of joints whose names have a word for their parts.
std::ptrdiff_t Confirmed(const JointMap& map, const std::vector<NameReading>& names) {
  std::ptrdiff_t count = 0;
  for (std::size_t c = 0; c < map.size(); ++c) {
    if (map[c] >= 0 && names[static_cast<std::size_t>(map[c])].Hints(kParts[c])) ++count;
  }
  return count;
}

// Whether names say that a third of the joints are fingers, hair and the like: gloves, not a body.
bool AreHelpers(const JointMap& map, const std::vector<NameReading>& names) {
  std::ptrdiff_t mapped = 0, helpers = 0;
  for (const int joint : map) {
    if (joint < 0) continue;
    ++mapped;
    helpers += names[static_cast<std::size_t>(joint)].other ? 1 : 0;
  }
  return 3 * helpers > mapped;
}

// The joints between the hips and the arms' parent, from the hips on, without hips and neck.
std::vector<int> TrunkOf(const Skeleton& skeleton, const TreeReading& reading) {
  std::vector<int> path;
  for (int up = reading.arms.parent; up != reading.hips && up >= 0;
       up = skeleton.parents[static_cast<std::size_t>(up)]) {
    if (up != reading.neck) path.push_back(up);
  }
  std::reverse(path.begin(), path.end());
  return path;
}

// The length of the way down from a joint to one below it.
float Along(const Skeleton& skeleton, int above, int below) {
  float length = 0;
  for (int up = below; up != above; up = skeleton.parents[static_cast<std::size_t>(up)]) {
    length += skeleton.offsets[static_cast<std::size_t>(up)].norm();
  }
  return length;
}

// Spine and chest among the trunk's joints: by names if both are there, else the joints nearest to
// the places that the canonical humanoid has them at.
void PutTrunk(const Skeleton& skeleton, const TreeReading& found, const JointMap& named,
              const std::vector<NameReading>& names, JointMap& map) {
  std::vector<int> trunk = TrunkOf(skeleton, found);
  std::erase_if(trunk, [&](int joint) { return names[static_cast<std::size_t>(joint)].other; });
  const auto place = [&](int c) {
    return std::find(trunk.begin(), trunk.end(), named[static_cast<std::size_t>(c)]);
  };
  const auto spine = place(body::kSpine), chest = place(body::kChest);
  if (chest != trunk.end() && (spine < chest || trunk.size() == 1)) {
    map[body::kSpine] = spine < chest ? *spine : -1;
    map[body::kChest] = *chest;
    return;
  }
  if (trunk.empty()) return;
  if (trunk.size() == 1) {
    map[body::kSpine] = trunk[0];
    return;
  }
  // The first two of up to three, as tools that have three bend the lower ones.
  constexpr float kChestAt = 0.56F, kSpineAt = 0.3F;  // of the way from the hips to the neck
  std::size_t first = 0, second = 1;
  if (trunk.size() > 3) {
    const int top = found.neck >= 0 ? found.neck : found.head;
    const float length = Along(skeleton, found.hips, top);
    const auto off = [&](std::size_t i, float at) {
      return std::abs(Along(skeleton, found.hips, trunk[i]) - at * length);
    };
    for (std::size_t i = 0; i + 1 < trunk.size(); ++i) {
      if (off(i, kSpineAt) < off(first, kSpineAt)) first = i;
    }
    second = first + 1;
    for (std::size_t i = second; i < trunk.size(); ++i) {
      if (off(i, kChestAt) < off(second, kChestAt)) second = i;
    }
  }
  map[body::kSpine] = trunk[first];
  map[body::kChest] = trunk[second];
}

JointMap MapOf(const Skeleton& skeleton, const TreeReading& found, const JointMap& named,
               const std::vector<NameReading>& names) {
  JointMap map;
  map.fill(-1);
  map[body::kHips] = found.hips;
  map[body::kNeck] = found.neck;
  map[body::kHead] = found.head;
  for (const auto& [kind, pair] : {std::pair{kArm, &found.arms}, std::pair{kLeg, &found.legs}}) {
    for (std::size_t place = 0; place < kPlaces; ++place) {
      const int c = kLimbJoints[kind][place];
      if (c < 0) continue;
      map[static_cast<std::size_t>(c)] = pair->a.joints[place];
      map[static_cast<std::size_t>(body::MirrorJoint(c))] = pair->b.joints[place];
    }
  }
  PutTrunk(skeleton, found, named, names, map);
  return map;
}

// The canonical joint for which two readings differ, of those that a body must have, and the two
// joints; nothing if they agree.
struct Difference {
  int canonical, one, other;
};
std::optional<Difference> Differ(const TreeReading& x, const TreeReading& y) {
  for (const auto& [kind, p, q] :
       {std::tuple{kArm, &x.arms, &y.arms}, std::tuple{kLeg, &x.legs, &y.legs}}) {
    for (const Place place : {kUpper, kLower}) {
      const auto one = std::minmax(p->a.joints[place], p->b.joints[place]);
      const auto other = std::minmax(q->a.joints[place], q->b.joints[place]);
      if (std::pair<int, int>(one) == std::pair<int, int>(other)) continue;
      const bool same_a = p->a.joints[place] == q->a.joints[place];
      const bool same_b = p->b.joints[place] == q->b.joints[place];
      const int left = kLimbJoints[kind][place];
      return same_a && !same_b
                 ? Difference{body::MirrorJoint(left), p->b.joints[place], q->b.joints[place]}
                 : Difference{left, p->a.joints[place], q->a.joints[place]};
    }
  }
  return std::nullopt;
}

bool SameBody(const TreeReading& x, const TreeReading& y) {
  return !Differ(x, y) && x.head == y.head && x.hips == y.hips;
}

bool IsAbove(const Skeleton& skeleton, int above, int joint) {
  while (joint > above) joint = skeleton.parents[static_cast<std::size_t>(joint)];
  return joint == above;
}

// Whether two readings are of two bodies: neither the hips nor a limb of one is a part of the
// other.
bool AreApart(const Skeleton& skeleton, const TreeReading& x, const TreeReading& y) {
  if (IsAbove(skeleton, x.hips, y.hips) || IsAbove(skeleton, y.hips, x.hips)) return false;
  for (const int one : {x.arms.root_a, x.arms.root_b, x.legs.root_a, x.legs.root_b}) {
    for (const int other : {y.arms.root_a, y.arms.root_b, y.legs.root_a, y.legs.root_b}) {
      if (IsAbove(skeleton, one, other) || IsAbove(skeleton, other, one)) return false;
    }
  }
  return x.head != y.head;
}

// Names alone may take joints from anywhere: each bone of a limb must be below the one before it.
Status CheckOrder(const Skeleton& skeleton, const JointMap& map) {
  for (std::size_t c = 0; c < map.size(); ++c) {
    const int parent = body::kHumanoid[c].parent;
    if (SideOf(static_cast<int>(c)) == 0 || SideOf(parent) == 0) continue;
    const int joint = map[c], above = map[static_cast<std::size_t>(parent)];
    if (joint < 0 || above < 0 || IsAbove(skeleton, above, joint)) continue;
    const std::string canonical(body::kHumanoid[c].name);
    const std::string found = Shown(skeleton, joint);
    std::string message = "joints: found ";
    message.append(found).append(" for ").append(canonical);
    message.append(", expected a joint below ").append(Shown(skeleton, above));
    message.append("; give them by hand, for example ").append(canonical);
    return Status::Error(message.append("=").append(NameOf(skeleton, joint)));
  }
  return Status::Ok();
}

Status NoSides(const Skeleton& skeleton, const TreeReading& reading) {
  return Status::Error(
      "joints: found nothing that tells left from right, neither names nor toes; give one side by "
      "hand, for example leftUpperArm=" +
      NameOf(skeleton, reading.arms.a.joints[kUpper]));
}

Status Doubt(const Skeleton& skeleton, const Difference& difference) {
  const std::string canonical(body::kHumanoid[static_cast<std::size_t>(difference.canonical)].name);
  return Status::Error("joints: found two joints that may be the " + canonical + ", " +
                       Shown(skeleton, difference.one) + " and " +
                       Shown(skeleton, difference.other) + "; give it by hand, for example " +
                       canonical + "=" + NameOf(skeleton, difference.one));
}

bool HasTree(const Skeleton& skeleton) {
  const auto count = skeleton.names.size();
  if (count == 0 || count > kMaxTree || skeleton.parents.size() != count ||
      skeleton.offsets.size() != count || skeleton.parents[0] != -1) {
    return false;
  }
  for (std::size_t j = 1; j < count; ++j) {
    if (skeleton.parents[j] < 0 || skeleton.parents[j] >= static_cast<int>(j)) return false;
    if (!skeleton.offsets[j].allFinite()) return false;
  }
  return true;
}

Result<GivenJoints> ReadGiven(const Skeleton& skeleton, const JointNames& names) {
  GivenJoints given;
  std::vector<int> user(skeleton.names.size(), -1);
  for (const auto& [canonical, name] : names) {
    const auto row = std::find_if(body::kHumanoid.begin(), body::kHumanoid.end(),
                                  [&](const body::JointRow& r) { return r.name == canonical; });
    if (row == body::kHumanoid.end()) {
      return Status::Error("joints: found \"" + canonical +
                           "\", expected a joint of the canonical humanoid, e.g. leftUpperArm");
    }
    const auto c = static_cast<std::size_t>(row - body::kHumanoid.begin());
    const auto joint = std::find(skeleton.names.begin(), skeleton.names.end(), name);
    if (!name.empty() && joint == skeleton.names.end()) {
      std::string message = "joints." + canonical;
      return Status::Error(message.append(": the rig has no joint \"").append(name).append("\""));
    }
    given[c] = name.empty() ? -1 : static_cast<int>(joint - skeleton.names.begin());
    if (name.empty()) continue;
    int& other = user[static_cast<std::size_t>(*given[c])];
    if (other >= 0 && other != static_cast<int>(c)) {
      std::string message = "joints: \"" + name;
      message.append("\" is given for ")
          .append(body::kHumanoid[static_cast<std::size_t>(other)].name);
      return Status::Error(message.append(" and for ").append(canonical));
    }
    other = static_cast<int>(c);
  }
  return given;
}

// Puts the joints given by hand in their places, and takes them from others.
void Put(const GivenJoints& given, JointMap& map) {
  for (std::size_t c = 0; c < given.size(); ++c) {
    if (!given[c]) continue;
    if (*given[c] >= 0) std::replace(map.begin(), map.end(), *given[c], -1);
    map[c] = *given[c];
  }
}

// A skeleton with all that its joints' names say.
struct Named {
  const Skeleton& skeleton;
  GivenJoints given;
  JointMap by_tables;                // MapJointNames
  std::vector<NameReading> names;    // with the sides given by hand
  std::vector<NameReading> by_hand;  // without sides but those
};
// A limb numbered throughout (LeftArm, LeftArm1, LeftArm2, ...) has one word for all of its parts,
// which then says nothing: three and more in a row.
void ForgetNumbered(const Skeleton& skeleton, std::vector<NameReading>& names) {
  std::vector<int> run(names.size(), 1);  // joints in a row, up to this one, with its word
  std::vector<bool> numbered(names.size(), false);
  for (std::size_t j = 1; j < names.size(); ++j) {
    const auto parent = static_cast<std::size_t>(skeleton.parents[j]);
    const std::uint16_t words = names[j].words;
    if (words == 0 || (words & kTrunkParts) != 0 || words != names[parent].words) continue;
    run[j] = run[parent] + 1;
    if (run[j] < 3) continue;
    for (std::size_t up = j; !numbered[up] && names[up].words == words;
         up = static_cast<std::size_t>(skeleton.parents[up])) {
      numbered[up] = true;
      if (skeleton.parents[up] < 0) break;
    }
  }
  for (std::size_t j = 0; j < names.size(); ++j) {
    if (numbered[j]) names[j].words = names[j].hints = 0;
  }
}

Named ReadAll(const Skeleton& skeleton, const GivenJoints& given) {
  Named named{skeleton, given, MapJointNames(skeleton), ReadNames(skeleton.names), {}};
  ForgetNumbered(skeleton, named.names);
  named.by_hand = named.names;
  for (NameReading& name : named.by_hand) name.side = 0;
  for (std::size_t c = 0; c < kJointCount; ++c) {
    if (!given[c] || *given[c] < 0) continue;
    constexpr int kWeight = 4;  // of a limb's other names
    const auto j = static_cast<std::size_t>(*given[c]);
    named.names[j].side = named.by_hand[j].side = kWeight * SideOf(static_cast<int>(c));
  }
  return named;
}

// The tree as it is read, with names or alone; the best reading has its left limbs first.
struct Choice {
  std::vector<TreeReading> read;
  JointMap map{};
  bool by_names = true;
  std::vector<int> contradicting;  // joints whose names say otherwise
};
std::vector<TreeReading> Read(const Named& named, NameUse use) {
  return ReadTree(named.skeleton, use == NameUse::kAll ? named.names : named.by_hand,
                  named.by_tables, use, named.given);
}

// By names where they fit the tree; by the tree alone where several contradict it, or few say
// anything. Nothing: no such tree is there, names alone may tell. Error: sides that nothing tells.
Result<std::optional<Choice>> Choose(const Named& named, const Places& places) {
  std::vector<int> contradicting;
  for (const bool by_names : {true, false}) {
    const NameUse use = by_names                ? NameUse::kAll
                        : contradicting.empty() ? NameUse::kHelpers
                                                : NameUse::kNone;
    Choice choice{Read(named, use), {}, by_names, contradicting};
    if (choice.read.empty()) continue;
    TreeReading& best = choice.read.front();
    const bool sided = PutLeftFirst(best, places);
    choice.map = MapOf(named.skeleton, best, by_names ? named.by_tables : kNone, named.names);
    if (by_names) {
      contradicting = choice.contradicting = Contradictions(choice.map, named.names);
      if (contradicting.size() >= kContradictions) continue;
      if (Confirmed(choice.map, named.names) < kFewWords) continue;
    } else if (best.score < kImplausible ||
               (best.score < kPlausible && AreHelpers(choice.map, named.names))) {
      continue;
    }
    if (!sided) return NoSides(named.skeleton, best);
    return std::optional(std::move(choice));
  }
  return std::optional<Choice>();
}

// The lead of the best reading over the next one. Error: it is a doubt.
Result<float> LeadOf(const Skeleton& skeleton, const std::vector<TreeReading>& read) {
  const TreeReading& best = read.front();
  float lead = std::numeric_limits<float>::infinity();
  for (std::size_t i = 1; i < read.size(); ++i) {
    const auto difference = Differ(best, read[i]);
    if (!difference) continue;
    lead = best.score - read[i].score;
    if (lead < kDoubt) return Doubt(skeleton, *difference);
    break;
  }
  if (best.head_lead < kDoubt) {
    return Doubt(skeleton, {body::kHead, best.head, best.other_head});
  }
  return std::min(lead, best.head_lead);
}

// The contradictions of the choice; "" if nothing contradicts it.
std::string RemarkOn(const Named& named, const Choice& choice, const Places& places) {
  const Skeleton& skeleton = named.skeleton;
  const TreeReading& best = choice.read.front();
  std::string remark;
  const auto say = [&remark](const std::string& sentence) {
    remark += (remark.empty() ? "" : "; ") + sentence;
  };
  const std::vector<int>& contradicting = choice.contradicting;
  if (!contradicting.empty()) {
    const std::string which =
        contradicting.size() == 1
            ? "the name of joint " + Shown(skeleton, contradicting[0]) + " says"
            : "the names of " + std::to_string(contradicting.size()) + " joints, " +
                  Shown(skeleton, contradicting[0]) + " the first, say";
    const auto alone = choice.by_names ? Read(named, NameUse::kNone) : std::vector<TreeReading>();
    if (!choice.by_names) {
      say(which + " another part of the body than the tree, which was followed");
    } else if (!alone.empty() && !SameBody(best, alone.front())) {
      say(which +
          " another part of the body than its place, and the tree alone would be read "
          "otherwise");
    }
  }
  if (places.LeftOf(best) < -kOpposite) {
    say("toes or knees say left where the names say right: sides are exchanged, or the axes are "
        "left-handed");
  }
  if (places.Alike(best.arms, best.legs) < -kOpposite) {
    say("the arm that names call the left one is above the leg that they call the right one");
  }
  const auto second =
      std::find_if(choice.read.begin(), choice.read.end(),
                   [&](const TreeReading& other) { return AreApart(skeleton, best, other); });
  if (second != choice.read.end() && best.score - second->score < kSecondBody) {
    say("a second body, with the head " + Shown(skeleton, second->head) + ", is left out");
  }
  return remark;
}

}  // namespace

Result<HumanoidMap> FindHumanoid(const Skeleton& skeleton, const JointNames& given,
                                 std::span<const RigPose> poses) {
  const auto hand = ReadGiven(skeleton, given);
  if (!hand.ok()) return hand.status();
  if (!HasTree(skeleton)) {
    HumanoidMap map{MapJointNames(skeleton), 0, "by names alone", ""};
    Put(hand.value(), map.joint);
    return map;
  }
  const Named named = ReadAll(skeleton, hand.value());
  const Places places(skeleton, poses);
  const auto choice = Choose(named, places);
  if (!choice.ok()) return choice.status();
  if (!choice.value()) {
    HumanoidMap map{named.by_tables, 0, "by names alone", ""};
    Put(hand.value(), map.joint);
    if (const Status status = CheckOrder(skeleton, map.joint); !status.ok()) return status;
    return map;
  }
  const Choice& chosen = *choice.value();
  const auto lead = LeadOf(skeleton, chosen.read);
  if (!lead.ok()) return lead.status();
  HumanoidMap map{chosen.map, 1 - std::exp(-lead.value()),
                  chosen.by_names ? "by the tree and names" : "by the tree alone",
                  RemarkOn(named, chosen, places)};
  Put(hand.value(), map.joint);
  return map;
}

Result<JointMap> MapJoints(const Skeleton& skeleton, const JointNames& given) {
  const auto map = FindHumanoid(skeleton, given);
  if (!map.ok()) return map.status();
  return map.value().joint;
}

}  // namespace styled::rig
