#include "model/train/flags.h"

#include <cmath>
#include <optional>

#include "model/base/text.h"

namespace styled::train {
namespace {

std::optional<double> NumberOf(const Flag& flag) {
  if (const auto* const real = std::get_if<double*>(&flag.value)) return **real;
  if (const auto* const whole = std::get_if<int*>(&flag.value)) return **whole;
  return std::nullopt;
}

}  // namespace

Status RefuseNumber(const std::string& flag, double found, const std::string& expected) {
  return Status::Error(flag + ": found " + NumberText(found) + ", expected " + expected);
}

Status CheckRanges(const std::vector<FlagGroup>& groups) {
  for (const FlagGroup& group : groups) {
    for (const Flag& flag : group.flags) {
      const std::optional<double> value = NumberOf(flag);
      if (!value || flag.range == Range::kAny) continue;
      if (flag.range == Range::k0To1 && !(*value >= 0 && *value <= 1)) {
        return RefuseNumber(flag.name, *value, "a number from 0 to 1");
      }
      const double least = flag.range == Range::kAtLeast1 ? 1 : 0;
      if (*value >= least && std::isfinite(*value)) continue;
      return RefuseNumber(flag.name, *value, least == 1 ? "1 or more" : "a number, 0 or more");
    }
  }
  return Status::Ok();
}

}  // namespace styled::train
