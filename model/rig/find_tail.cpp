// FindTail: fingers by the tree below the hands, where tables of names do not know them.
#include <algorithm>
#include <array>
#include <cctype>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "model/rig/tail.h"

namespace styled::rig {
namespace {

// Words within the names of a finger's joints: English, Japanese, Chinese. Thumb, index, middle,
// ring, little.
constexpr std::array<std::array<std::string_view, 4>, kFingersPerHand> kFingerWords = {{
    {"thumb", "親指", "拇", "大指"},
    {"index", "point", "人指", "食指"},
    {"mid", "中指", "中指", "中指"},
    {"ring", "薬指", "无名", "無名"},
    {"pink", "little", "小指", "尾指"},
}};

// A chain of joints below a hand.
struct Chain {
  std::vector<int> joints;
  int finger = -1;
  Vec3 begin = Vec3::Zero();  // of its first joint, from the hand in the zero pose
};

class HandChains {
 public:
  HandChains(const Skeleton& skeleton, int hand)
      : skeleton_(skeleton), children_(skeleton.names.size()) {
    for (int j = 1; j < skeleton.joint_count(); ++j) {
      children_[Index(skeleton.parents[Index(j)])].push_back(j);
    }
    Add(hand, Vec3::Zero());
  }

  // The chains that are fingers, each with its finger.
  std::vector<Chain> Fingers() {
    for (Chain& chain : chains_) chain.finger = FingerOf(chain);
    const bool named = std::any_of(chains_.begin(), chains_.end(),
                                   [](const Chain& chain) { return chain.finger >= 0; });
    if (!named && chains_.size() == kFingersPerHand) SortAcross();
    return chains_;
  }

 private:
  static std::size_t Index(int joint) { return static_cast<std::size_t>(joint); }

  // The chains that begin at the children of a joint; a joint of several chains, a palm, is passed.
  void Add(int joint, const Vec3& at) {
    for (const int child : children_[Index(joint)]) {
      const Vec3 begin = at + skeleton_.offsets[Index(child)];
      Chain chain{{child}, -1, begin};
      int last = child;
      while (children_[Index(last)].size() == 1) {
        last = children_[Index(last)].front();
        chain.joints.push_back(last);
      }
      if (children_[Index(last)].size() > 1) {
        Add(last, begin);
      } else if (chain.joints.size() >= 2) {
        chains_.push_back(std::move(chain));
      }
    }
  }

  int FingerOf(const Chain& chain) const {
    for (const int joint : chain.joints) {
      std::string name = skeleton_.names[Index(joint)];
      for (char& c : name) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
      for (std::size_t finger = 0; finger < kFingerWords.size(); ++finger) {
        for (const std::string_view word : kFingerWords[finger]) {
          if (name.find(word) != std::string::npos) return static_cast<int>(finger);
        }
      }
    }
    return -1;
  }

  // Five chains without a word: in order across the palm. The thumb begins at one edge of it, and
  // nearer to the wrist than the finger at the other edge.
  void SortAcross() {
    Vec3 across = Vec3::Zero();
    for (const Chain& a : chains_) {
      for (const Chain& b : chains_) {
        if ((a.begin - b.begin).norm() > across.norm()) across = a.begin - b.begin;
      }
    }
    if (across.isZero()) return;
    std::sort(chains_.begin(), chains_.end(), [&](const Chain& a, const Chain& b) {
      return a.begin.dot(across) < b.begin.dot(across);
    });
    if (chains_.back().begin.norm() < chains_.front().begin.norm()) {
      std::reverse(chains_.begin(), chains_.end());
    }
    for (std::size_t i = 0; i < chains_.size(); ++i) chains_[i].finger = static_cast<int>(i);
  }

  const Skeleton& skeleton_;
  std::vector<std::vector<int>> children_;
  std::vector<Chain> chains_;
};

// The three joints of a finger: of four and more the first three, or the last three where the
// first is a metacarpal, in the palm.
std::array<int, kFingerJoints> JointsOf(const Skeleton& skeleton, const Chain& chain) {
  std::size_t first = 0;
  if (chain.finger > 0 && chain.joints.size() > kFingerJoints) {
    const float next = skeleton.offsets[static_cast<std::size_t>(chain.joints[1])].norm();
    if (chain.begin.norm() < next) first = 1;  // a knuckle is farther from the wrist
  }
  std::array<int, kFingerJoints> joints;
  for (std::size_t i = 0; i < joints.size(); ++i) {
    joints[i] = first + i < chain.joints.size() ? chain.joints[first + i] : -1;
  }
  return joints;
}

}  // namespace

TailMap FindTail(const Skeleton& skeleton, const std::array<int, body::kJointCount>& joints) {
  TailMap map = MapTailNames(skeleton);
  for (const auto& [hand, begin] :
       {std::pair{body::kLeftHand, kTailLeftThumb}, std::pair{body::kRightHand, kTailRightThumb}}) {
    const int joint = joints[static_cast<std::size_t>(hand)];
    if (joint < 0) continue;
    for (const Chain& chain : HandChains(skeleton, joint).Fingers()) {
      if (chain.finger < 0) continue;
      auto* const place = map.data() + begin + chain.finger * kFingerJoints;
      if (std::any_of(place, place + kFingerJoints, [](int known) { return known >= 0; })) continue;
      const auto found = JointsOf(skeleton, chain);
      std::copy(found.begin(), found.end(), place);
    }
  }
  return map;
}

}  // namespace styled::rig
