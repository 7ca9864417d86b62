#include "model/rig/tree_reading.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

namespace styled::rig {
namespace {

using body::kJointCount;

// Scores are log-likelihoods up to a constant: of two readings that differ by 1, one is e times as
// likely. The numbers below were set by hand. Each halved or doubled alone, they bind 1,651 to
// 1,677 of the test's 2,000 random bodies (1,675 as they are), and all of its conventions; silently
// wrong are then 24 with kHintOfAnother doubled, 4 with kSkipped, 2 with kConvention, none
// otherwise.
constexpr float kWord = 1.5F;            // the name is a word for the part
constexpr float kWordOfTwo = 1.0F;       // one that other tools use for another part: "hip", "leg"
constexpr float kConvention = 0.5F;      // a known convention has the name for the part
constexpr float kHint = 0.75F;           // a part of the name is
constexpr float kContradiction = -1.5F;  // the name is a word for another part
constexpr float kHintOfAnother = -0.5F;
constexpr float kOther = -2.5F;  // "hair", "twist": no joint of the humanoid
constexpr float kTwist = -1.0F;
constexpr float kSkipped = -0.3F;     // a joint of a limb that gets no part
constexpr float kPassedOver = -1.0F;  // one that is named for a part beside it
constexpr float kApart = 1.5F;        // limbs of a pair on either side of their parent
constexpr float kNoEnd = -1.0F;       // a limb without hand or foot
constexpr float kNoNeck = -1.0F;
constexpr float kPaired = -2.0F;  // a head of which there are two
constexpr float kByHand = 100.0F;
constexpr int kReach = 5;  // joints looked at below a joint for the next part
constexpr std::size_t kReadingsPerLimb = 6, kPairsKept = 24;
// Children of one joint that are paired, the likeliest. A rig may send 64 chains at one joint, an
// avatar 256: all pairs of them take 62 ms and 1.5 s, those of 16 take 14 and 52 ms.
constexpr std::size_t kBranches = 16;

// A length's ratio against the usual one: the logarithm's likelihood by Student's distribution,
// whose heavy tails leave cartoon figures their proportions.
float Ratio(float length, float other, float usual, float spread) {
  if (!(length > 0) || !(other > 0)) return -2.0F;
  const float off = (std::log(length / other) - std::log(usual)) / spread;
  return -1.5F * std::log1p(off * off / 3.0F);
}

constexpr std::array<Part, kPlaces> kArmParts = {Part::kShoulder, Part::kUpperArm, Part::kLowerArm,
                                                 Part::kHand, Part::kCount};
constexpr std::array<Part, kPlaces> kLegParts = {Part::kCount, Part::kUpperLeg, Part::kLowerLeg,
                                                 Part::kFoot, Part::kToes};

class Reader {
 public:
  // `named`: the map of the tables of conventions.
  Reader(const Skeleton& skeleton, const std::vector<NameReading>& names, const JointMap& named,
         NameUse use, const GivenJoints& given)
      : skeleton_(skeleton),
        names_(names),
        named_(named),
        use_(use),
        names_count_(use == NameUse::kAll),
        given_(given) {
    const auto count = skeleton.names.size();
    children_.resize(count);
    along_.assign(count, 0);
    depth_.assign(count, 0);
    below_.assign(count, 0);
    for (std::size_t j = 1; j < count; ++j) {
      const auto parent = static_cast<std::size_t>(skeleton.parents[j]);
      children_[parent].push_back(static_cast<int>(j));
      along_[j] = along_[parent] + skeleton.offsets[j].norm();
      depth_[j] = depth_[parent] + 1;
    }
    for (std::size_t j = count - 1; j > 0; --j) {
      auto& above = below_[static_cast<std::size_t>(skeleton.parents[j])];
      above = std::max(above, below_[j] + 1);
    }
  }

  // All readings, the best first.
  std::vector<TreeReading> Read() const {
    const std::vector<LimbPair> arms = Pairs(kArm), legs = Pairs(kLeg);
    std::vector<TreeReading> all;
    for (const LimbPair& arm : arms) {
      for (const LimbPair& leg : legs) {
        if (auto found = Join(arm, leg)) all.push_back(*found);
      }
    }
    std::stable_sort(all.begin(), all.end(),
                     [](const TreeReading& a, const TreeReading& b) { return a.score > b.score; });
    return all;
  }

 private:
  int Parent(int joint) const { return skeleton_.parents[static_cast<std::size_t>(joint)]; }
  const std::vector<int>& Children(int joint) const {
    return children_[static_cast<std::size_t>(joint)];
  }
  float Along(int above, int below) const {
    return along_[static_cast<std::size_t>(below)] - along_[static_cast<std::size_t>(above)];
  }
  int Depth(int joint) const { return depth_[static_cast<std::size_t>(joint)]; }

  // The canonical joints of a part, left and right; twice the same in the middle.
  static std::pair<int, int> Canonical(Part part) {
    constexpr std::array<int, static_cast<std::size_t>(Part::kCount)> kLeft = {
        body::kHips,     body::kSpine,        body::kChest,        body::kNeck,
        body::kHead,     body::kLeftShoulder, body::kLeftUpperArm, body::kLeftLowerArm,
        body::kLeftHand, body::kLeftUpperLeg, body::kLeftLowerLeg, body::kLeftFoot,
        body::kLeftToes};
    const int left = kLeft[static_cast<std::size_t>(part)];
    return {left, body::MirrorJoint(left)};
  }
  // Whether the name is a word for one part alone.
  static bool IsSpecific(const NameReading& name) { return std::has_single_bit(name.words); }
  // How well a joint's name fits a part; a joint given by hand fits nothing else.
  float Name(Part part, int joint) const {
    if (part == Part::kCount) return 0;
    const NameReading& name = names_[static_cast<std::size_t>(joint)];
    if (name.end && Children(joint).empty()) return kOther;
    if (use_ == NameUse::kNone) return 0;
    if (name.other) return kOther;
    if (!names_count_) return 0;
    float score = name.twist ? kTwist : 0;
    const auto [left, right] = Canonical(part);
    if (named_[static_cast<std::size_t>(left)] == joint ||
        named_[static_cast<std::size_t>(right)] == joint) {
      score += kConvention;
    }
    if (name.Says(part)) return score + (IsSpecific(name) ? kWord : kWordOfTwo);
    // Many tools number the whole trunk, neck and head included, as a spine.
    if (name.words != 0 && (name.words & kTrunkParts) != 0 && IsTrunk(part)) return kHintOfAnother;
    if (name.words != 0) return score + (name.Hints(part) ? 0 : kContradiction);
    if (name.Hints(part)) return score + kHint;
    return score + (name.hints != 0 ? kHintOfAnother : 0);
  }

  // For joints given by hand: in favour of one of the part's joints, or against it, because it is
  // another's.
  float Hand(Part part, int joint) const {
    if (part == Part::kCount) return 0;
    const auto [left, right] = Canonical(part);
    float score = 0;
    for (int c = 0; c < kJointCount; ++c) {
      const auto& given = given_[static_cast<std::size_t>(c)];
      if (!given || *given != joint) continue;
      score += c == left || c == right ? kByHand : -kByHand;
    }
    return score;
  }
  float Score(Part part, int joint) const { return Name(part, joint) + Hand(part, joint); }

  // The joints below `above`, within reach, with the number of joints between.
  template <typename Visit>
  void Below(int above, int reach, const Visit& visit, int between = 0) const {
    if (reach == 0) return;
    for (const int child : Children(above)) {
      visit(child, between);
      Below(child, reach - 1, visit, between + 1);
    }
  }

  // The readings of the subtree of `root` as one limb, the best first.
  std::vector<Limb> Limbs(int root, Kind kind) const {
    const auto& parts = kind == kArm ? kArmParts : kLegParts;
    std::vector<Limb> limbs;
    const auto from_upper = [&](int upper, int skipped) {
      Below(upper, kReach, [&](int lower, int between) {
        const float length = Along(upper, lower);
        if (!(length > 0)) return;
        if (kind == kLeg && Children(lower).empty()) return;  // an arm may lack its hand
        Limb limb;
        limb.joints[kUpper] = upper;
        limb.joints[kLower] = lower;
        limb.upper = length;
        limb.score = Score(parts[kUpper], upper) + Score(parts[kLower], lower) +
                     kSkipped * static_cast<float>(between) + PassedOver(upper, lower, parts) +
                     (between > 0 ? Crooked(upper, lower) : 0);
        AddEnd(parts, kind, limb);
        AddFirst(parts, kind, root, skipped, limb);
        for (const int joint : limb.joints) {
          if (joint >= 0) limb.side += names_[static_cast<std::size_t>(joint)].side;
        }
        limbs.push_back(limb);
      });
    };
    from_upper(root, 0);
    Below(root, kReach, [&](int upper, int between) { from_upper(upper, between + 1); });
    std::stable_sort(limbs.begin(), limbs.end(),
                     [](const Limb& a, const Limb& b) { return a.score > b.score; });
    if (limbs.size() > kReadingsPerLimb) limbs.resize(kReadingsPerLimb);
    return limbs;
  }

  // A twist joint lies on the bone that it turns; a helper of the hips beside it. `from` to `to` by
  // the offsets of the zero pose.
  float Crooked(int from, int to) const {
    return -std::min(2.0F, 20.0F * (1.0F - Straight(from, to).norm() / Along(from, to)));
  }
  // From a joint to one below it in the zero pose.
  Vec3 Straight(int from, int to) const {
    Vec3 straight = Vec3::Zero();
    for (int up = to; up != from; up = Parent(up)) {
      straight += skeleton_.offsets[static_cast<std::size_t>(up)];
    }
    return straight;
  }

  // Joints between upper and lower whose names are words for these very parts.
  float PassedOver(int upper, int lower, const std::array<Part, kPlaces>& parts) const {
    float score = 0;
    for (int up = Parent(lower); names_count_ && up != upper; up = Parent(up)) {
      const NameReading& name = names_[static_cast<std::size_t>(up)];
      if (!IsSpecific(name) || name.other || name.twist) continue;
      if (name.Says(parts[kUpper]) || name.Says(parts[kLower])) score += kPassedOver;
    }
    return score;
  }

  void AddEnd(const std::array<Part, kPlaces>& parts, Kind kind, Limb& limb) const {
    const int lower = limb.joints[kLower];
    float best = kNoEnd;
    Below(lower, kReach, [&](int end, int between) {
      const float length = Along(lower, end);
      if (!(length > 0)) return;
      float score = Score(parts[kEnd], end) + kSkipped * static_cast<float>(between) +
                    (kind == kArm ? Ratio(length, limb.upper, 0.93F, 0.25F)
                                  : Ratio(length, limb.upper, 1.0F, 0.25F));
      if (kind == kArm && Children(end).size() >= 3) score += 0.5F;  // fingers
      if (score <= best) return;
      best = score;
      limb.joints[kEnd] = end;
      limb.lower = length;
    });
    limb.score += best;
    const int end = limb.joints[kEnd];
    if (kind == kArm || end < 0) return;
    float best_tip = -0.3F;  // many rigs have no toes
    Below(end, kReach, [&](int tip, int between) {
      const float score = Score(Part::kToes, tip) + kSkipped * static_cast<float>(between) +
                          Ratio(Along(end, tip), limb.lower, 0.35F, 0.5F);
      if (score <= best_tip) return;
      best_tip = score;
      limb.joints[kTip] = tip;
    });
    limb.score += best_tip;
  }

  // The shoulder among the joints above the upper arm; for a leg these are only skipped.
  void AddFirst(const std::array<Part, kPlaces>& parts, Kind kind, int root, int skipped,
                Limb& limb) const {
    const auto all = static_cast<float>(skipped);
    if (skipped == 0 || kind == kLeg) {
      limb.score += kSkipped * all;
      return;
    }
    float best = kSkipped * all;
    for (int up = Parent(limb.joints[kUpper]);; up = Parent(up)) {
      const float score = Score(parts[kFirst], up) + kSkipped * (all - 1) +
                          Ratio(Along(up, limb.joints[kUpper]), limb.upper, 0.5F, 1.0F);
      if (score > best) {
        best = score;
        limb.joints[kFirst] = up;
      }
      if (up == root) break;
    }
    limb.score += best;
  }

  // A child of a joint with its readings as a limb, the best first.
  struct Branch {
    int root;
    std::vector<Limb> limbs;
  };
  // The likely limbs among a joint's children, in the order of the skeleton.
  std::vector<Branch> Branches(int parent, Kind kind) const {
    std::vector<Branch> branches;
    for (const int child : Children(parent)) {
      if (Children(parent).size() < 2 || below_[static_cast<std::size_t>(child)] < 1) continue;
      std::vector<Limb> limbs = Limbs(child, kind);
      if (!limbs.empty()) branches.push_back({child, std::move(limbs)});
    }
    if (branches.size() <= kBranches) return branches;
    const auto better = [](const Branch& a, const Branch& b) {
      return a.limbs.front().score > b.limbs.front().score;
    };
    std::stable_sort(branches.begin(), branches.end(), better);
    branches.resize(kBranches);
    std::sort(branches.begin(), branches.end(),
              [](const Branch& a, const Branch& b) { return a.root < b.root; });
    return branches;
  }

  // Limbs that begin at two children of one joint and are alike in lengths.
  std::vector<LimbPair> Pairs(Kind kind) const {
    std::vector<LimbPair> pairs;
    for (std::size_t parent = 0; parent < children_.size(); ++parent) {
      const std::vector<Branch> all = Branches(static_cast<int>(parent), kind);
      for (std::size_t x = 0; x < all.size(); ++x) {
        for (std::size_t y = x + 1; y < all.size(); ++y) {
          for (const Limb& a : all[x].limbs) {
            for (const Limb& b : all[y].limbs) {
              float score = a.score + b.score + Ratio(a.upper, b.upper, 1.0F, 0.1F) +
                            ((a.lower > 0) != (b.lower > 0) ? -2.0F : 0);
              score += Apart(static_cast<int>(parent), a.joints[kUpper], b.joints[kUpper]);
              if (a.lower > 0 && b.lower > 0) score += Ratio(a.lower, b.lower, 1.0F, 0.1F);
              if ((a.joints[kFirst] < 0) != (b.joints[kFirst] < 0)) score -= 0.5F;
              if ((a.joints[kTip] < 0) != (b.joints[kTip] < 0)) score -= 0.5F;
              if (names_count_ && a.side != 0 && b.side != 0) {
                score += (a.side > 0) != (b.side > 0) ? 1.0F : -2.0F;
              }
              if (score < -16) continue;
              pairs.push_back({a, b, static_cast<int>(parent), all[x].root, all[y].root, score});
            }
          }
        }
      }
    }
    std::stable_sort(pairs.begin(), pairs.end(),
                     [](const LimbPair& a, const LimbPair& b) { return a.score > b.score; });
    if (pairs.size() > kPairsKept) pairs.resize(kPairsKept);
    return pairs;
  }

  // Whether two children of a joint are equally far from it and have equally long chains below.
  bool Alike(int a, int b) const {
    const float far = skeleton_.offsets[static_cast<std::size_t>(a)].norm();
    const float other = skeleton_.offsets[static_cast<std::size_t>(b)].norm();
    return std::abs(far - other) <= 0.02F * far &&
           below_[static_cast<std::size_t>(a)] == below_[static_cast<std::size_t>(b)];
  }

  // Two limbs of a pair begin equally far from their parent and not at the same place, as far as
  // the offsets of the zero pose tell.
  float Apart(int parent, int a, int b) const {
    const Vec3 to_a = Straight(parent, a), to_b = Straight(parent, b);
    const float lengths = to_a.norm() + to_b.norm();
    if (!(lengths > 0)) return 0;
    const float longer = std::max(to_a.norm(), to_b.norm());
    return kApart *
           ((to_a - to_b).norm() / lengths - 4 * std::abs(to_a.norm() - to_b.norm()) / longer);
  }

  bool IsAbove(int above, int joint) const {
    while (joint >= 0 && Depth(joint) > Depth(above)) joint = Parent(joint);
    return joint == above;
  }
  int Common(int a, int b) const {
    while (a != b) (Depth(a) >= Depth(b) ? a : b) = Parent(Depth(a) >= Depth(b) ? a : b);
    return a;
  }

  std::optional<TreeReading> Join(const LimbPair& arms, const LimbPair& legs) const {
    for (const int arm : {arms.root_a, arms.root_b}) {
      for (const int leg : {legs.root_a, legs.root_b}) {
        if (IsAbove(arm, leg) || IsAbove(leg, arm)) return std::nullopt;
      }
    }
    TreeReading found;
    found.arms = arms;
    found.legs = legs;
    const int common = Common(arms.parent, legs.parent);
    found.score = arms.score + legs.score;
    // Rigs hang the legs from the hips or from a joint or two below them.
    found.score += -0.3F * static_cast<float>(Depth(legs.parent) - Depth(common));
    if (arms.parent == common) found.score -= 3;  // no trunk
    found.score += Ratio(legs.a.upper + legs.b.upper, arms.a.upper + arms.b.upper, 1.55F, 0.35F);
    found.score += Ratio(Along(common, arms.parent), legs.a.upper, 0.8F, 0.5F);
    // The hips are where limbs and trunk part, or a joint above it that is named so.
    float best = -std::numeric_limits<float>::infinity();
    int steps = 0;
    for (int up = common; up >= 0; up = Parent(up), ++steps) {
      const float score = Score(Part::kHips, up) - 0.6F * static_cast<float>(steps);
      if (score > best) {
        best = score;
        found.hips = up;
      }
    }
    found.score += best;
    AddHead(found);
    if (found.head < 0) return std::nullopt;
    return found;
  }

  struct Head {
    int head = -1, neck = -1;
    float score = -6;
  };
  // Neck and head: a chain from the arms' parent that is neither an arm nor leads to the legs.
  void AddHead(TreeReading& found) const {
    Head best, next;
    for (const int first : Children(found.arms.parent)) {
      const auto is = [first](int root) { return first == root; };
      if (is(found.arms.root_a) || is(found.arms.root_b) || is(found.legs.root_a) ||
          is(found.legs.root_b) || IsAbove(first, found.legs.parent)) {
        continue;
      }
      const Head here = HeadFrom(first, found);
      if (here.score > best.score) {
        next = std::exchange(best, here);
      } else if (here.score > next.score) {
        next = here;
      }
    }
    found.head = best.head;
    found.neck = best.neck;
    found.other_head = next.head;
    if (next.head >= 0) found.head_lead = best.score - next.score;
    found.score += best.score;
  }

  Head HeadFrom(int first, const TreeReading& found) const {
    Head best;
    // A second pair of arms, wings: there is another like it.
    const auto& siblings = Children(found.arms.parent);
    const bool paired = std::any_of(siblings.begin(), siblings.end(), [&](int other) {
      return other != first && Alike(first, other);
    });
    const auto consider = [&](int head) {
      Head here = NeckOf(head, found);
      if (paired) here.score += kPaired;
      here.score += Score(Part::kHead, head);
      if (names_count_ && names_[static_cast<std::size_t>(head)].side != 0) here.score -= 2;
      if (Children(head).size() >= 2) here.score += 0.2F;  // eyes, a jaw, hair
      if (here.score > best.score) best = here;
    };
    consider(first);
    Below(first, kReach, [&](int head, int) { consider(head); });
    return best;
  }

  // The neck of a head: of the joints between it and the arms' parent the one that is named so, or
  // the lowest. In rigs that hang the arms from the neck it is their parent.
  Head NeckOf(int head, const TreeReading& found) const {
    const int chest = found.arms.parent;
    const int between = Depth(head) - Depth(chest) - 1;
    Head best{head, -1, kNoNeck + kSkipped * static_cast<float>(between)};
    const auto consider = [&](int neck, float score) {
      if (score > best.score) best = {head, neck, score};
    };
    for (int up = Parent(head); up != chest; up = Parent(up)) {
      // Of equals the lowest, by the small addition.
      consider(up, Score(Part::kNeck, up) + kSkipped * static_cast<float>(between - 1) +
                       0.01F * static_cast<float>(Depth(head) - Depth(up)));
    }
    if (names_count_ && chest != found.hips &&
        names_[static_cast<std::size_t>(chest)].Says(Part::kNeck)) {
      consider(chest, Score(Part::kNeck, chest) + kSkipped * static_cast<float>(between));
    }
    return best;
  }

  const Skeleton& skeleton_;
  const std::vector<NameReading>& names_;
  const JointMap& named_;
  NameUse use_;
  bool names_count_;
  const GivenJoints& given_;
  std::vector<std::vector<int>> children_;
  std::vector<float> along_;  // length of the path from the root
  std::vector<int> depth_, below_;
};

}  // namespace

std::vector<TreeReading> ReadTree(const Skeleton& skeleton, const std::vector<NameReading>& names,
                                  const JointMap& named, NameUse use, const GivenJoints& given) {
  return Reader(skeleton, names, named, use, given).Read();
}

}  // namespace styled::rig
