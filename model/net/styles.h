#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "model/base/status.h"
#include "model/body/pose.h"

namespace styled::net {

// The limits of what a user may request of a network, whatever its family: defined here only.
inline constexpr int kMaxStyles = 32;             // of a weights file, neutral included
inline constexpr int kMaxAdded = 1024;            // the number of additional ones that With adds
                                                  // (stylizer.h)
inline constexpr std::size_t kMaxStyleName = 32;  // bytes of the name of a style that is added
inline constexpr int kMaxMix = 4;                 // the number of styles that a user may mix
inline constexpr int kMaxActive = 8;  // styles in effect: a mix and the one that it fades from
// of a strength, a style's weight, a mix's sum of weights
inline constexpr float kMaxStrength = 1.5F;
inline constexpr float kMaxTransition_s = 60.0F;  // of a style change
// The default fade of a change: 0.4 threw an arm in one switch of nine and made small changes late;
// 0.1 with the limit of the stylist's low-pass (model/stylist/tuning.h) does not. look.proto states
// it, too, and the page (tests/documents/test_look.py).
inline constexpr float kUsualTransition_s = 0.1F;
// Of a style, numbered from 1, where the network has variations; 0 is the style itself.
inline constexpr int kVariations = 99;
inline constexpr float kMaxDrift_s = 600.0F;  // from one variation to the next

// A style whose output is recognized in a smaller share of windows is weak, and users who choose it
// are warned. v2's styles have either 0.8 and more, or 0.7 and less.
inline constexpr float kWeakBelow = 0.8F;

// A style's carriage of trunk, head and collars, in any act: by joint of kPostureJoints, the turn
// from a joint's mean rotation in neutral to that in the style, over the same acts, as a rotation
// vector after the joint's own rotation, rad.
inline constexpr std::array<body::Joint, 6> kPostureJoints{
    body::kSpine, body::kChest,        body::kNeck,
    body::kHead,  body::kLeftShoulder, body::kRightShoulder};
using Posture = std::array<body::Vec3, kPostureJoints.size()>;

struct StyleInfo {
  std::string name;
  std::vector<std::string> aliases;
  // With several networks (several.h): the style's network, and its name there. "" with one
  // network.
  std::string model, original;
  bool varies = false;  // its network has the variations 1 .. kVariations of it
  // The strength of its evidence; 0: not measured. The share of windows of the styled validation
  // clips that a judge recognizes as the style, and the seconds recorded for training.
  float recognized = 0, recorded_s = 0;
  // Mean speed of the style's walks and runs, canonical metres per second; 0: not measured.
  float walk_mps = 0, run_mps = 0;
  // Their mean cadence, steps of either foot per minute; 0: not measured.
  float walk_spm = 0, run_spm = 0;
  std::optional<Posture> posture;  // empty: not measured
  // Where the style's own clips come from, if it owes others than its file: the licence ("CC BY
  // 4.0"), and who is to be credited. "": as the file.
  std::string licence, credit;
  bool designable = false;  // StyleSpace::Design can change its sliders
  // Retired: its name was reassigned, or it can no longer be selected, so FindStyle skips it. It
  // may still be fading out.
  bool retired = false;
};

// It was measured, and is recognized too seldom.
inline bool IsWeak(const StyleInfo& style) {
  return style.recognized > 0 && style.recognized < kWeakBelow;
}

// The styles of a weights file; [0] is neutral. A style's number is its index here.
using Styles = std::vector<StyleInfo>;

// The number of a style by name or alias, case-insensitive; -1 if there is none.
int FindStyle(const Styles& styles, std::string_view name);

// The style itself if it varies, or the style of the same name in a network that has variations; -1
// if there is none.
int VaryingStyle(const Styles& styles, int style);

// Contents, the acts of performers (walk, run, ...), by name, for networks that take them as input.
// A content's number is its index here, or one of the two below.
using Contents = std::vector<std::string>;
inline constexpr std::size_t kMaxContents = 64;
inline constexpr int kContentRecognized = -1;              // by the network, from the frames so far
inline constexpr int kContentUnknown = -2;                 // the network gets none
inline constexpr const char* kUnknownContent = "unknown";  // its name

// The number of a content by name, case-insensitive: "" is kContentRecognized. The error names the
// choices.
Result<int> FindContent(const Contents& contents, std::string_view name);

// A style in effect and its weight; style -1: an unused entry.
struct StyleWeight {
  int style = -1;
  float weight = 0;
};

}  // namespace styled::net
