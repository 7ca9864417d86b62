#include "proto/arkit/shapes.h"

#include <algorithm>

namespace styled::arkit {
namespace {

constexpr std::string_view kLeft = "Left", kRight = "Right";

char Lower(char c) noexcept { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }

bool Same(std::string_view a, std::string_view b) noexcept {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](char x, char y) { return Lower(x) == Lower(y); });
}

// Whether `name` has a side as _L or _R, as iFacialMocap writes it.
bool IsShort(std::string_view name, const Sided& sided) noexcept {
  return sided.side != 0 && name.size() == sided.stem.size() + 2 &&
         name[sided.stem.size()] == '_' && Lower(name.back()) == Lower(sided.side) &&
         Same(name.substr(0, sided.stem.size()), sided.stem);
}

constexpr std::size_t Index(std::string_view name) {
  return static_cast<std::size_t>(std::find(kNames.begin(), kNames.end(), name) - kNames.begin());
}

}  // namespace

Sided SideOf(std::string_view name) noexcept {
  const bool direction = name.starts_with("jaw") || name == "mouthLeft" || name == "mouthRight";
  if (direction) return {name};
  if (name.ends_with(kLeft)) return {name.substr(0, name.size() - kLeft.size()), 'L'};
  if (name.ends_with(kRight)) return {name.substr(0, name.size() - kRight.size()), 'R'};
  return {name};
}

std::optional<std::size_t> Find(std::string_view name) noexcept {
  for (std::size_t i = 0; i < kShapes; ++i) {
    if (Same(name, kNames[i]) || IsShort(name, SideOf(kNames[i]))) return i;
  }
  return std::nullopt;
}

void ToPresets(std::span<const float, kShapes> shapes,
               std::span<float, kPresets.size()> presets) noexcept {
  const auto mean = [&shapes](std::size_t left, std::size_t right) {
    return (shapes[left] + shapes[right]) / 2;
  };
  constexpr std::size_t kJaw = Index("jawOpen"), kFunnel = Index("mouthFunnel"),
                        kPucker = Index("mouthPucker");
  static_assert(kJaw < kShapes && kFunnel < kShapes && kPucker < kShapes);
  const float smile = mean(Index("mouthSmileLeft"), Index("mouthSmileRight"));
  const float stretch = mean(Index("mouthStretchLeft"), Index("mouthStretchRight"));
  const float frown = mean(Index("mouthFrownLeft"), Index("mouthFrownRight"));
  const float brows = mean(Index("browDownLeft"), Index("browDownRight"));
  const float jaw = shapes[kJaw], round = std::max(shapes[kFunnel], shapes[kPucker]);
  const float wide = std::max(smile, stretch);
  // The jaw opens A, round lips turn it into O; lips alone are U, I and E by how open they are.
  const std::array<float, kPresets.size()> made{
      shapes[Index("eyeBlinkLeft")],
      shapes[Index("eyeBlinkRight")],
      jaw * (1 - round) * (1 - stretch),
      stretch * (1 - jaw),
      shapes[kPucker] * (1 - jaw),
      stretch * jaw,
      round * jaw,
      smile * (1 - frown),
      brows * (1 - smile),
      std::max(frown, shapes[Index("browInnerUp")] * (1 - wide)) * (1 - smile),
      0};
  std::transform(made.begin(), made.end(), presets.begin(),
                 [](float weight) { return std::clamp(weight, 0.0F, 1.0F); });
}

}  // namespace styled::arkit
