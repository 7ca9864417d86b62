#include "model/body/parts.h"

#include <algorithm>

namespace styled::body {
namespace {

// The parts that one word names; 0 if the word is unknown.
Parts FindWord(std::string_view word) {
  constexpr Parts kArms = Bit(Part::kLeftArm) | Bit(Part::kRightArm);
  if (word == "all") return kAllParts;
  if (word == "arms") return kArms;
  if (word == "legs") return Bit(Part::kLeftLeg) | Bit(Part::kRightLeg);
  if (word == "upper") return kArms | Bit(Part::kHead) | Bit(Part::kTorso);
  for (std::size_t i = 0; i < kPartNames.size(); ++i) {
    if (word == kPartNames[i]) return static_cast<Parts>(1U << i);
  }
  return 0;
}

}  // namespace

std::optional<Parts> FindParts(std::string_view list) {
  Parts parts = 0;
  for (;;) {
    const std::size_t comma = std::min(list.find(','), list.size());
    const Parts some = FindWord(list.substr(0, comma));
    if (some == 0) return std::nullopt;
    parts |= some;
    if (comma == list.size()) return parts;
    list.remove_prefix(comma + 1);
  }
}

std::string PartsText(Parts parts) {
  if (parts == kAllParts) return "all";
  std::string text;
  for (std::size_t i = 0; i < kPartNames.size(); ++i) {
    if ((parts >> i & 1U) == 0) continue;
    if (!text.empty()) text += ',';
    text += kPartNames[i];
  }
  return text;
}

}  // namespace styled::body
