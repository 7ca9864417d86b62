#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <string_view>

#include "model/base/realtime.h"

// The 52 facial expressions of Apple's ARKit, which phones measure, and their mapping to avatars
// that only have VRM's presets. Pure functions; any thread; nothing here allocates or throws.
// Pinned by tests/unit/arkit.
namespace styled::arkit {

inline constexpr std::size_t kShapes = 52;

// In the order in which Live Link Face sends them; ARKit's own spelling.
inline constexpr std::array<std::string_view, kShapes> kNames{
    "eyeBlinkLeft",      "eyeLookDownLeft",    "eyeLookInLeft",
    "eyeLookOutLeft",    "eyeLookUpLeft",      "eyeSquintLeft",
    "eyeWideLeft",       "eyeBlinkRight",      "eyeLookDownRight",
    "eyeLookInRight",    "eyeLookOutRight",    "eyeLookUpRight",
    "eyeSquintRight",    "eyeWideRight",       "jawForward",
    "jawLeft",           "jawRight",           "jawOpen",
    "mouthClose",        "mouthFunnel",        "mouthPucker",
    "mouthLeft",         "mouthRight",         "mouthSmileLeft",
    "mouthSmileRight",   "mouthFrownLeft",     "mouthFrownRight",
    "mouthDimpleLeft",   "mouthDimpleRight",   "mouthStretchLeft",
    "mouthStretchRight", "mouthRollLower",     "mouthRollUpper",
    "mouthShrugLower",   "mouthShrugUpper",    "mouthPressLeft",
    "mouthPressRight",   "mouthLowerDownLeft", "mouthLowerDownRight",
    "mouthUpperUpLeft",  "mouthUpperUpRight",  "browDownLeft",
    "browDownRight",     "browInnerUp",        "browOuterUpLeft",
    "browOuterUpRight",  "cheekPuff",          "cheekSquintLeft",
    "cheekSquintRight",  "noseSneerLeft",      "noseSneerRight",
    "tongueOut"};

// A shape's name without its side, and 'L' or 'R'; 0 for a shape of both sides. mouthLeft and
// jawLeft are directions, not sides.
struct Sided {
  std::string_view stem;
  char side = 0;
};
STYLED_REALTIME Sided SideOf(std::string_view name) noexcept;

// The index of a shape's name: in any case, with Left and Right at the end or _L and _R. Empty for
// other names.
STYLED_REALTIME std::optional<std::size_t> Find(std::string_view name) noexcept;

// VRM 0's presets of a face, by the names that VMC sends. An avatar without the 52 shows these.
inline constexpr std::array<std::string_view, 11> kPresets{
    "Blink_L", "Blink_R", "A", "I", "U", "E", "O", "Joy", "Angry", "Sorrow", "Fun"};

// Maps the 52 weights, 0 .. 1 each, to the presets. Vowels come from the opening of the jaw and the
// shape of the lips. The shapes that make up a preset are not sent in addition to it, so nothing
// adds up twice. This is our own mapping: no standard has one.
STYLED_REALTIME void ToPresets(std::span<const float, kShapes> shapes,
                               std::span<float, kPresets.size()> presets) noexcept;

}  // namespace styled::arkit
