#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace styled::net {

// What a user may ask of a network, whatever its family: the one place for these limits.
inline constexpr int kMaxStyles = 32;             // of a weights file, neutral included
inline constexpr int kMaxMix = 4;                 // styles that a user may mix
inline constexpr int kMaxActive = 8;              // styles in force at once: a mix and the one it
                                                  // fades from
inline constexpr float kMaxStrength = 1.5F;       // of a strength, of a style's weight, and of the
                                                  // sum of a mix's weights
inline constexpr float kMaxTransition_s = 60.0F;  // of a change of style

struct StyleInfo {
  std::string name;
  std::vector<std::string> aliases;
};

// The styles of a weights file; [0] is neutral. A style's number is its place in here.
using Styles = std::vector<StyleInfo>;

// The number of a style by name or alias, case-insensitive; -1 if there is none.
int FindStyle(const Styles& styles, std::string_view name);

// A style in force and its weight; style -1: an unused entry.
struct StyleWeight {
  int style = -1;
  float weight = 0;
};

}  // namespace styled::net
