#include "clients/stylectl/suggest.h"

#include <algorithm>
#include <cctype>
#include <limits>
#include <vector>

namespace styled::stylectl {
namespace {

std::string Lower(std::string_view text) {
  std::string lower(text);
  for (char& c : lower) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return lower;
}

}  // namespace

int Distance(std::string_view a, std::string_view b) {
  const std::string from = Lower(a), to = Lower(b);
  const std::size_t width = to.size() + 1;
  // The distance table of "optimal string alignment": at(i, k) is the distance of the first i
  // characters of `from` to the first k of `to`.
  std::vector<int> cells((from.size() + 1) * width);
  const auto at = [&](std::size_t i, std::size_t k) -> int& { return cells[i * width + k]; };
  for (std::size_t i = 0; i <= from.size(); ++i) at(i, 0) = static_cast<int>(i);
  for (std::size_t k = 0; k <= to.size(); ++k) at(0, k) = static_cast<int>(k);
  for (std::size_t i = 1; i <= from.size(); ++i) {
    for (std::size_t k = 1; k <= to.size(); ++k) {
      const int replace = at(i - 1, k - 1) + (from[i - 1] == to[k - 1] ? 0 : 1);
      at(i, k) = std::min({at(i - 1, k) + 1, at(i, k - 1) + 1, replace});
      if (i > 1 && k > 1 && from[i - 1] == to[k - 2] && from[i - 2] == to[k - 1]) {
        at(i, k) = std::min(at(i, k), at(i - 2, k - 2) + 1);
      }
    }
  }
  return at(from.size(), to.size());
}

std::string Nearest(std::string_view wrong, std::span<const std::string> names) {
  std::string best;
  int best_distance = std::numeric_limits<int>::max();
  const std::string low = Lower(wrong);
  for (const std::string& name : names) {
    const std::string other = Lower(name);
    int distance = Distance(low, other);
    const int allowed = std::max<int>(2, static_cast<int>(std::max(low.size(), other.size()) / 3));
    const bool begins =
        low.size() >= 3 && other.size() >= 3 && (other.starts_with(low) || low.starts_with(other));
    if (begins) distance = std::min(distance, 1);
    if (distance > allowed || distance >= static_cast<int>(other.size())) continue;
    if (distance < best_distance) {
      best_distance = distance;
      best = name;
    }
  }
  return best;
}

std::string Join(std::span<const std::string> names) {
  std::string out;
  for (const std::string& name : names) out += (out.empty() ? "" : ", ") + name;
  return out;
}

}  // namespace styled::stylectl
